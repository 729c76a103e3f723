# Copyright 2026 squeal_ros developers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The mechanism of one unstable mode, from its vectors and the spectrum without rotation."""

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_core.stability.mechanism import contributions, Label, without_rotation

_SAME_MODE = 0.02  # relative; rotation splits the doublets of a disc by less, at its speeds


def likely_mechanism(model: BrakeModel, point: OperatingPoint, eigenvalue: complex, *,
                     tolerances: Tolerances | None = None) -> Label:
    """
    Return the label of `mechanisms` for an oscillating mode at a hundredth of its cost.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Operating point.
    eigenvalue : complex
        Of the mode [1/s], to within its distance from the others.
    tolerances : Tolerances, optional
        Of the classification of eigenvalues.

    Notes
    -----
    The rule is that of `mechanisms`, and modes are not followed: without rotation the mode is any
    that grows at its frequency, and a term is needed if it contributes the whole growth rate.

    """
    limits = tolerances or Tolerances.of(model, point)
    if eigenvalue.real <= limits.growth:
        return 'stable'
    added = contributions(model, point, mode_vectors(model, point, eigenvalue))
    needed = {name for name, value in added.items() if value >= eigenvalue.real}
    if 'friction_couple' in needed and _grows_without_rotation(model, point, eigenvalue, limits):
        return 'mode coupling'
    if 'negative_slope' in needed:
        return 'negative slope'
    return 'gyroscopic' if 'friction_couple' in needed else 'combined'


def _grows_without_rotation(model: BrakeModel, point: OperatingPoint, eigenvalue: complex,
                            limits: Tolerances) -> bool:
    frequency = abs(eigenvalue.imag) / (2.0 * np.pi)
    found = complex_modes(without_rotation(model), point, tolerances=limits)
    return any(mode.kind == 'flutter' and abs(mode.frequency_hz / frequency - 1.0) < _SAME_MODE
               for mode in found.unstable)

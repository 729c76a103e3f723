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

"""The mechanism of unstable modes, from their vectors and the spectrum without rotation."""

from dataclasses import replace
import math

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_core.stability.mechanism import contributions, Label, without_rotation

_SAME_MODE = 0.02  # relative; rotation splits the doublets of a disc by less, at its speeds
_FRICTION_STEP = 0.002  # of the spectra without rotation, which depend on little else


class LikelyMechanism:
    """
    Labels modes as `mechanisms` does, at a hundredth of its cost.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    tolerances : Tolerances, optional
        Of the classification of eigenvalues.

    Notes
    -----
    The rule is that of `mechanisms`, and modes are not followed: without rotation the mode is any
    that grows at its frequency, and a term is needed if it contributes the whole growth rate.

    """

    def __init__(self, model: BrakeModel, *, tolerances: Tolerances | None = None) -> None:
        self._model, self._limits = model, tolerances or Tolerances.of(model)
        self._still = without_rotation(model)
        self._growing: dict[tuple[float, ...], tuple[float, ...]] = {}  # Hz, without rotation

    def label(self, point: OperatingPoint, eigenvalue: complex) -> Label:
        """
        Return the label of an oscillating mode.

        Parameters
        ----------
        point : OperatingPoint
            Operating point.
        eigenvalue : complex
            Of the mode [1/s], to within its distance from the others.

        """
        growth = eigenvalue.real
        if growth <= self._limits.growth:
            return 'stable'
        added = contributions(self._model, point, mode_vectors(self._model, point, eigenvalue))
        needed = {name for name, value in added.items() if value >= growth}
        if 'friction_couple' in needed and self._grows_without_rotation(point, eigenvalue):
            return 'mode coupling'
        if 'negative_slope' in needed:
            return 'negative slope'
        return 'gyroscopic' if 'friction_couple' in needed else 'combined'

    def _grows_without_rotation(self, point: OperatingPoint, eigenvalue: complex) -> bool:
        frequency = abs(eigenvalue.imag) / (2.0 * math.pi)
        friction = _FRICTION_STEP * round(point.friction / _FRICTION_STEP)
        key = (friction, point.contact_stiffness, point.damping_scale,
               0.0 if self._model.follower is None else point.contact_pressure)
        if key not in self._growing:
            result = complex_modes(self._still, replace(point, friction=friction),
                                   tolerances=self._limits)
            self._growing[key] = tuple(mode.frequency_hz for mode in result.unstable
                                       if mode.kind == 'flutter')
        return any(abs(other / frequency - 1.0) < _SAME_MODE for other in self._growing[key])

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

"""
Build-up of the modes of one brake, with modes from a table or full solutions.

A mode is followed from tick to tick by its eigenvalue: old and new modes are assigned one to one
with the least sum of distances. Where two modes merge, both have the energy of the pair from then
on, as their vectors are one.
"""

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, RealArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.build_up import grown, halves, nepers, noise_decay
from squeal_core.stability.eigensolution import complex_modes

FARTHEST = 0.02  # distance of a mode from itself a tick before, of its frequency
MERGED = 0.002  # distance within which two modes share their energy, of their frequency
LONGEST_INTERVAL = 0.5  # s between ticks, beyond which what was between them is unknown


class TrackedBuildUp:
    """
    Build-up of the oscillating modes of one brake over its applications.

    Parameters
    ----------
    frequency_hz, decay_rate : (K,) arrays
        Of the modes without friction [Hz], [1/s]: noise holds the nearest mode by its decay.

    """

    def __init__(self, frequency_hz: FloatArray, decay_rate: FloatArray) -> None:
        self._frequency, self._decay = frequency_hz, noise_decay(decay_rate, frequency_hz)
        self.release(0)

    @classmethod
    def of(cls, model: BrakeModel, point: OperatingPoint) -> 'TrackedBuildUp':
        """Return that of a model, with the modes that it has at a point without friction."""
        still = complex_modes(model, OperatingPoint(**{
            **vars(point), 'friction': 0.0, 'friction_slope': 0.0})).oscillatory
        return cls(still.imag / (2.0 * np.pi), -still.real)

    def release(self, time_ns: int) -> None:
        """Take a tick at which the brake is released: all modes are at their floors."""
        self._time = time_ns
        self._roots: ComplexArray = np.empty(0, complex)
        self._energy: RealArray = np.empty(0)

    def update(self, time_ns: int, eigenvalues: ComplexArray, cap: float) -> FloatArray:
        """
        Return the build-up of each mode [nepers].

        Parameters
        ----------
        time_ns : int
            The tick.
        eigenvalues : (n,) array
            Eigenvalues of the modes then [1/s], Im > 0; those that a table omits may be missing,
            and begin at their floors again where they come back.
        cap : float
            `saturation_energy` then.

        """
        duration = 1e-9 * (time_ns - self._time)
        decay = self._decay[np.abs(np.subtract.outer(
            eigenvalues.imag, 2.0 * np.pi * self._frequency)).argmin(axis=1)]
        before, energy = self._followed(eigenvalues, decay)
        if 0.0 < duration <= LONGEST_INTERVAL:
            for rates in halves(before, eigenvalues.real, edge=not self._roots.size):
                energy = grown(energy, rates, 0.5 * duration, decay, np.array(cap))
        frequency = eigenvalues.imag
        merged = np.abs(np.subtract.outer(frequency, frequency)) <= MERGED * frequency
        self._time, self._roots = time_ns, eigenvalues
        self._energy = np.where(merged, energy, 0.0).max(axis=1, initial=0.0)
        return np.asarray(nepers(self._energy), float)

    def _followed(self, eigenvalues: ComplexArray,
                  decay: FloatArray) -> tuple[RealArray, RealArray]:
        """Return growth rate and energy at the tick before; new modes were at their floors."""
        from scipy.optimize import linear_sum_assignment  # slow to load
        before, energy = -decay, np.ones(eigenvalues.size)
        away = np.abs(np.subtract.outer(eigenvalues, self._roots))
        new, old = linear_sum_assignment(away)
        same = away[new, old] <= FARTHEST * np.abs(eigenvalues[new])
        before[new[same]], energy[new[same]] = self._roots.real[old[same]], self._energy[old[same]]
        return before, energy

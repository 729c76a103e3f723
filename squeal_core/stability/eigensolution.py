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

"""Complex modes of the brake at an operating point, and the kind of each."""

from dataclasses import dataclass
from functools import cached_property
import math
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import (
    ComplexArray,
    FloatArray,
    IndexArray,
    readonly,
    repr_with_shapes,
)
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.state_space import frequency_scale, state_matrix

Kind: TypeAlias = Literal['flutter', 'stable', 'divergence', 'rigid']
Source: TypeAlias = Literal['full', 'table']
SQUEAL_BAND = (1250.0, 16000.0)  # Hz, SAE J2521

# Relative to the largest frequency w of the model. Rounding splits a double eigenvalue by up to
# sqrt(eps) w = 1.5e-8 w and a triple one, as at zero, by eps^(1/3) w = 6e-6 w. For K09's model,
# w = 2.03e5 rad/s, they are 0.01 1/s and 1 rad/s.
_GROWTH = 4.9e-8
_OSCILLATION = 4.9e-6


@dataclass(frozen=True, kw_only=True)
class Tolerances:
    """
    Limits of oscillation and growth, by which modes are classified.

    Parameters
    ----------
    oscillation : float
        |Im(lambda)| above which an eigenvalue is a vibration [rad/s].
    growth : float
        |Re(lambda)| above which an eigenvalue grows, or is not zero [1/s].

    """

    oscillation: float
    growth: float

    @classmethod
    def of(cls, model: BrakeModel, point: OperatingPoint | None = None, *,
           growth: float | None = None) -> 'Tolerances':
        """
        Return the tolerances of a model, relative to its own spectrum, in any unit of time.

        Parameters
        ----------
        model : BrakeModel
            Modal brake model.
        point : OperatingPoint, optional
            Where a model without stiffness of its own takes its largest frequency from.
        growth : float, optional
            Growth rate that counts as unstable [1/s]; None: 4.9e-8 of the largest frequency.

        """
        scale = frequency_scale(model, point)
        return cls(oscillation=_OSCILLATION * scale,
                   growth=_GROWTH * scale if growth is None else growth)


class Mode(NamedTuple):
    """
    One mode of the coupled system: the eigenvalue with Im >= 0 of its pair.

    Parameters
    ----------
    index : int
        Place in order of frequency, 1 to N, non-oscillating modes first.
    eigenvalue : complex
        lambda [1/s].
    kind : str
        'flutter' and 'stable' modes oscillate (an overdamped mode is 'stable' too);
        'divergence' grows without oscillating; 'rigid' is an eigenvalue at zero.

    """

    index: int  # type: ignore[assignment] # hides the method of tuples
    eigenvalue: complex
    kind: Kind

    @property
    def frequency_hz(self) -> float:
        """Return the frequency [Hz]: magnitude of Im(lambda) over 2 pi."""
        return abs(self.eigenvalue.imag) / math.tau

    @property
    def growth_rate(self) -> float:
        """Re(lambda) [1/s]; positive grows."""
        return self.eigenvalue.real

    @property
    def damping_ratio(self) -> float:
        """-Re(lambda) over the magnitude of lambda [-]; negative grows; 0 at zero."""
        if self.kind == 'rigid':
            return 0.0
        return -self.eigenvalue.real / abs(self.eigenvalue)

    @property
    def unstable(self) -> bool:
        """Return whether the mode is unstable."""
        return self.kind in ('flutter', 'divergence')


@dataclass(frozen=True, eq=False)
class ComplexModes:
    """
    All eigenvalues at an operating point, and the modes they make.

    Parameters
    ----------
    nonoscillatory : array
        Eigenvalues that do not oscillate [1/s], least stable first.
    oscillatory : array
        Those with Im > 0, by frequency; their conjugates are eigenvalues too.
    mode_eigenvalues : (N,) array
        One eigenvalue of each mode, in order of index: the one with Im >= 0. Of two that do not
        oscillate the less stable one represents the mode.
    errors : (N,) array
        What the eigenvalue of each mode may be off by [1/s], beyond rounding.
    tolerances : Tolerances
    source : str
        'full' for an eigensolution, 'table' for a look-up in a table.
    mode_numbers : (n,) index array, optional
        Mode number of each eigenvalue where only some of the modes are listed; None: 1 to N.
    omitted_below : float
        Growth rate that every oscillating mode not listed stays below [1/s]; -inf: all are listed.

    """

    nonoscillatory: ComplexArray
    oscillatory: ComplexArray
    mode_eigenvalues: ComplexArray
    errors: FloatArray
    tolerances: Tolerances
    source: Source = 'full'
    mode_numbers: IndexArray | None = None
    omitted_below: float = -math.inf

    __repr__ = repr_with_shapes

    @property
    def numbers(self) -> IndexArray:
        """Mode number of each eigenvalue, in order of frequency among all N modes."""
        return np.arange(1, self.mode_eigenvalues.size + 1) if self.mode_numbers is None else (
            self.mode_numbers)

    @cached_property
    def eigenvalues(self) -> ComplexArray:
        """All 2N eigenvalues [1/s]: those that do not oscillate, then pairs by frequency."""
        pairs = np.column_stack([self.oscillatory, self.oscillatory.conj()]).ravel()
        return readonly(np.concatenate([self.nonoscillatory, pairs]), complex)

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """All N modes in order of index."""
        return tuple(self._at(np.arange(self.mode_eigenvalues.size)))

    @cached_property
    def unstable(self) -> tuple[Mode, ...]:
        """Growing modes, worst first."""
        limit = self.tolerances.growth
        growing = [Mode(number, value, kind_of(value, self.tolerances)) for number, value in zip(
            self.numbers.tolist(), self.mode_eigenvalues.tolist(), strict=True)
            if value.real > limit]
        return tuple(sorted(growing, key=lambda mode: -mode.eigenvalue.real))

    def _at(self, places: Any) -> list[Mode]:
        result = self.mode_eigenvalues[places].tolist()
        return [Mode(number, eigenvalue, kind_of(eigenvalue, self.tolerances))
                for number, eigenvalue in zip(self.numbers[places].tolist(), result, strict=True)]

    def flutter_in(self, low_hz: float, high_hz: float) -> tuple[Mode, ...]:
        """Flutter modes with frequencies in a band, worst first."""
        return tuple(m for m in self.unstable
                     if m.kind == 'flutter' and low_hz <= m.frequency_hz <= high_hz)

    def least_stable(self, low_hz: float, high_hz: float, count: int = 1) -> tuple[Mode, ...]:
        """Oscillating modes with frequencies in a band, growing or not, worst first."""
        frequency = self.mode_eigenvalues.imag / (2.0 * np.pi)
        inside = np.flatnonzero((self.mode_eigenvalues.imag > self.tolerances.oscillation)
                                & (frequency >= low_hz) & (frequency <= high_hz))
        worst = inside[np.argsort(-self.mode_eigenvalues[inside].real, kind='stable')[:count]]
        return tuple(self._at(worst))

    def worst_in(self, low_hz: float, high_hz: float) -> Mode | None:
        """Return the least stable oscillating mode with a frequency in a band."""
        for mode in self.unstable:
            if mode.kind == 'flutter' and low_hz <= mode.frequency_hz <= high_hz:
                return mode
        return next(iter(self.least_stable(low_hz, high_hz)), None)


def complex_modes(model: BrakeModel, point: OperatingPoint, *,
                  tolerances: Tolerances | None = None) -> ComplexModes:
    """
    Return the complex modes at an operating point, from one full eigensolution.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Operating point.
    tolerances : Tolerances, optional
        `Tolerances.of(model, point)` where None.

    Notes
    -----
    Coordinates without stiffness are taken out of the state first. Each would add an eigenvalue at
    zero that is defective together with its velocity's, and that rounding turns into a small
    complex pair; without it the eigenvalue is known exactly.

    References
    ----------
    K09 eq. (36): see `BrakeModel`.

    Examples
    --------
    >>> from squeal_core import BrakeModel, OperatingPoint, complex_modes
    >>> model = BrakeModel(angular_frequencies=[1e4, 1.02e4], damping_ratios=0.002,
    ...                    friction_couple=[[0.0, 1e-3], [-1e-3, 0.0]])
    >>> point = OperatingPoint(rotor_speed=7.0, friction=0.3, contact_pressure=5e5,
    ...                        contact_stiffness=1e10)
    >>> [mode] = complex_modes(model, point).unstable
    >>> print(f'{mode.kind} at {mode.frequency_hz:.0f} Hz, {mode.growth_rate:+.1f} 1/s')
    flutter at 1608 Hz, +89.6 1/s

    """
    return classify(eigenvalues(model, point), tolerances or Tolerances.of(model, point))


def eigenvalues(model: BrakeModel, point: OperatingPoint) -> ComplexArray:
    """Return all 2N eigenvalues [1/s], in any order; K09 eq. (36), a = a0 exp(lambda t)."""
    result = moving_eigenvalues(model, point)
    return np.concatenate([np.zeros(2 * model.size - result.size, complex), result])


def moving_eigenvalues(model: BrakeModel, point: OperatingPoint) -> ComplexArray:
    """Return the eigenvalues but the zeros, one of each coordinate that has no stiffness."""
    state = state_matrix(model, model.damping(point), model.stiffness(point))
    return np.asarray(np.linalg.eigvals(state), complex)


def classify(eigenvalues: ComplexArray, tolerances: Tolerances) -> ComplexModes:
    """
    Sort eigenvalues into modes: each complex pair, and each two real ones, are a mode.

    Eigenvalues with Im < 0 may be missing: of a pair the other one counts.
    """
    growth, frequency = eigenvalues.real, eigenvalues.imag
    nonoscillatory = (np.abs(frequency) <= tolerances.oscillation).nonzero()[0]
    oscillatory = (frequency > tolerances.oscillation).nonzero()[0]
    nonoscillatory = nonoscillatory.take((-growth.take(nonoscillatory)).argsort(kind='stable'))
    oscillatory = oscillatory.take(np.lexsort((growth.take(oscillatory),
                                               frequency.take(oscillatory))))
    spoken = np.concatenate([nonoscillatory[:nonoscillatory.size // 2], oscillatory])
    return ComplexModes(
        _frozen(eigenvalues.take(nonoscillatory)), _frozen(eigenvalues.take(oscillatory)),
        _frozen(eigenvalues.take(spoken)), _frozen(np.zeros(spoken.size)), tolerances)


def _frozen(fresh: Any) -> Any:
    """Return an array that nobody else holds, read-only from now on."""
    fresh.flags.writeable = False
    return fresh


def kind_of(eigenvalue: complex, tolerances: Tolerances) -> Kind:
    """Return the kind of an eigenvalue's mode."""
    grows = eigenvalue.real > tolerances.growth
    if abs(eigenvalue.imag) > tolerances.oscillation:
        return 'flutter' if grows else 'stable'
    if grows:
        return 'divergence'
    return 'rigid' if eigenvalue.real >= -tolerances.growth else 'stable'

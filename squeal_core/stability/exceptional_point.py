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

"""The two-mode margin: the distance of two modes from merging."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.common.errors import OperatingPointError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Mode, SQUEAL_BAND, Tolerances
from squeal_core.stability.mode_tracking import numbered
from squeal_core.stability.parameter_paths import matrices, moved
from squeal_core.stability.state_space import state_matrix

AFFINE = ('friction', 'friction_slope', 'contact_pressure', 'contact_stiffness')
"""Parameters that D and K are linear in; in the rotor speed they are not."""
_CANDIDATES = 3
_STEPS = 40

_State: TypeAlias = tuple[FloatArray, FloatArray]


@dataclass(frozen=True, kw_only=True)
class ExceptionalPoint:
    """
    Point of a parameter's complex plane at which two eigenvalues coincide.

    Parameters
    ----------
    parameter : str
    start : float
        The parameter at the point.
    modes : tuple of two Mode
        At the point.
    value : complex
        Of the parameter where the two merge; real where they merge in fact, as without damping.
    distance : float
        |value - start|, the margin; in the parameter's unit.
    eigenvalue : complex
        The double eigenvalue [1/s].
    gap : float
        Distance of the two eigenvalues left at `value`, by a solve [1/s].
    converged : bool
    reason : str
        The result in words.

    """

    parameter: str
    start: float
    modes: tuple[Mode, Mode]
    value: complex
    distance: float
    eigenvalue: complex
    gap: float
    converged: bool
    reason: str


def nearest_exceptional_point(model: BrakeModel, point: OperatingPoint,
                              parameter: str = 'friction', *,
                              modes: tuple[Mode, Mode] | None = None,
                              band_hz: tuple[float, float] = SQUEAL_BAND, tolerance: float = 1e-9,
                              tolerances: Tolerances | None = None) -> ExceptionalPoint:
    """
    Return the margin of two modes to merging; by default of those closest to it in a band.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Operating point.
    parameter : str
        'friction' (its slope in proportion), 'friction_slope', 'contact_pressure' or
        'contact_stiffness'.
    modes : tuple of two Mode, optional
        Of `complex_modes(model, point)`; by default the neighbours in order of frequency whose
        merging is the nearest.
    band_hz : (2,) floats
        Low and high end [Hz].
    tolerance : float
        Of the last step, relative to the distance.
    tolerances : Tolerances, optional
        Of the classification of eigenvalues.

    Notes
    -----
    Two modes that damping keeps apart pass each other without merging at any real value of the
    parameter; they do merge at a complex one. With eigenvalues l1 and l2 the discriminant
    d = ((l1 - l2) / 2)^2 is an analytic function of the parameter, also where they merge and the
    eigenvalues are not; its zero is found by Newton's method and the secant, by solves at complex
    values. |value - start| is the distance up to which the eigenvalues are power series of the
    parameter. Of two undamped modes w1 and w2 with a friction couple +-b it is
    ||w1^2 - w2^2| / (2 k_c b) - mu|.

    """
    if parameter not in AFFINE:
        raise OperatingPointError(f'parameter is {parameter!r}; give one of {", ".join(AFFINE)}')
    limits, start = tolerances or Tolerances.of(model, point), float(getattr(point, parameter))
    step = abs(start) or 1.0
    here, there = (matrices(model, q) for q in (
        point, moved(model, point, parameter, start + step)))
    at = numbered(model, lambda _: here, tolerances=limits)
    state = state_matrix(model, *here)
    slope = (state_matrix(model, *there) - state) / step
    rates = np.einsum('im,mk,ki->i', at.spectrum.left, slope, at.spectrum.right, optimize=True)
    oscillating = at.modes[len(at.modes) - rates.size:]
    pairs = ([_places(oscillating, modes)] if modes
             else _closest(oscillating, rates, band_hz))
    result = [_merge((state, slope), parameter, start, (oscillating[i], oscillating[j]),
                     (complex(rates[i]), complex(rates[j])), tolerance) for i, j in pairs]
    if not result:
        raise OperatingPointError(f'band {band_hz[0]:g} to {band_hz[1]:g} Hz has no two modes; '
                                  'give a wider one')
    return min(result, key=lambda m: (not m.converged, m.distance))


def _closest(modes: Sequence[Mode], rates: ComplexArray,
             band_hz: tuple[float, float]) -> list[tuple[int, int]]:
    """Neighbours in the band, by the first Newton step; the few nearest."""
    inside = [i for i, mode in enumerate(modes) if band_hz[0] <= mode.frequency_hz <= band_hz[1]]

    def estimate(pair: tuple[int, int]) -> float:
        i, j = pair
        gap, rate = modes[i].eigenvalue - modes[j].eigenvalue, rates[i] - rates[j]
        return float(abs(gap) / (2.0 * abs(rate))) if rate else np.inf

    return sorted(pairwise(inside), key=estimate)[:_CANDIDATES]


def _places(modes: Sequence[Mode], pair: tuple[Mode, Mode]) -> tuple[int, int]:
    first, second = (min(range(len(modes)), key=lambda i: abs(
        modes[i].eigenvalue - mode.eigenvalue)) for mode in pair)
    if first == second:
        raise OperatingPointError('modes: the two are one, or do not oscillate; give two that do')
    return first, second


def _merge(state: _State, parameter: str, start: float, modes: tuple[Mode, Mode],
           rates: tuple[complex, complex], tolerance: float) -> ExceptionalPoint:
    """Find the zero of the discriminant: half Newton steps while far, then whole secants."""
    first, second = (mode.eigenvalue for mode in modes)
    value, mean, half = complex(start), 0.5 * (first + second), (0.5 * (first - second))**2
    mean_rate, rate = 0.5 * sum(rates), 0.5 * (first - second) * (rates[0] - rates[1])
    far, moved_by, gap = abs(half), np.inf, abs(first - second)
    for _ in range(_STEPS):
        if half == 0.0:
            moved_by = 0.0
        if rate == 0.0 or moved_by <= tolerance * abs(value - start):
            break
        step = -half / rate * (0.5 if abs(half) > 0.05 * far else 1.0)
        eigenvalues: ComplexArray = np.linalg.eigvals(
            (state[0] + (value + step - start) * state[1]).astype(complex))
        new_mean, new_half = _pair(eigenvalues, mean + step * mean_rate, half + step * rate)
        mean_rate, rate = (new_mean - mean) / step, (new_half - half) / step
        value, mean, half, moved_by = value + step, new_mean, new_half, abs(step)
        gap = 2.0 * abs(half)**0.5
    converged = bool(moved_by <= tolerance * abs(value - start))
    ahead = 'above' if value.real > start else 'below'
    reason = (f'eigenvalues {gap:.2g} 1/s apart at {parameter} {value.real:.6g} '
              f'{value.imag:+.2g}i, {ahead} the start'
              if converged else f'no merging found in {_STEPS} steps')
    return ExceptionalPoint(parameter=parameter, start=start, modes=modes, value=value,
                            gap=float(gap), distance=abs(value - start) if converged else np.inf,
                            eigenvalue=complex(mean), converged=converged, reason=reason)


def _pair(eigenvalues: ComplexArray, mean: complex, half: complex) -> tuple[complex, complex]:
    """Mean and discriminant of the two eigenvalues nearest to what they are expected to be."""
    near = eigenvalues[np.argsort(np.abs(eigenvalues - mean))[:6]]
    options = [(0.5 * (a + b), (0.5 * (a - b))**2) for a, b in combinations(near, 2)]
    result = min(options, key=lambda o: abs(o[0] - mean)**2 + abs(o[1] - half))
    return complex(result[0]), complex(result[1])

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

"""Claims of K09 about speed, with friction by its law, and in-plane torsion: figs 15 and 16."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.model import operators
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.stability.mechanism import mechanisms, without_rotation
from squeal_core.stability.mode_tracking import identify
from squeal_core.studies.sweep_record import Sweep
from squeal_core.verification.case import added_pairs, Case
from squeal_core.verification.paper import ADDED, FAST, FRICTION, PADS, SLOW, THIRD, TORSION
from squeal_core.verification.parts import Parts
from squeal_core.verification.row import ClaimResult, row


def over_speed(case: Case, record: Sweep) -> Iterator[ClaimResult]:
    """Yield the claims of fig. 15: growth rates over speed, friction by its law, tracked."""
    yield _torsion_over_speed(case, record)
    yield from _pads_over_speed(case, record)
    yield from _doublets(case, record)
    yield _divergence(case)


def _torsion_over_speed(case: Case, record: Sweep) -> ClaimResult:
    start = case.by_law(SLOW)
    place = case.of_torsion(complex_modes(case.model, start), start).index - 1
    number = identify(case.model, start).identities[place].numbers[0]
    growth, edge = record.of(number).real, case.critical_speed((number,), SLOW)
    return row('torsion grows more at lower speed', 'fig. 15', 'rises',
               f'{growth[-1]:+.0f} to {growth[0]:+.0f} 1/s; unstable below {edge:.1f} rad/s',
               bool(np.all(np.diff(growth) < 0.0)))


def _pads_over_speed(case: Case, record: Sweep) -> Iterator[ClaimResult]:
    speeds = record.axes['rotor_speed']
    pads = np.fmax(*(record.of(number).real for number in PADS))
    top = int(np.argmax(pads))
    yield row('pad pair grows more at lower speed', 'fig. 15', 'rises', f'{pads[-1]:+.1f} at 25 '
              f'to {pads[top]:+.1f} 1/s at {speeds[top]:g} rad/s',
              bool(np.all(np.diff(pads[speeds >= SLOW]) < 0.0)), tolerance='5..25 rad/s')
    strong = replace(without_rotation(case.model),
                     radial_dissipation=_times(10.0, case.model.radial_dissipation))
    locked = Case(strong).pair(PADS, case.at(SLOW))[0].growth_rate
    yield row('... down to standstill', 'fig. 15', 'rises (range not in text)',
              f'falls to {pads[0]:+.1f} 1/s at {speeds[0]:g} rad/s', top == 0,
              known=locked < pads[top],
              why='the pair grows by unlike radial damping, in proportion to friction over '
              f'speed; below {speeds[top]:g} rad/s that is so large that it locks the radial '
              f'sliding instead: ten times that at 5 rad/s leaves {locked:+.1f} 1/s')


def _doublets(case: Case, record: Sweep) -> Iterator[ClaimResult]:
    speeds = record.axes['rotor_speed']
    for words, numbers in (('third', THIRD), ('fourth', added_pairs(case)[1][ADDED[0]])):
        edge = case.critical_speed(numbers, FAST)
        below = np.array([record.of(number).real[speeds < edge] for number in numbers])
        yield row(f'{words} doublet stable at low speed', 'fig. 15', 'stable',
                  f'below {edge:.1f} rad/s', bool(below.size and np.all(below <= 0.0)))


def _divergence(case: Case) -> ClaimResult:
    start = case.by_law(SLOW)
    result = [[m.growth_rate for m in complex_modes(case.model, q).modes if m.kind == 'divergence']
              for q in (start, replace(start, friction_slope=0.0))]
    return row('divergence comes with the slope', 'fig. 15', 'appears',
               f'{len(result[0])} modes, {max(result[0], default=0.0):.0f} 1/s; '
               f'without slope {len(result[1])}',
               bool(result[0]) and not result[1])


def torsion(case: Case, parts: Parts | None) -> Iterator[ClaimResult]:
    """Yield the claims of fig. 16 and section 3.2: torsion squeals by the negative slope alone."""
    place = case.model.names.index(TORSION)
    size = max(float(np.abs(array[:, place]).max() / np.abs(array).max()) for array in (
        case.model.contact_stiffness, case.model.friction_couple) if array is not None)
    yield row('torsion does not press on the pads', 'fig. 16', 'no column in A, B',
              f'{size:.0e} of the largest', size < 1e-12, tolerance='rounding')
    constant = {mu: case.of_torsion(complex_modes(case.model, q), q).growth_rate
                for mu in (FRICTION, 1.0) for q in [case.at(SLOW, friction=mu)]}
    yield row('stable with constant friction', 'sec. 3.2', 'stable', ', '.join(
        f'{growth:+.1f} 1/s at {mu:g}' for mu, growth in constant.items()),
        max(constant.values()) < 0.0)
    yield _by_slope(case)
    if parts:
        yield _follower(case, parts)


def _by_slope(case: Case) -> ClaimResult:
    start = case.by_law(SLOW)
    mode = case.of_torsion(complex_modes(case.model, start), start)
    result = mechanisms(case.model, start, [mode])[0]
    without = {'negative_slope': np.nan, 'friction_couple': np.nan, **result.without}
    return row('squeals by negative slope, not coupling', 'fig. 16', 'negative slope',
               f'{mode.growth_rate:+.1f}; without slope {without["negative_slope"]:+.1f}, '
               f'without B {without["friction_couple"]:+.1f} 1/s',
               result.label == 'negative slope' and without['friction_couple'] > 0.0)


def _follower(case: Case, parts: Parts) -> ClaimResult:
    follower = replace(parts.model, follower=operators.follower(parts.faces))
    change = max(abs(old.growth_rate - new.growth_rate) for q in (case.at(SLOW), case.at(FAST))
                 for old, new in zip(complex_modes(parts.model, q).modes, complex_modes(
                     follower, q).modes, strict=True) if old.kind == 'flutter')
    return row('in-plane follower force does not matter', 'sec. 2', 'insignificant',
               f'{change:.2g} 1/s at most', change < 0.5, tolerance='0.5 1/s')


def _times(factor: float, array: FloatArray | None) -> FloatArray | None:
    return None if array is None else factor * array

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

"""Claims of K09 about frequencies and about which modes squeal: figs 8, 10, 13 and 14."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np
from squeal_core.stability.eigensolution import complex_modes, Mode
from squeal_core.stability.mechanism import Mechanism, mechanisms
from squeal_core.verification.case import added_pairs, Case
from squeal_core.verification.paper import EXACT, FAST, FIT, PADS, Pair, PRINTED, SLOW, THIRD
from squeal_core.verification.row import ClaimResult, row


def components(case: Case) -> Iterator[ClaimResult]:
    """Yield the claims on frequencies of disc and pads that K09 prints."""
    for printed, name, words, source, why in PRINTED:
        own = case.model.angular_frequencies[case.model.names.index(name)] / 2.0 / np.pi
        off = abs(own / printed - 1.0)
        yield row(words, source, f'{printed:g} Hz', f'{own:.1f} Hz, {own / printed - 1:+.2%}',
                  bool(off <= EXACT), fit=bool(off <= FIT), why=why,
                  tolerance=f'{100 * EXACT:g}/{100 * FIT:g} %')


def maps(case: Case) -> Iterator[ClaimResult]:
    """Yield the claims of figs 10 and 13: pairs that squeal at full stiffness, and their parts."""
    before, meant, added = added_pairs(case)
    yield row('pairs that squeal at 5 rad/s', 'fig. 10', names([THIRD, PADS]), names(before),
              set(before) == {THIRD, PADS})
    yield from _moving(case, before)
    # all at once: each mode is followed while a term is taken out, whichever are asked for
    result = dict(zip(added, mechanisms(case.model, case.at(FAST), list(added.values())),
                      strict=True))
    for pair, own in meant.items():
        yield _added(pair, own, result.get(own))
    for own in meant.values():
        if own in result:
            yield _gyroscopic(case, result[own])
    yield _further({pair: mechanism for pair, mechanism in result.items()
                    if pair not in meant.values()})


def _moving(case: Case, before: Mapping[Pair, Mode]) -> Iterator[ClaimResult]:
    """Yield the claims on the motion of the two pairs that squeal at 5 rad/s."""
    third = np.array([name[:-1] == 'disc (3,0)' for name in case.model.names])
    for pair, words, part in ((THIRD, 'third disc doublet', third),
                              (PADS, 'rigid pads', case.rigid)):
        share = case.energy(case.at(SLOW), before[pair])[part].sum() if pair in before else 0.0
        yield row(f'what moves in {names([pair])}', 'sec. 3.1', words,
                  f'{share:.0%} of the energy', bool(share > 0.5), tolerance='over 50 %')


def _added(pair: Pair, own: Pair, result: Mechanism | None) -> ClaimResult:
    claim, tolerance = f'{names([pair])} squeal at 20 rad/s only', 'one place'
    if result is None:
        return row(claim, 'fig. 14', names([pair]), 'none', False, tolerance=tolerance)
    parts = ', '.join(f'{part.name} {part.fraction:.0%}' for part in result.participation[:2])
    return row(claim, 'fig. 14', names([pair]), f'{names([own])}, '
               f'{result.mode.frequency_hz:.0f} Hz', own == pair, tolerance=tolerance,
               fit=abs(own[0] - pair[0]) <= 1, why='a place in order of frequency depends on '
               f'neighbours, which a fitted hat moves; in this mode take part {parts}, ...')


def _gyroscopic(case: Case, result: Mechanism) -> ClaimResult:
    mode, without = result.mode, result.without
    free = complex_modes(replace(case.model, radial_dissipation=None), case.at(SLOW))
    slow = max((other for other in free.modes if abs(
        other.frequency_hz / mode.frequency_hz - 1.0) < 0.01), key=lambda m: m.growth_rate,
        default=free.modes[0])
    return row(
        f'{mode.frequency_hz:.0f} Hz: added by gyroscopic term', 'sec. 3.1', 'grows by it',
        f'{mode.growth_rate:+.1f}, without it {without["gyroscopic"]:+.1f} 1/s',
        without['gyroscopic'] <= 0.0, known=min(without['rotation'], slow.growth_rate) > 0.0,
        why=f'it couples by friction without any rotation too ({without["rotation"]:+.1f} 1/s); '
        'what holds it at 5 rad/s is the radial dissipation, in proportion to 1/speed: without '
        f'that it grows there as well ({slow.growth_rate:+.1f} 1/s). The gyroscopic term adds to '
        'it, but is not needed')


def _further(others: Mapping[Pair, Mechanism]) -> ClaimResult:
    """Return the claim on pairs that squeal at 20 rad/s and that the text does not name."""
    leads = {other.participation[0].name for other in others.values()}
    growth = ', '.join(f'{other.participation[0].name} by {other.mode.growth_rate:.1f} 1/s'
                       for other in others.values())
    own = ', '.join(f'{names([pair])} ({other.mode.frequency_hz:.0f} Hz)'
                    for pair, other in others.items())
    return row('further pairs at 20 rad/s', 'sec. 3.1', 'none named', own or 'none', not others,
               known=leads <= {'disc (2,0)', 'disc (7,0)'},
               why=f'the second and the seventh disc doublet grow as well ({growth}); the text '
               'does not say that it names all, and its map (fig. 13) was not compared point by '
               'point')


def names(result: Iterable[Pair]) -> str:
    """Return pairs in K09's way of writing, as 13/14."""
    return ', '.join(f'{first}/{second}' for first, second in result)

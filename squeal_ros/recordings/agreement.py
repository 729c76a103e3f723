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

"""Live against replayed assessments of the same drive."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
import heapq
from itertools import groupby
import math
from operator import itemgetter

from squeal_core.monitor.history import AssessmentRecord


@dataclass(frozen=True)
class Agreement:
    """
    How far two records of one drive are the same.

    The tables of the engine are laid down by the samples seen, so numbers are equal bit for bit
    until an assessment saw another sample or was made in one record only; from there on they
    differ within their error.

    Parameters
    ----------
    compared, same_inputs, equal : int
        Assessments in both records; those that saw the same samples; those of them with equal
        risk, growth rates, frequencies and margin.
    parted_at : float
        Time from which the records saw different samples while released or sliding [s]; infinite
        if never.
    before, equal_before : int
        As `same_inputs` and `equal`, before that time.
    largest_difference : float
        Of the risk, over all compared [-].

    """

    compared: int
    same_inputs: int
    equal: int
    parted_at: float
    before: int
    equal_before: int
    largest_difference: float

    @property
    def in_words(self) -> str:
        late = self.compared - self.same_inputs
        parted = '' if math.isinf(self.parted_at) else (
            f'; until {self.parted_at:g} s, where a sample came late or a tick was lost, '
            f'{self.equal_before} of {self.before}')
        return (f'replay of the recorded inputs: {self.compared} assessments, {self.equal} of '
                f'{self.same_inputs} with the same samples equal bit for bit{parted}; {late} saw '
                f'a neighbouring sample; largest difference of risk {self.largest_difference:.2g}')


def agreement(live: Iterable[AssessmentRecord], replayed: Iterable[AssessmentRecord]) -> Agreement:
    """
    Compare tick by tick; holds no rows but those of a tick.

    Inputs may differ by one sample where a message came late.

    Parameters
    ----------
    live, replayed : iterables of AssessmentRecord
        In order of time.

    """
    compared = same = equal = before = equal_before = 0
    parted_at, largest = math.inf, 0.0
    for time, first, second in _ticks(live, replayed):
        if math.isinf(parted_at) and any(_parted(first.get(brake), second.get(brake))
                                         for brake in first.keys() | second.keys()):
            parted_at = time
        for brake in first.keys() & second.keys():
            a, b = first[brake], second[brake]
            compared += 1
            if a.state == b.state and not math.isnan(a.squeal_risk):
                largest = max(largest, abs(a.squeal_risk - b.squeal_risk))
            if _inputs(a) == _inputs(b):
                agrees = _numbers(a) == _numbers(b)
                same, equal = same + 1, equal + agrees
                if math.isinf(parted_at):
                    before, equal_before = before + 1, equal_before + agrees
    return Agreement(compared, same, equal, parted_at, before, equal_before, largest)


def _ticks(live: Iterable[AssessmentRecord], replayed: Iterable[AssessmentRecord]
           ) -> Iterator[tuple[float, dict[str, AssessmentRecord], dict[str, AssessmentRecord]]]:
    """Yield time and rows by brake of each tick of either record; a tick's last row counts."""
    both = heapq.merge(((round(row.time_s, 6), 0, row) for row in live),
                       ((round(row.time_s, 6), 1, row) for row in replayed),
                       key=itemgetter(0))
    for time, entries in groupby(both, key=itemgetter(0)):
        found: tuple[dict[str, AssessmentRecord], dict[str, AssessmentRecord]] = {}, {}
        for _, which, row in entries:
            found[which][row.brake] = row
        yield time, *found


def _parted(a: AssessmentRecord | None, b: AssessmentRecord | None) -> bool:
    """
    Whether one brake's engine was asked for something else, or nothing, in one record.

    For released brakes expansions of their next application are prepared.
    """
    asked = {'steady', 'released'} & {row.state for row in (a, b) if row is not None}
    return bool(asked) and (a is None or b is None or _inputs(a) != _inputs(b))


def _inputs(row: AssessmentRecord) -> str:
    return repr((row.state, row.rotor_speed_rad_s, row.pressure_pa, row.friction))


def _numbers(row: AssessmentRecord) -> str:
    return repr(replace(row, time_s=0.0, reason=''))

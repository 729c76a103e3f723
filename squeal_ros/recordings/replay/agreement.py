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
from dataclasses import dataclass
import heapq
from itertools import groupby
import math
from operator import itemgetter

from squeal_core.monitor.results.history import AssessmentRecord


@dataclass(frozen=True)
class Agreement:
    """
    Agreement of two records of one drive.

    Assessments that saw the same samples are equal bit for bit.

    Parameters
    ----------
    compared, same_inputs, equal : int
        Assessments in both records; those that saw the same samples; those of them with equal
        risk, growth rates, frequencies and margin.
    largest_difference : float
        Of the risk, over all compared [-].

    """

    compared: int
    same_inputs: int
    equal: int
    largest_difference: float

    @property
    def in_words(self) -> str:
        """Return the agreement of replay and node, in a sentence."""
        late = self.compared - self.same_inputs
        return (f'replay of the recorded inputs: {self.compared} assessments, {self.equal} of '
                f'{self.same_inputs} with the same samples equal bit for bit; {late} saw '
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
    compared = same = equal = 0
    largest = 0.0
    for first, second in _ticks(live, replayed):
        for brake in first.keys() & second.keys():
            a, b = first[brake], second[brake]
            compared += 1
            if a.state == b.state and not math.isnan(a.squeal_risk):
                largest = max(largest, abs(a.squeal_risk - b.squeal_risk))
            if _inputs(a) == _inputs(b):
                same, equal = same + 1, equal + (_numbers(a) == _numbers(b))
    return Agreement(compared, same, equal, largest)


def _ticks(live: Iterable[AssessmentRecord], replayed: Iterable[AssessmentRecord]
           ) -> Iterator[tuple[dict[str, AssessmentRecord], dict[str, AssessmentRecord]]]:
    """Yield the rows by brake of each tick of either record; a tick's last row counts."""
    both = heapq.merge(((round(row.time_s, 6), 0, row) for row in live),
                       ((round(row.time_s, 6), 1, row) for row in replayed),
                       key=itemgetter(0))
    for _, entries in groupby(both, key=itemgetter(0)):
        result: tuple[dict[str, AssessmentRecord], dict[str, AssessmentRecord]] = {}, {}
        for _, which, row in entries:
            result[which][row.brake] = row
        yield result


def _inputs(row: AssessmentRecord) -> str:
    return repr((row.state, row.rotor_speed_rad_s, row.pressure_pa, row.friction))


def _numbers(row: AssessmentRecord) -> str:
    return repr(row._replace(time_s=0.0, reason=''))

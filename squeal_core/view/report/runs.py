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

"""Runs that a page shows: each the results of one or several recordings."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
import math
from pathlib import Path
from typing import Any, NamedTuple

from squeal_core.calibration.scores import braking_numbers
from squeal_core.common.arrays import IndexArray
from squeal_core.common.errors import SquealError
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.record_tables import ResultError
from squeal_core.monitor.results.result_files import find_results, ReplayResult

MOST_RUNS = 6
_OF_REPORT = ('braking_s', 'assessed_s', 'risk_known_s', 'never_known', 'brakes', 'findings',
              'notes')
DATED = 946_684_800.0  # s, the year 2000: clocks below it have no date


class Located(NamedTuple):
    """An application or an event, and the place of its recording in the run."""

    recording: int
    record: Any


@dataclass(frozen=True, eq=False)
class Run:
    """
    Results that are shown as one.

    Parameters
    ----------
    name : str
    results : tuple of ReplayResult
        In the order of their recordings' starts.

    """

    name: str
    results: tuple[ReplayResult, ...]

    @cached_property
    def applications(self) -> list[Located]:
        """Brake applications of all recordings, each an `ApplicationRecord`."""
        return [Located(place, one) for place, result in enumerate(self.results)
                for one in result.applications]

    @cached_property
    def known(self) -> list[ApplicationRecord]:
        """Applications of which it is known whether squeal is predicted."""
        return [one for _, one in self.applications if one.alarm is not None]

    @cached_property
    def known_brakings(self) -> IndexArray:
        """Return the number of the braking of the vehicle that each known application is of."""
        return braking_numbers([(place, one.start_s, one.end_s)
                                for place, one in self.applications if one.alarm is not None])

    @cached_property
    def squealing(self) -> list[ApplicationRecord]:
        """Return the brake applications with an alarm."""
        return [one for one in self.known if one.alarm]

    @cached_property
    def events(self) -> list[Located]:
        """Squeal events of all recordings, each a `SquealEvent`; worst first."""
        found = [Located(place, one) for place, result in enumerate(self.results)
                 for one in result.events]
        return sorted(found, key=lambda one: (-_number(one.record.peak_risk),
                                              -_number(one.record.build_up_nepers)))

    @cached_property
    def brakes(self) -> list[str]:
        """Names of the brakes, in the order of the settings."""
        return list(dict.fromkeys(brake for result in self.results
                                  for brake in result.summary['report']['brakes']))

    @cached_property
    def worst(self) -> Located | None:
        """Worst event, or the application of the largest risk where there is none."""
        if self.events:
            return self.events[0]
        known = [one for one in self.applications if not math.isnan(one.record.peak_risk)]
        return max(known, key=lambda one: one.record.peak_risk, default=None)

    def total(self, key: str) -> float:
        """Return the sum of a figure of the reports of all recordings."""
        return float(sum(result.summary['report'][key] for result in self.results))

    @property
    def known_share(self) -> float:
        """Part of the braking time with a known risk; NaN where there was no braking."""
        braking = self.total('braking_s')
        return self.total('risk_known_s') / braking if braking else math.nan

    @property
    def nothing_known(self) -> bool:
        """Return whether the brakes were used and no squeal risk was ever known."""
        return self.total('braking_s') > 0.0 and self.total('risk_known_s') == 0.0

    def elapsed(self, at: Located, time: float) -> float:
        """Return the recorded time up to a moment [s], recordings one after the other."""
        return self.offsets[at.recording] + time - start_of(self.results[at.recording])

    @cached_property
    def offsets(self) -> list[float]:
        """Return the recorded time [s] before each recording."""
        found, total = [], 0.0
        for result in self.results:
            found.append(total)
            total += end_of(result) - start_of(result)
        return found


def _number(value: float) -> float:
    return -math.inf if math.isnan(value) else value


def start_of(result: ReplayResult) -> float:
    """Return the start time of the recording of a result [s]."""
    return float(result.summary['recording']['start_s'] or 0.0)


def end_of(result: ReplayResult) -> float:
    """Return its end time [s]."""
    return float(result.summary['recording']['end_s'] or 0.0)


def load_runs(paths: Sequence[str | Path]) -> list[Run]:
    """
    Return a run for each path: a folder of results, a result or its summary.

    Raises
    ------
    SquealError
        For a path without results, and for too many runs.

    """
    if len(paths) > MOST_RUNS:
        raise SquealError(f'{len(paths)} results; give at most {MOST_RUNS} to compare, or the '
                          'folder that holds them to have them as one')
    result = [sorted(map(loaded, find_results([path])),
                     key=lambda one: (start_of(one), one.name)) for path in paths]
    return [Run(name, tuple(results))
            for name, results in zip(_names(paths), result, strict=True)]


def loaded(path: Path) -> ReplayResult:
    """Return a result whose summary has all keys that the page uses."""
    result = ReplayResult.load(path)
    kinds: dict[str, Any] = {'report': dict, 'settings': dict, 'software': dict,
                             'rate_hz': (int, float)}
    for key, kind in kinds.items():
        if not isinstance(result.summary.get(key), kind):
            raise ResultError(path, f'has no {key}', 'write it again with `squeal replay`')
    missing = [key for key in _OF_REPORT if key not in result.summary['report']]
    if missing or not result.summary['rate_hz'] > 0.0:
        raise ResultError(path, f'has no report.{missing[0]}' if missing else
                          f'rate_hz is {result.summary["rate_hz"]}',
                          'write it again with `squeal replay`')
    return result


def _names(paths: Sequence[str | Path]) -> list[str]:
    """Return the distinct ends of paths."""
    whole = [Path(path).resolve() for path in paths]
    plain = [path.name.removesuffix('.summary.json') for path in whole]
    if len(set(plain)) == len(plain):
        return plain
    longer = [f'{path.parent.name}/{name}' for path, name in zip(whole, plain, strict=True)]
    if len(set(longer)) == len(longer):
        return longer
    return [f'{name} ({place})' for place, name in enumerate(plain, 1)]

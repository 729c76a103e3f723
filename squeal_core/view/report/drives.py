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

"""Data of the page from the tables: read once, kept in a size that does not grow with them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math
from typing import NamedTuple, TypeAlias

from squeal_core.common.errors import SquealError
from squeal_core.monitor.results.result_files import ReplayResult
from squeal_core.view.report.condition_maps import (
    ApplicationPath,
    FrictionBoundary,
    OperatingMap,
)
from squeal_core.view.report.envelope import StretchEnvelope
from squeal_core.view.report.friction_chart import condition_ranges
from squeal_core.view.report.runs import end_of, Located, Run, start_of
from squeal_core.view.report.tick_stream import accumulate, Accumulator
from squeal_core.view.report.words import clock

Stretch: TypeAlias = tuple[float, float]

_AROUND = 15.0  # s, before and after the worst event
_NO_BRAKE = ''


class NamedStretch(NamedTuple):
    """A stretch of a recording, its heading and its description."""

    title: str
    words: str
    envelope: StretchEnvelope


@dataclass(frozen=True, eq=False)
class Drive:
    """
    Data of a run's figures, from its tables.

    Parameters
    ----------
    place : int
        Of the run.
    result : ReplayResult
        Of the recording with the worst event, or with the stretch that was asked for.
    stretches : tuple of NamedStretch
    map : OperatingMap
    path : ApplicationPath
        Ticks of the worst application.
    of_path : str
        What that application is, in words.
    of_run : str
        ': ' and the name of the run, where there are several.

    """

    place: int
    result: ReplayResult
    stretches: tuple[NamedStretch, ...]
    map: OperatingMap  # noqa: A003 - a chart of the field
    path: ApplicationPath
    of_path: str
    of_run: str


def read_drives(runs: Sequence[Run], stretch: Stretch | None,
                progress: Callable[[int, int], None]) -> tuple[list[Drive], FrictionBoundary]:
    """
    Read the tables of all runs, each once.

    Raises
    ------
    SquealError
        For tables that cannot be read, and a stretch that is in no recording.

    """
    ranges = condition_ranges(runs)
    boundary, total = FrictionBoundary(ranges), sum(len(run.results) for run in runs)
    drives, done = [], 0
    if stretch is not None and all(_with_stretch(run, stretch) is None for run in runs):
        raise SquealError(_no_stretch(runs, stretch))
    for place, run in enumerate(runs):
        drive = _prepared(run, place, stretch, OperatingMap(ranges),
                          f': {run.name}' if len(runs) > 1 else '')
        for result in run.results:
            into: list[Accumulator] = [drive.map, boundary]
            if result is drive.result:
                into += [one.envelope for one in drive.stretches]
            if run.worst and result is run.results[run.worst.recording]:
                into.append(drive.path)
            accumulate(result, into)
            done += 1
            progress(done, total)
        drives.append(drive)
    return drives, boundary


def _prepared(run: Run, place: int, stretch: Stretch | None, drive_map: OperatingMap,
              of_run: str) -> Drive:
    worst = run.worst
    result = run.results[worst.recording if worst else 0]
    found: list[NamedStretch] = []
    if stretch is not None:
        chosen = _with_stretch(run, stretch)
        if chosen is not None:
            result, ends = chosen
            found = [_named(run, result, 'Chosen stretch', ends)]
    else:
        found = [_named(run, result, 'Whole recording', (start_of(result), end_of(result)))]
        if worst is not None:
            one = worst.record
            ends = (max(start_of(result), one.start_s - _AROUND),
                    min(end_of(result), one.end_s + _AROUND))
            if ends[1] - ends[0] < 0.8 * (end_of(result) - start_of(result)):
                found.append(_named(run, result, 'Around the worst event', ends))
    return Drive(place, result, tuple(found), drive_map, *_path(run, worst), of_run)


def _named(run: Run, result: ReplayResult, title: str, ends: Stretch) -> NamedStretch:
    rate = float(result.summary['rate_hz'])
    # ticks fall on multiples of the period, the last one on or after the last message
    start = math.floor(ends[0] * rate + 1e-6) / rate
    end = math.ceil(ends[1] * rate - 1e-6) / rate
    return NamedStretch(
        f'{title}: {result.name}', f'{run.name}, {result.name}, from {clock(ends[0])} to '
        f'{clock(ends[1])}', StretchEnvelope(start, end, rate, start_of(result)))


def _path(run: Run, worst: Located | None) -> tuple[ApplicationPath, str]:
    """Return a collector for the application of the worst event, and its description."""
    if worst is None:
        return ApplicationPath(_NO_BRAKE, 0.0, 0.0), ''
    one = worst.record
    ends = next(((two.start_s, two.end_s) for two in run.results[worst.recording].applications
                 if two.brake == one.brake and two.start_s <= one.start_s <= two.end_s),
                (one.start_s, one.end_s))
    return ApplicationPath(one.brake, *ends), (
        f' Path: {one.brake}, brake application at {clock(ends[0])} in '
        f'{run.results[worst.recording].name}, the one with the largest risk.')


def _with_stretch(run: Run, stretch: Stretch) -> tuple[ReplayResult, Stretch] | None:
    """
    Return the recording that holds a stretch, and its ends on the recording's clock.

    Times are on that clock, as in `events.csv`; else from the recording's start, the one with the
    worst event first.
    """
    start, end = stretch
    first = run.results[run.worst.recording if run.worst else 0]
    for result in (first, *run.results):
        if start_of(result) <= start < end <= end_of(result) + 1e-6:
            return result, stretch
    for result in (first, *run.results):
        if 0.0 <= start < end <= end_of(result) - start_of(result) + 1e-6:
            return result, (start + start_of(result), end + start_of(result))
    return None


def _no_stretch(runs: Sequence[Run], stretch: Stretch) -> str:
    result = runs[0].results[0]
    return (f'--stretch: {stretch[0]:g} to {stretch[1]:g} s is in no recording; {result.name} is '
            f'from {start_of(result):.1f} to {end_of(result):.1f} s (or 0 to '
            f'{end_of(result) - start_of(result):.1f} s from its start)')

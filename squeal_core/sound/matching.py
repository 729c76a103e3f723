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

"""Predicted and measured squeal of each brake application, matched."""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any, Literal, TypeAlias

import numpy as np
from squeal_core.calibration.events import AFTER, MeasuredEvent
from squeal_core.common.arrays import FloatArray
from squeal_core.sound.brakings import Braking, brakings_of, groups_of, Predictions
from squeal_core.sound.clock_check import is_within, times_of
from squeal_core.sound.listening import Listening, MeasuredSquealError

Outcome: TypeAlias = Literal['hit', 'miss', 'false alarm', 'correct silence', 'not known']
OUTCOMES: tuple[Outcome, ...] = ('hit', 'miss', 'false alarm', 'correct silence', 'not known')
_BEFORE = 0.2  # s by which squeal may begin before its brake application: clocks, rate of ticks
SAME_PITCH = 0.02
"""Relative error of a pitch that counts as the same mode."""
_UNTIMED = 0.5  # s that an event without an end is taken to last


@dataclass(frozen=True)
class MatchedApplication:
    """
    A brake application with its predicted and its measured squeal.

    Parameters
    ----------
    braking : Braking
    events : tuple of MeasuredEvent
        On the clock of the recording.
    outcome : str
        One of `OUTCOMES`.
    why : str
        Why it is not known.
    frequency_errors : tuple of float
        Of each event: nearest predicted unstable mode minus what was heard [Hz]; NaN: none
        was predicted then, or the pitch is not known.
    lead_time : float
        Start of the measured squeal minus that of the alarm [s]; NaN but for hits.

    """

    braking: Braking
    events: tuple[MeasuredEvent, ...]
    outcome: Outcome
    why: str = ''
    frequency_errors: tuple[float, ...] = ()
    lead_time: float = math.nan

    @property
    def measured(self) -> bool:
        """Return whether squeal was measured during the application."""
        return bool(self.events)

    @property
    def pitch_fits(self) -> bool:
        """Return whether an unstable mode within 2 % of a measured pitch was predicted then."""
        return any(abs(error) <= SAME_PITCH * event.frequency_hz
                   for event, error in zip(self.events, self.frequency_errors, strict=True))

    @property
    def alarm_first(self) -> bool:
        """Return whether the alarm of a hit came before its squeal."""
        return self.lead_time > 0.0


@dataclass(frozen=True)
class Matches:
    """
    All brake applications of some recordings, matched.

    Parameters
    ----------
    applications : tuple of MatchedApplication
    unmatched : tuple of MeasuredEvent
        In no brake application of their place.
    groups : tuple of tuples of str
        Brakes that the events tell apart.

    """

    applications: tuple[MatchedApplication, ...]
    unmatched: tuple[MeasuredEvent, ...]
    groups: tuple[tuple[str, ...], ...]

    def count(self, outcome: Outcome) -> int:
        return sum(one.outcome == outcome for one in self.applications)


def match(results: Sequence[Predictions], listenings: Sequence[Listening],
          brakes: Sequence[str], places: Mapping[str, Sequence[str]]) -> Matches:
    """
    Return the predicted and the measured squeal of each brake application.

    Parameters
    ----------
    results : sequence of Predictions
        One a recording.
    listenings : sequence of Listening
        Measured squeal of these recordings.
    brakes : sequence of str
        Names of all brakes.
    places : mapping
        Brakes of each place that an event may name.

    Raises
    ------
    MeasuredSquealError
        For an event that is of two recordings by its time.

    """
    times = times_of(results)
    events = [(one, listening) for listening in listenings for one in listening.events]
    unmatched = [one for one, listening in events if not is_within(one, listening, times)]
    events = [(one, listening) for one, listening in events if is_within(one, listening, times)]
    groups = groups_of(brakes, places, (one.place for one, _ in events))
    brakings = {(result.name, group): brakings_of(result, group)
                for result in results for group in groups}
    heard: defaultdict[tuple[str, tuple[str, ...], int], list[MeasuredEvent]] = defaultdict(list)
    for event, listening in events:
        group = next(group for group in groups
                     if not event.place or places[event.place][0] in group)
        found = [(result.name, group, place) for result in results
                 if event.recording in ('', result.name)
                 and listening.recording in ('', result.name)
                 for place in _place(event, brakings[result.name, group],
                                     max(_BEFORE, 2.0 * listening.clock_error))]
        if len({name for name, *_ in found}) > 1:
            raise MeasuredSquealError(
                f'{listening.path}, line {event.line}', f'time_s {event.time:g} is of '
                f'{" and ".join(name for name, *_ in found)}',
                'name the recording in a column `recording`')
        if found:
            heard[found[0]].append(event)
        else:
            unmatched.append(event)
    matched: list[MatchedApplication] = []
    for result in results:
        own = [(braking, tuple(heard[result.name, group, i])) for group in groups
               for i, braking in enumerate(brakings[result.name, group])]
        matched += _matched(result, own, listenings)
    return Matches(tuple(matched), tuple(unmatched), groups)


def _place(event: MeasuredEvent, brakings: Sequence[Braking], before: float) -> list[int]:
    """Return the number of the braking that an event is of: the later one where two end it."""
    i = bisect_right([one.start for one in brakings], event.time + before) - 1
    if i >= 0 and event.time <= brakings[i].end + AFTER:
        return [i]
    later = i + 1
    return [later] if later < len(brakings) and brakings[later].start <= event.end else []


def _matched(result: Predictions, found: Sequence[tuple[Braking, tuple[MeasuredEvent, ...]]],
             listenings: Sequence[Listening]) -> Iterator[MatchedApplication]:
    """Yield the applications of one recording in the order of time."""
    unstable = _UnstableModes(result, [one for _, events in found for one in events])
    for braking, events in sorted(found, key=lambda one: one[0].start):
        outcome, why = _outcome(braking, bool(events), listenings)
        yield MatchedApplication(
            braking, events, outcome, why,
            tuple(unstable.nearest_error(one, braking.brakes) for one in events),
            _lead_time(result, braking, events) if outcome == 'hit' else math.nan)


def _outcome(braking: Braking, measured: bool,
             listenings: Sequence[Listening]) -> tuple[Outcome, str]:
    alarm = braking.alarm
    if alarm is None:
        return 'not known', 'the squeal risk is not known for enough of it'
    if measured:
        return ('hit' if alarm else 'miss'), ''
    ears = [one for one in listenings
            if one.covers(braking.recording, braking.start, braking.end)]
    if not ears:
        return 'not known', 'nobody listened to the whole of it'
    pitch = braking.worst.frequency_hz
    if alarm and not any(one.hears(pitch) for one in ears):
        return 'not known', f'{pitch:.0f} Hz is outside of what the sound holds'
    return ('false alarm' if alarm else 'correct silence'), ''


def _lead_time(result: Predictions, braking: Braking,
               events: Sequence[MeasuredEvent]) -> float:
    starts = [one.start_s for one in result.events if one.brake in braking.brakes
              and one.start_s <= braking.end and one.end_s >= braking.start]
    return min(one.time for one in events) - min(starts) if starts else math.nan


class _UnstableModes:
    """Frequencies of the unstable modes that were predicted at the times of events."""

    def __init__(self, result: Predictions, events: Sequence[MeasuredEvent]) -> None:
        windows = np.array(_joined(sorted(map(_window, events)))).reshape(-1, 2)
        self._ticks = sorted(_ticks_within(result, windows)) if windows.size else []
        self._times = [time for time, *_ in self._ticks]

    def nearest_error(self, event: MeasuredEvent, brakes: Collection[str]) -> float:
        """Return the nearest of them minus the pitch of an event [Hz]; NaN: none, or no pitch."""
        start, end = _window(event)
        ticks = self._ticks[bisect_right(self._times, start):bisect_right(self._times, end)]
        errors = [hertz - event.frequency_hz for _, brake, frequencies in ticks
                  if brake in brakes for hertz in frequencies]
        if not errors or math.isnan(event.frequency_hz):
            return math.nan
        return errors[int(np.abs(errors).argmin())]


def _ticks_within(result: Predictions, windows: FloatArray
                  ) -> Iterator[tuple[float, str, tuple[float, ...]]]:
    """Yield time, brake and unstable frequencies of the ticks within some windows of time."""
    def within(time: Any) -> Any:
        at = np.searchsorted(windows[:, 0], time, side='right') - 1
        return (at >= 0) & (time <= windows[at, 1])

    for block in result.blocks(()):
        time = block.numbers['time_s']
        for i in np.flatnonzero(within(time)).tolist():
            yield float(time[i]), block.brakes[i], tuple(
                map(float, block.frequencies_hz[i].split()))


def _window(event: MeasuredEvent) -> tuple[float, float]:
    end = event.time + _UNTIMED if math.isnan(event.end) else event.end
    return event.time - _BEFORE, end + _BEFORE


def _joined(windows: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    result: list[tuple[float, float]] = []
    for start, end in windows:
        if result and start <= result[-1][1]:
            result[-1] = (result[-1][0], max(end, result[-1][1]))
        else:
            result.append((start, end))
    return result

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

"""Checks that measured squeal is of the time of recordings."""

from collections.abc import Iterator, Mapping, Sequence
import math
from typing import Any

from squeal_core.calibration.events import MeasuredEvent
from squeal_core.common.ranges import Ends
from squeal_core.monitor.results.squeal_events import clock_time
from squeal_core.sound.brakings import Predictions
from squeal_core.sound.listening import Listening, MeasuredSquealError

_NEAR = 1.0  # s around a recording in which an event is of its time


def check_clocks(results: Sequence[Predictions], listenings: Sequence[Listening]) -> list[str]:
    """
    Return notes on assumptions of the listening, and on tables outside of all recordings.

    Raises
    ------
    MeasuredSquealError
        Where all measured squeal is of another time than all recordings.

    """
    recordings = times_of(results)
    notes = [text for one in listenings for text in _notes(one, recordings)]
    elsewhere = [one for one in listenings if not _inside(one, recordings)]
    if len(elsewhere) == len(listenings):
        raise _other_clock(elsewhere[0], recordings)
    return notes + [str(_other_clock(one, recordings)) for one in elsewhere]


def times_of(results: Sequence[Predictions]) -> dict[str, Ends]:
    """Return start and end [s] of each recording, by name."""
    return {result.name: _range(result.summary['recording']) for result in results}


def is_within(event: MeasuredEvent, one: Listening, recordings: Mapping[str, Ends]) -> bool:
    """Return whether an event is within the time of a recording that it may be of."""
    return any(start - _NEAR <= event.time <= end + _NEAR
               for name, (start, end) in recordings.items()
               if event.recording in ('', name) and one.recording in ('', name))


def _range(recording: Any) -> Ends:
    start, end = recording.get('start_s'), recording.get('end_s')
    return (math.inf, -math.inf) if start is None or end is None else (float(start), float(end))


def _inside(one: Listening, recordings: Mapping[str, Ends]) -> bool:
    """Return whether an event, or where there is none the listening, is in a recording."""
    if one.events:
        return any(is_within(event, one, recordings) for event in one.events)
    return one.span is None or any(
        one.span[0] <= end and start <= one.span[1] for start, end in recordings.values())


def _notes(one: Listening, recordings: Mapping[str, Ends]) -> Iterator[str]:
    outside = sum(not is_within(event, one, recordings) for event in one.events)
    if 0 < outside < len(one.events):
        yield (f'{one.path}: {outside} of {len(one.events)} events are outside of the time of all '
               'recordings')
    if not one.is_timed:
        yield (f'{one.path}: the clock of the sound is not known, so its times are taken as those '
               'of the recordings; give `squeal listen` --start or --sync')
    if one.span is None:
        yield (f'{one.path}: nothing says when somebody listened, so the whole of the recordings '
               'is taken as listened to')
    elif one.not_heard:
        lost = sum(end - start for start, end in one.not_heard)
        yield (f'{one.path}: {lost:.2f} s of the sound were not heard; silence of brake '
               'applications that reach into them is not known')
    elif one.heard_share < 1.0:
        yield (f'{one.path}: the microphone was alive for {one.heard_share:.1%} of the sound; '
               'silence in the rest counts as silence')


def _other_clock(one: Listening, recordings: Mapping[str, Ends]) -> MeasuredSquealError:
    times = [event.time for event in one.events]
    first, last = (min(times), max(times)) if times else one.span or (math.nan, math.nan)
    start = min(start for start, _ in recordings.values())
    end = max(end for _, end in recordings.values())
    names = {event.recording or one.recording for event in one.events} - {''} - recordings.keys()
    return MeasuredSquealError(
        one.path, f'{"its events are" if times else "it was listened"} from '
        f'{time_in_words(first)} to {time_in_words(last)}, and the recordings are from '
        f'{time_in_words(start)} to {time_in_words(end)}',
        f'give results of {", ".join(sorted(names))}' if names else
        'give `squeal listen` the start of the sound (--start), or --sync')


def time_in_words(seconds: float) -> str:
    """Return a time in seconds, and of day where it is one of a clock."""
    clock = '' if math.isnan(seconds) else clock_time(seconds)
    return f'{seconds:.3f} s' + (f' ({clock})' if clock else '')

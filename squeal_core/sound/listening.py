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

"""Tables of measured squeal, and the times, quality and pitches of the listening."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
import json
import math
from pathlib import Path
from typing import Any

from squeal_core.calibration.events import MeasuredEvent, read_events
from squeal_core.common.bounded_reader import read_bounded
from squeal_core.common.errors import LocatedError
from squeal_core.common.ranges import Ends
from squeal_core.sound.measured_files import MeasuredSqueal

_MAX_BYTES = 100_000_000
_REMEDY = 'give what `squeal listen` wrote, or remove it'


class MeasuredSquealError(LocatedError):
    """Measured squeal that cannot be read, or cannot be compared with predictions."""


@dataclass(frozen=True)
class Listening:
    """
    Measured squeal of one table.

    Parameters
    ----------
    path : Path
    events : tuple of MeasuredEvent
    span : (2,) floats, optional
        From when to when somebody listened [s]; None: not known, so the whole of the recordings.
    recording : str
        Name of the recording whose clock it is; empty: not known.
    band_hz : (2,) floats, optional
        Of pitches that could be heard; None: not known.
    heard_share : float
        Fraction of the span in which a microphone was alive.
    clock_error : float
        Standard deviation of the clock [s]; zero where it is not known.
    is_timed : bool
        Whether times are known to be on a clock; else they may count from the start of a sound.
    not_heard : tuple of (2,) floats
        Stretches in which no microphone was alive [s].

    """

    path: Path
    events: tuple[MeasuredEvent, ...]
    span: Ends | None = None
    recording: str = ''
    band_hz: Ends | None = None
    heard_share: float = 1.0
    clock_error: float = 0.0
    is_timed: bool = True
    not_heard: tuple[Ends, ...] = ()

    def covers(self, recording: str, start: float, end: float) -> bool:
        """Return whether all of a stretch [s] of a recording was listened to."""
        return self.recording in ('', recording) and (
            self.span is None or self.span[0] <= start and end <= self.span[1]
        ) and not any(first < end and start < last for first, last in self.not_heard)

    def hears(self, frequency_hz: float) -> bool:
        """Return whether a pitch could be heard; an unknown one could."""
        return self.band_hz is None or not (
            frequency_hz < self.band_hz[0] or frequency_hz > self.band_hz[1])


def read_listening(path: str | Path, places: Collection[str]) -> Listening:
    """
    Read a table of measured squeal, and the JSON beside it where `squeal listen` wrote one.

    Parameters
    ----------
    path : path
        CSV, as `read_events` reads.
    places : collection of str
        Names of brakes, axles and sides that events may have.

    Raises
    ------
    EventFileError, MeasuredSquealError
        With file, line, value and remedy.

    """
    path = Path(path)
    events = tuple(read_events(path, places))
    about = path.with_suffix('.json')
    if not about.is_file():
        return Listening(path, events)
    try:
        result = json.loads(read_bounded(about, _MAX_BYTES, MeasuredSquealError))
        return _with_sound(path, events, result)
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        if isinstance(error, LocatedError):
            raise
        raise MeasuredSquealError(about, f'does not say how {path.name} came to be '
                                  f'({type(error).__name__}: {error})', _REMEDY) from None


def _with_sound(path: Path, events: tuple[MeasuredEvent, ...],
                result: Mapping[str, Any]) -> Listening:
    offset = result['offset_s']
    if offset is None and result.get('clock') == 'sync':
        raise MeasuredSquealError(path, 'is on no clock, as that of the sound was looked for and '
                                  f'not found ({result.get("clock_note")})',
                                  'give `squeal listen` the start of the sound (--start)')
    start = float(offset or 0.0)  # null: times count from the start of the sound
    low, high = map(float, result['band_hz'])
    error = result.get('offset_uncertainty_s')
    return Listening(
        path, events, (start, start + float(result['sound']['duration_s'])),
        str(result.get('recording') or ''), (low, high), float(result['heard_share']),
        0.0 if error is None or math.isnan(error) else float(error), offset is not None,
        tuple((float(first), float(last)) for first, last in result.get('not_heard_s') or ()))


def listening_of(measured: MeasuredSqueal) -> Listening:
    """Return the squeal measured in a sound, on the clock of the sound."""
    sound, shift = measured.record.sound, measured.clock.shift
    pressure = measured.record.settings.scale.quantity == 'pressure'
    error = measured.clock.uncertainty
    events = tuple(MeasuredEvent(
        tone.start + shift, tone.brake, tone.frequency_hz,
        tone.level_db if pressure else math.nan, measured.recording, i, tone.end + shift)
        for i, tone in enumerate(measured.events or (), 1))
    return Listening(sound.path, events, (shift, shift + sound.duration), measured.recording,
                     measured.record.band, measured.record.heard_share,
                     0.0 if math.isnan(error) else error, not math.isnan(measured.clock.offset),
                     tuple((first + shift, last + shift)
                           for first, last in measured.record.not_heard))


def read_listenings(paths: str | Path | Sequence[str | Path],
                    places: Collection[str]) -> list[Listening]:
    """Read one table of measured squeal or several."""
    given = [paths] if isinstance(paths, str | Path) else list(paths)
    return [read_listening(path, places) for path in given]

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

"""The files of measured squeal: a table of events, and their origin."""

from collections.abc import Sequence
import csv
from dataclasses import dataclass
import datetime
import json
import math
from pathlib import Path
from typing import Any, IO

from squeal_core.common.json_values import plain
from squeal_core.common.output import check_target, OutputFiles
from squeal_core.sound.listen import SoundRecord
from squeal_core.sound.sound_clock import SoundClock
from squeal_core.sound.squeal_detection import HeardTone
from squeal_core.sound.tone_sources import RULES

COLUMNS = ('time_s', 'frequency_hz', 'brake', 'level_db', 'recording', 'end_s',
           'frequency_end_hz', 'prominence_db', 'tone_to_noise_db', 'prominence_ratio_db',
           'harmonics', 'channel', 'comment')
_DIGITS = 4


@dataclass(frozen=True)
class MeasuredSqueal:
    """
    Squeal measured in a sound, on the clock of a recording.

    Parameters
    ----------
    record : SoundRecord
        Of the sound.
    tones : list of HeardTone, optional
        Events and rejected tones; None: not known.
    clock : SoundClock
        Of the sound.
    recording : str
        Name of the recording whose clock it is; empty: not known.

    """

    record: SoundRecord
    tones: list[HeardTone] | None
    clock: SoundClock
    recording: str = ''

    @property
    def events(self) -> list[HeardTone] | None:
        """Tones that are squeal; None: not known."""
        return None if self.tones is None else [tone for tone in self.tones if not tone.rule]

    @property
    def rejected(self) -> list[HeardTone]:
        """Tones that are none."""
        return [tone for tone in self.tones or () if tone.rule]

    def as_json(self) -> dict[str, Any]:
        """Return all of it as JSON has it."""
        record, sound, settings = self.record, self.record.sound, self.record.settings
        return {
            'format': 1,
            'sound': {'name': sound.path.name, 'path': str(sound.path), 'sha256': sound.sha256(),
                      'rate_hz': sound.rate, 'channels': sound.channels, 'coding': sound.coding,
                      'duration_s': sound.duration},
            'heard_share': record.heard_share,
            'heard_s': max((one.heard_time for one in record.heard), default=0.0),
            'not_heard_s': [[start + self.clock.shift, end + self.clock.shift]
                            for start, end in record.not_heard],
            'clipped_share': {str(i + 1): float(one.clipped.mean()) if one.clipped.size else 0.0
                              for i, one in record.channels.items()},
            'not_known': {str(i + 1): why for i, why in record.unknown.items()},
            'recording': self.recording,
            'clock': self.clock.source,
            'offset_s': plain(self.clock.offset),
            'offset_uncertainty_s': plain(self.clock.uncertainty),
            'clock_note': self.clock.note,
            'band_hz': list(record.band), 'prominence_db': settings.prominence,
            'threshold': settings.threshold, 'level_unit': settings.scale.unit,
            'at_full_scale': settings.scale.at_full_scale if settings.scale.quantity
            != 'full scale' else None,
            'shortest_s': settings.shortest,
            'notes': record.notes,
            'events': None if self.events is None else [self._tone(tone) for tone in self.events],
            'rejected': [{**self._tone(tone), 'rule': tone.rule} for tone in self.rejected],
            'rules': self.rules()}

    def rules(self) -> dict[str, str]:
        """Return the rules of rejection, in words by name."""
        settings = self.record.settings
        return {'level': f'never louder than {settings.threshold:g} {settings.scale.unit}',
                'duration': f'shorter than {settings.shortest:g} s', **RULES}

    def _tone(self, tone: HeardTone) -> dict[str, Any]:
        shift = self.clock.shift
        return {'time_s': tone.start + shift, 'end_s': tone.end + shift,
                'sound_time_s': tone.start, 'frequency_hz': tone.frequency_hz,
                'frequency_start_hz': tone.frequency_start_hz,
                'frequency_end_hz': tone.frequency_end_hz, 'level': tone.level_db,
                'prominence_db': tone.prominence_db,
                'tone_to_noise_db': plain(tone.tone_to_noise_db),
                'prominence_ratio_db': plain(tone.prominence_ratio_db),
                'harmonics': list(tone.harmonics), 'channel': tone.channel + 1,
                'clipped': tone.is_clipped, 'brake': tone.brake or None}

    def write_table(self, file: IO[str]) -> None:
        """Write the table of events."""
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(COLUMNS)
        writer.writerows(map(self._row, self.events or ()))

    def _row(self, tone: HeardTone) -> Sequence[object]:
        scale, shift = self.record.settings.scale, self.clock.shift
        level, comment = f'{tone.level_db:.2f}', ['clipped'] if tone.is_clipped else []
        if scale.quantity != 'pressure':
            comment.insert(0, f'{level} {scale.unit}')
            level = ''
        rated = ['' if math.isnan(value) else f'{value:.1f}'
                 for value in (tone.tone_to_noise_db, tone.prominence_ratio_db)]
        return (f'{tone.start + shift:.{_DIGITS}f}', f'{tone.frequency_hz:.1f}', tone.brake, level,
                self.recording, f'{tone.end + shift:.{_DIGITS}f}', f'{tone.frequency_end_hz:.1f}',
                f'{tone.prominence_db:.1f}', *rated, ' '.join(map(str, tone.harmonics)),
                tone.channel + 1, '; '.join(comment))


class MeasuredFiles:
    """
    The files of measured squeal.

    Parameters
    ----------
    table : path
        Of the events; the JSON goes beside it.
    overwrite : bool
        Whether existing ones may be replaced.

    """

    def __init__(self, table: str | Path, *, overwrite: bool = False) -> None:
        self.table, self._overwrite = Path(table), overwrite
        self.about = self.table.with_suffix('.json')

    def prepare(self, inputs: Sequence[str | Path]) -> None:
        """
        Refuse, before the work, files that could not be written.

        Raises
        ------
        OutputError
            For files that are there, or a folder that cannot be written to.

        """
        for path in (self.table, self.about):
            check_target(path, overwrite=self._overwrite, inputs=inputs)

    def write(self, measured: MeasuredSqueal) -> list[Path]:
        """Write both, or where nothing is known the JSON alone; return what was written."""
        known = measured.events is not None
        with OutputFiles(overwrite=self._overwrite) as files:
            if known:
                with files.add(self.table).partial.open('w', newline='', encoding='utf-8') as file:
                    measured.write_table(file)
            files.add(self.about).partial.write_text(
                json.dumps(measured.as_json(), indent=1) + '\n', encoding='utf-8')
        if not known:  # an older table would read as if these were its events
            self.table.unlink(missing_ok=True)
        return [self.table, self.about] if known else [self.about]


def moment_in_words(seconds: float) -> str:
    """Return a time in words: of day where it is one of a clock, else in seconds."""
    if seconds < 1e8:
        return f'{seconds:.3f} s'
    time = datetime.datetime.fromtimestamp(seconds, datetime.UTC)
    return f'{time.isoformat(" ", "milliseconds").removesuffix("+00:00")} UTC'

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

"""The command that finds squeal in a sound."""

import argparse
import json
import math
import time

from squeal_core.common.checks import check_number
from squeal_core.common.errors import SquealError
from squeal_core.sound.listen import listen as run_listening
from squeal_core.sound.listening_settings import LevelScale, ListeningSettings
from squeal_core.sound.measured_files import MeasuredFiles, MeasuredSqueal, moment_in_words
from squeal_core.sound.recorded_drive import read_drive, RecordedDrive
from squeal_core.sound.sound_clock import clock_of_file, clock_of_stamp, SoundClock
from squeal_core.sound.sound_file import open_sound
from squeal_core.sound.sound_source import SoundFile
from squeal_core.sound.squeal_detection import HeardTone
from squeal_core.sound.synchronisation import synchronise
from squeal_core.sound.tone_sources import BrakingAt, SpeedAt
from squeal_ros.cli.console import plain, ProgressBar, warn

_GOOD, _NOT_KNOWN = 0, 1


def listen(options: argparse.Namespace) -> int:
    """Find squeal in a sound, write table and JSON."""
    settings = _settings(options)
    sound = open_sound(options.sound)
    channels = _channels(sound, options.channel)
    brakes = _brakes(options.brakes, sound, channels)
    clock = clock_of_stamp(options.start) if options.start else clock_of_file(sound)
    drive, by_speed = (path and read_drive(path) for path in (options.sync, options.speed))
    files = MeasuredFiles(options.output, overwrite=options.force)
    files.prepare([path for path in (sound.path, options.sync, options.speed) if path])
    begun = time.monotonic()
    with ProgressBar('% heard') as progress:
        record = run_listening(sound, settings, channels=channels, progress=lambda share:
                               progress.timed(round(100 * share), 100))
    if drive:
        clock = synchronise(record.heard, drive) if record.heard else SoundClock(
            'sync', note='not known: nothing was heard', is_ambiguous=True)
    tones = record.tones(brakes=brakes, speed=_speed(by_speed or drive, clock, options),
                         braking=_braking(drive, clock))
    measured = MeasuredSqueal(record, tones, clock,
                              drive.name if drive and not clock.is_ambiguous else '')
    for note in record.notes:
        warn(f'{sound.path}: {note}')
    written = files.write(measured)
    if options.json:
        print(json.dumps(plain({**measured.as_json(), 'files': [str(path) for path in written]})))
    else:
        _print(measured, time.monotonic() - begun)
        print(f'written: {", ".join(map(str, written))}')
    return _NOT_KNOWN if measured.events is None or clock.is_ambiguous else _GOOD


def _speed(drive: RecordedDrive | None, clock: SoundClock, options: argparse.Namespace
           ) -> SpeedAt | None:
    """Return the speed at times of the sound; None where it or the clock is not known."""
    if drive is None or clock.is_ambiguous:
        return None
    is_table = options.speed is not None and options.speed.endswith('.csv')
    shift = 0.0 if is_table and clock.source == 'bext' else clock.shift
    return lambda time: drive.speed_at(time + shift)


def _braking(drive: RecordedDrive | None, clock: SoundClock) -> BrakingAt | None:
    """Return whether brakes slide at times of the sound, where its clock was found by them."""
    if drive is None or clock.is_ambiguous:
        return None
    return lambda time: drive.braking_at(time + clock.shift, clock.uncertainty)


def _settings(options: argparse.Namespace) -> ListeningSettings:
    scale = LevelScale.parse(options.calibration) if options.calibration else LevelScale()
    if options.threshold is not None:
        check_number('--threshold', options.threshold)
    return ListeningSettings(
        tuple(options.band or ListeningSettings.band), options.prominence,
        math.nan if options.threshold is None else options.threshold, options.shortest, scale)


def _channels(sound: SoundFile, wanted: list[int]) -> list[int]:
    for number in wanted:
        if not 1 <= number <= sound.channels:
            raise SquealError(f'--channel: is {number}; {sound.path} has {sound.channels}, '
                              'numbered from 1')
    return [number - 1 for number in dict.fromkeys(wanted)] or list(range(sound.channels))


def _brakes(text: str | None, sound: SoundFile, channels: list[int]) -> list[str]:
    """Return the brake of each channel of the file; empty where none is named."""
    if text is None:
        return []
    names = [name.strip() for name in text.split(',')]
    if len(names) != len(channels):
        raise SquealError(f'--brakes: names {len(names)} for {len(channels)} channels; give one '
                          'for each, in their order')
    by_channel = [''] * sound.channels
    for channel, name in zip(channels, names, strict=True):
        by_channel[channel] = name
    return by_channel


def _print(measured: MeasuredSqueal, seconds: float) -> None:
    record, sound = measured.record, measured.record.sound
    channels = f'{sound.channels} channel{"s" if sound.channels > 1 else ""}'
    print(f'{sound.path}: {sound.duration:.1f} s, {channels}, {sound.rate} Hz, {sound.coding}; '
          f'listened to in {seconds:.1f} s')
    for channel, why in record.unknown.items():
        print(f'channel {channel + 1}: not known: {why}')
    if measured.events is None:
        print('squeal: not known; nothing was heard of the whole sound')
        return
    settings, (low, high) = record.settings, record.band
    print(f'heard {math.floor(1e3 * record.heard_share) / 10:g}% of it, {low:g} to {high:.0f} Hz'
          + (f' (half the rate limits it; asked for was {settings.band[1]:g} Hz)'
             if high < settings.band[1] else ''))
    print(f'clock: {measured.clock.note}')
    count = len(measured.events)
    print(f'{count} squeal event{"" if count == 1 else "s"} (tones {settings.prominence:g} dB '
          f'above their neighbours, {settings.threshold:g} {settings.scale.unit} or more, '
          f'{settings.shortest:g} s or longer)')
    for tone in measured.events:
        print(_line(measured, tone))
    for rule, text in measured.rules().items():
        number = sum(tone.rule == rule for tone in measured.rejected)
        if number:
            print(f'rejected {number} by {rule}: {text}')


def _line(measured: MeasuredSqueal, tone: HeardTone) -> str:
    shift, scale = measured.clock.shift, measured.record.settings.scale
    parts = [f'{moment_in_words(tone.start + shift)}, {tone.end - tone.start:.2f} s: '
             f'{tone.frequency_hz:.0f} Hz',
             f'{tone.level_db:.0f} {scale.unit}', f'{tone.prominence_db:.0f} dB prominent']
    if abs(tone.frequency_end_hz / tone.frequency_start_hz - 1.0) > 0.01:
        parts[0] += f' ({tone.frequency_start_hz:.0f} to {tone.frequency_end_hz:.0f})'
    if tone.harmonics:
        parts.append(f'harmonics {", ".join(map(str, tone.harmonics))}')
    if measured.record.sound.channels > 1:
        parts.append(f'channel {tone.channel + 1}')
    return ', '.join([*parts, *([tone.brake] if tone.brake else []),
                      *(['clipped'] if tone.is_clipped else [])])

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

"""Measured squeal for a command: from a table of events, or a sound to listen to."""

import argparse
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from squeal_core.calibration.events import read_events
from squeal_core.common.errors import SquealError
from squeal_core.sound.listen import listen
from squeal_core.sound.listening import Listening, listening_of, read_listening
from squeal_core.sound.listening_settings import ListeningSettings
from squeal_core.sound.measured_files import MeasuredSqueal
from squeal_core.sound.sound_clock import clock_of_file
from squeal_core.sound.sound_file import open_sound
from squeal_ros.cli.console import report_progress, warn


def heard_events(options: argparse.Namespace, places: Collection[str]) -> Listening:
    """
    Return the events of --events or --sound that are loud enough, and the times listened to.

    Parameters
    ----------
    options : namespace
        `events` or `sound`, and `minimum_level`.
    places : collection of str
        Names of brakes, axles and sides that events may have.

    """
    if options.events:
        result = Listening(Path(options.events), tuple(read_events(options.events, places)))
    elif Path(options.sound).suffix == '.csv':
        result = read_listening(options.sound, places)
    else:
        result = _listened(options.sound)
    if options.minimum_level is None:
        return result
    return replace(result, events=tuple(
        one for one in result.events if not one.level_db < options.minimum_level))


def _listened(path: str) -> Listening:
    """Listen to a sound as `squeal listen` does by default."""
    sound = open_sound(path)
    record = listen(sound, ListeningSettings())
    measured = MeasuredSqueal(record, record.tones(), clock_of_file(sound))
    if measured.events is None:
        why = '; '.join(dict.fromkeys(record.unknown.values()))
        raise SquealError(f'{path}: nothing is known of its squeal ({why}); give another sound')
    for note in record.notes:
        warn(f'{path}: {note}')
    report_progress(f'{path}: {len(measured.events)} squeal events in {sound.duration:.1f} s; '
                    f'{measured.clock.note}')
    return listening_of(measured)

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

"""Tables of text as loggers write them, and files of signals that read them; made for tests."""

from collections.abc import Iterator
import math
from pathlib import Path
from typing import Any

from squeal_core.monitor.settings import MonitorSettings, read_settings
from squeal_core.monitor.vehicle_monitor import Sample
from squeal_ros.recordings.recording_files import open_recording
from squeal_ros.recordings.signals.signal_settings import settings_with_signals
from squeal_ros.recordings.signals.signals_file import read_signals
from squeal_ros.recordings.tables.csv_recording import CsvRecording
import yaml

# as a dynamometer logs a stop
DYNO = ('Zeit [s]', 'Drehzahl [1/min]', 'Druck [bar]', 'Reibwert [-]', 'Scheibentemp. [°C]')
INPUTS = {'rotor_speed': (DYNO[1], '1/min'), 'pressure': (DYNO[2], 'bar'),
          'friction': (DYNO[3], '-'), 'temperature': (DYNO[4], 'degC')}


def stop(rows: int = 100) -> Iterator[tuple[float, ...]]:
    """Yield time [s], speed [1/min], pressure [bar], friction and temperature [degC]."""
    for number in range(rows):
        time = 0.02 * number
        yield (time, 95.5 + 0.4 * math.sin(9.0 * time), min(8.5 * time, 10.0) + 0.03 * math.sin(
            40.0 * time), 0.4 + 0.01 * time, 100.0 + 3.0 * time)


def stop_text(rows: int = 100) -> str:
    """Return the table in the manner of a German dynamometer."""
    lines = [';'.join(DYNO), *(';'.join(f'{cell:.4f}' for cell in row).replace('.', ',')
                               for row in stop(rows))]
    return '\n'.join(lines) + '\n'


def document(columns: dict[str, tuple[str, str]] | None = None, **top: Any) -> dict[str, Any]:
    """Return what a file of signals says; `columns`: name and unit of each input."""
    inputs = {signal: {'column': name, 'unit': unit}
              for signal, (name, unit) in (columns or INPUTS).items()}
    return {'clock': {'column': DYNO[0], 'unit': 's'}, 'brakes': {'fl': inputs}, **top}


def signals_file(path: Path, content: dict[str, Any] | None = None) -> Path:
    path.write_text(yaml.safe_dump(document() if content is None else content), encoding='utf-8')
    return path


def opened(path: Path, content: dict[str, Any] | None = None) -> CsvRecording:
    """Return a table opened through a file of signals beside it."""
    signals = read_signals(signals_file(path.with_name('signals.yaml'), content))
    recording = open_recording(path, settings_with_signals(default_settings(), signals),
                               signals=signals)
    assert isinstance(recording, CsvRecording)
    return recording


def default_settings() -> MonitorSettings:
    return read_settings({})


def values(recording: CsvRecording) -> dict[str, list[tuple[float, float]]]:
    """Return time [s] and value [SI] of all samples of each input."""
    found: dict[str, list[tuple[float, float]]] = {}
    for _, samples in recording.samples():
        for _, signal, sample in samples:
            if isinstance(sample, Sample):
                found.setdefault(signal, []).append((sample.stamp * 1e-9, sample.value))
    return found

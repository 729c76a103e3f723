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

"""Measurements in MDF: channels of several groups, units, texts for numbers, start times."""

from collections.abc import Sequence
from datetime import datetime, timedelta, timezone, UTC
from pathlib import Path
from typing import Any

import numpy as np
import pytest

asammdf = pytest.importorskip('asammdf', reason='needs asammdf')
from squeal_core.common.errors import SquealError  # noqa: E402
from squeal_core.monitor.vehicle_monitor import MissingValue, Sample  # noqa: E402
from squeal_ros.cli.main import main  # noqa: E402
from squeal_ros.recordings.recording import Recording  # noqa: E402
from squeal_ros.recordings.recording_files import open_recording  # noqa: E402
from squeal_ros.recordings.signals.signal_settings import settings_with_signals  # noqa: E402
from squeal_ros.recordings.signals.signals_file import read_signals  # noqa: E402
from squeal_ros.recordings.tables import mdf_file  # noqa: E402
from support.tables import default_settings, signals_file  # noqa: E402, I100

START = datetime(2026, 11, 26, 10, 0, tzinfo=timezone(timedelta(hours=1)))
FAST, SLOW = np.arange(0.0, 2.0, 0.01), np.arange(0.0, 2.0, 0.25)
SAYS = {'val_0': 255.0, 'text_0': 'SNA', 'default_addr': {'a': 1.0, 'b': 0.0}}


def channel(name: str, times: Any, values: Any, unit: str = '', **about: Any) -> Any:
    return asammdf.Signal(values, times, name=name, unit=unit, **about)


def write(path: Path, start: datetime | None = START, groups: Sequence[Sequence[Any]] = (),
          **about: Any) -> Path:
    file = asammdf.MDF(version='4.10')
    if start is not None:
        file.start_time = start
    for group in groups or (
            (channel('p_VL', FAST, 80.0 + FAST, 'bar'),
             channel('n_VL', FAST, 200.0 - FAST, 'rpm')),
            (channel('T_Scheibe_VL', SLOW, 100.0 + SLOW, '°C'),),
            (channel('p_VL', SLOW, 0.0 * SLOW, 'bar'),)):
        file.append(list(group), comment='')
    return Path(file.save(path.with_suffix('.mf4'), **about))


CHANNELS = {'rotor_speed': {'channel': 'n_VL', 'unit': 'rpm'},
            'pressure': {'channel': 'p_VL', 'group': 0, 'unit': 'bar'},
            'temperature': {'channel': 'T_Scheibe_VL', 'unit': 'degC', 'max_age': 1.0}}


def opened(path: Path, inputs: dict[str, Any] | None = None, **top: Any) -> Recording:
    signals = read_signals(signals_file(path.with_suffix('.yaml'), {
        'brakes': {'fl': inputs or CHANNELS}, **top}))
    return open_recording(path, settings_with_signals(default_settings(), signals),
                          signals=signals)


def values(recording: Recording) -> dict[str, list[tuple[float, float]]]:
    """Return time [s] and value [SI] of each input; the times of recording rise."""
    found: dict[str, list[tuple[float, float]]] = {}
    last = 0
    for time, samples in recording.samples():
        assert time >= last
        last = time
        for _, signal, sample in samples:
            if isinstance(sample, Sample):
                found.setdefault(signal, []).append((sample.stamp * 1e-9, sample.value))
    return found


@pytest.mark.parametrize('compression', [0, 2])
def test_groups_at_their_own_rates_from_the_start_time(
        compression: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mdf_file, '_BLOCK', 30)
    recording = opened(write(tmp_path / 'a', compression=compression))
    assert recording.messages == len(FAST) + len(SLOW)
    found, zero = values(recording), START.timestamp()
    assert found['pressure'] == [pytest.approx((zero + t, 8e6 + 1e5 * t)) for t in FAST]
    assert found['temperature'] == [pytest.approx((zero + t, 373.15 + t)) for t in SLOW]
    assert len(found['rotor_speed']) == len(FAST)
    assert (recording.notes, recording.findings) == ([], [])


def test_texts_for_numbers_and_invalid_records_are_missing(tmp_path: Path) -> None:
    raw = np.where(np.arange(len(FAST)) % 50 == 7, 255.0, 80.0)
    speed = channel('n_VL', FAST, 200.0 - FAST, 'rpm', invalidation_bits=np.arange(len(FAST)) < 5)
    path = write(tmp_path / 'a', groups=((
        channel('p_VL', FAST, raw, 'bar', conversion=SAYS), speed),
        (channel('T_Scheibe_VL', SLOW, 100.0 + SLOW, 'K'),)))
    recording = opened(path, {**CHANNELS, 'pressure': {'channel': 'p_VL', 'unit': 'bar'}})
    assert len(values(recording)['pressure']) == 196
    said = ' '.join(recording.notes)
    assert "fl.pressure: 4 of 200 cells of 'p_VL' are empty: taken as missing" in said
    assert "fl.rotor_speed: 5 of 200 cells of 'n_VL' are empty" in said
    assert "column 'T_Scheibe_VL' states K, and the file degC, which is taken" in said


def test_texts_alone_are_missing_and_a_finding(tmp_path: Path) -> None:
    path = write(tmp_path / 'a', groups=((
        channel('p_VL', FAST, 0.0 * FAST, 'bar', conversion={'val_0': 0, 'text_0': 'low'}),
        channel('n_VL', FAST, 200.0 - FAST, 'rpm')),
        (channel('T_Scheibe_VL', SLOW, 100.0 + SLOW, '°C'),)))
    recording = opened(path, {**CHANNELS, 'pressure': {'channel': 'p_VL', 'unit': 'bar'}})
    told = [sample.reason for _, samples in recording.samples() for _, _, sample in samples
            if isinstance(sample, MissingValue)]
    assert told == ["'low' is no number"] * len(FAST)
    (finding,) = recording.findings
    assert "'p_VL' has no number in 200 texts and 0 empty cells" in finding.what


@pytest.mark.parametrize(('start', 'clock', 'first', 'said'), [
    (START, {'offset': 2.5}, START.timestamp() + 2.5, ''),
    (START, {'start': 1000.0}, 1000.0, ''),
    (START.replace(tzinfo=None), {}, START.timestamp() + 3600.0, 'taken as UTC'),
    (START.replace(tzinfo=None), {'timezone': 'Europe/Berlin'}, START.timestamp(), ''),
    (datetime(1970, 1, 1, tzinfo=UTC), {'offset': -2.5}, 0.5, '3 s are added')])
def test_starts(start: datetime, clock: dict[str, Any], first: float, said: str,
                tmp_path: Path) -> None:
    recording = opened(write(tmp_path / 'a', start), clock=clock)
    found = values(recording)
    assert found['temperature'][0][0] == pytest.approx(first)
    assert found['pressure'][0][0] == pytest.approx(first)
    assert said in ' '.join(recording.notes)


@pytest.mark.parametrize(('inputs', 'error'), [
    ({'pressure': {'channel': 'p_VL', 'unit': 'bar'}}, "'p_VL' is in the groups 0, 2 of"),
    ({'pressure': {'channel': 'p_HL', 'unit': 'bar'}}, 'did you mean p_VL.*its channels are'),
    ({'pressure': {'channel': 'p_VL', 'group': 1, 'unit': 'bar'}}, 'give one: group: NUMBER')])
def test_wrong_channels_are_one_line(inputs: dict[str, Any], error: str, tmp_path: Path) -> None:
    with pytest.raises(SquealError, match=error):
        opened(write(tmp_path / 'a'), {**CHANNELS, **inputs})


def test_a_damaged_measurement_is_one_line(tmp_path: Path) -> None:
    path = write(tmp_path / 'a')
    data = path.read_bytes()
    for part in (b'', b'MDF     4.10    ', data[:300], data[:len(data) // 2], bytes(3000)):
        path.write_bytes(part)
        with pytest.raises(SquealError, match='cannot be read|is cut off|has no') as error:
            values(opened(path))
        assert '\n' not in str(error.value)


def test_of_a_damaged_block_its_records_are_lost_and_counted(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    times = np.arange(300_000) * 0.001  # two blocks of four megabytes, and a part
    noise = np.random.default_rng(1).normal(size=times.size)
    path = write(tmp_path / 'a', compression=2, groups=((
        channel('p_VL', times, 80.0 + noise, 'bar'), channel('n_VL', times, 200.0 - times, 'rpm'),
        channel('T_Scheibe_VL', times, 100.0 + times, '°C')),))
    data = bytearray(path.read_bytes())
    middle = data.index(b'##DZ', data.index(b'##DZ') + 4) + 20_000
    data[middle:middle + 1000] = bytes(1000)
    path.write_bytes(data)
    monkeypatch.setattr(mdf_file, '_BLOCK', 20_000)
    recording = opened(path, {**CHANNELS, 'pressure': {'channel': 'p_VL', 'unit': 'bar'}})
    read = [round((time - START.timestamp()) * 1e3) for time, _ in values(recording)['pressure']]
    lost = sorted(set(range(300_000)) - set(read))
    assert 131_072 <= len(lost) < 131_072 + 22_000
    assert lost == list(range(lost[0], lost[-1] + 1))
    assert 130_000 < lost[0] <= 131_072
    assert f'{len(lost)} of its 300000 records cannot be read' in ' '.join(recording.notes)


def test_positions_are_in_channels_of_a_group(tmp_path: Path) -> None:
    path = write(tmp_path / 'a', groups=((
        channel('p_VL', FAST, 80.0 + FAST, 'bar'), channel('n_VL', FAST, 200.0 - FAST, 'rpm'),
        channel('mu', FAST, 0.4 + 0.0 * FAST)),
        (channel('Lat', SLOW, 48.0 + SLOW, '°'), channel('Long', SLOW, 11.0 + SLOW, '°'))))
    signals = tmp_path / 'p.yaml'
    assert main(['signals', str(path), '-o', str(signals)]) == 0
    read = read_signals(signals)
    recording = open_recording(path, settings_with_signals(default_settings(), read), signals=read)
    assert recording.messages == len(FAST) + len(SLOW)
    values(recording)
    assert recording.positions.at(round(1e9 * (START.timestamp() + 0.6))) == pytest.approx(
        (48.6, 11.6))


def test_the_proposal_is_usable_as_it_is(tmp_path: Path,
                                         capfd: pytest.CaptureFixture[str]) -> None:
    path, signals = write(tmp_path / 'a'), tmp_path / 'a.yaml'
    assert main(['signals', str(path), '-o', str(signals)]) == 0
    assert 'p_VL (group 0): [bar], 200 values, 100 Hz, 80 to 81.99' in capfd.readouterr().out
    read = read_signals(signals)
    recording = open_recording(path, settings_with_signals(default_settings(), read), signals=read)
    assert {source.brake for source in read.sources} == {'front_left'}
    assert set(values(recording)) == {'rotor_speed', 'pressure', 'temperature'}

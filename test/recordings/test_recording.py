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

"""Which recordings are found, and what each format gives."""

import math
from pathlib import Path

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')
import numpy as np  # noqa: E402, I100
from squeal_core.monitor.settings import read_settings  # noqa: E402
from squeal_ros.recordings.positions import Positions  # noqa: E402
from squeal_ros.recordings.recording import RecordingError  # noqa: E402
from squeal_ros.recordings.recording_files import find_recordings, open_recording  # noqa: E402
from support.bags import (  # noqa: E402, I100
    braking,
    Entry,
    FLOAT,
    header,
    make,
    SECOND,
    START,
    storage_file,
    write_bag,
)


def touched(folder: Path, *names: str) -> None:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


def found(folder: Path, *patterns: str) -> list[str]:
    return [str(path.relative_to(folder))
            for path in find_recordings([folder / pattern for pattern in patterns])]


def test_folders_files_and_patterns(tmp_path: Path) -> None:
    touched(tmp_path, 'week/bag/metadata.yaml', 'week/bag/bag_0.mcap', 'week/bag/bag_1.mcap',
            'week/split/split_0.db3', 'week/split/split_1.db3', 'week/.hidden/x.mcap',
            'week/many/b.mcap', 'week/many/a_10.mcap', 'week/many/a_9.db3', 'week/notes.md',
            'out/drive/summary.json', 'out/drive/outputs.mcap', 'one/x.mcap', 'one/x.summary.json',
            'one/y.mcap', 'odd[1].mcap')
    week = ['week/bag', 'week/many/a_9.db3', 'week/many/a_10.mcap', 'week/many/b.mcap',
            'week/split']
    assert found(tmp_path, 'week') == week
    assert found(tmp_path, 'week/*', 'week/bag', 'week/../week/many/b.mcap') == week
    assert found(tmp_path, 'week/**/a_*') == week[1:3]
    assert found(tmp_path, 'odd[1].mcap') == ['odd[1].mcap']
    assert found(tmp_path, 'one') == ['one/y.mcap']  # x.mcap is an output
    (tmp_path / 'linked').symlink_to(tmp_path / 'week')
    assert found(tmp_path, 'linked', 'week') == [
        path.replace('week', 'linked', 1) for path in week]


def test_parts_of_one_bag_and_drives_of_several_days(tmp_path: Path) -> None:
    """In a renamed folder without metadata.yaml, by their times."""
    for folder, later in (('renamed', 1), ('days', 86_400)):
        (tmp_path / folder).mkdir()
        for number in range(2):
            part = write_bag(tmp_path / f'{folder}_{number}', [
                Entry('/fl/friction', FLOAT, START + (number * later + second) * SECOND,
                      make(FLOAT, data=0.4)) for second in range(2)])
            storage_file(part).rename(tmp_path / folder / f'drive_{number}.mcap')
    assert found(tmp_path, 'renamed') == ['renamed']
    assert found(tmp_path, 'days') == ['days/drive_0.mcap', 'days/drive_1.mcap']
    (tmp_path / 'days' / 'drive_0.mcap').write_bytes(b'cut off')  # its times are not known
    assert found(tmp_path, 'days') == ['days']


def test_a_folder_of_one_file_is_a_bag_by_its_name_alone(tmp_path: Path) -> None:
    touched(tmp_path, 'car/drive.mcap', 'bag/bag_0.mcap', 'own/own.db3')
    assert found(tmp_path, 'car', 'bag', 'own') == ['bag', 'car/drive.mcap', 'own']


def test_positions_of_fixes(tmp_path: Path) -> None:
    fix, status = 'sensor_msgs/msg/NavSatFix', make('sensor_msgs/msg/NavSatStatus', status=0,
                                                    service=1)
    fixes = [Entry('/gps', fix, START + number * SECOND, make(
        fix, header=header(START), status=status, latitude=48.0 + number, longitude=9.0,
        altitude=0.0, position_covariance=np.zeros(9), position_covariance_type=0))
        for number in range(3)]
    settings = read_settings({'brakes': ['fl']})
    recording = open_recording(write_bag(tmp_path / 'bag', [*fixes, *braking(2.5)]), settings)
    assert sum(bool(samples) for _, samples in recording.samples()) == 150
    at = recording.positions.at
    assert (at(START + SECOND), at(START + 3 * SECOND // 2)) == ((49.0, 9.0), (49.5, 9.0))
    assert all(map(math.isnan, (*at(START - 1), *at(START + 60 * SECOND))))


@pytest.mark.parametrize('east', [179.9, -179.9])
def test_positions_do_not_go_round_the_earth_at_the_date_line(east: float) -> None:
    positions = Positions()
    for second, longitude in ((1, east), (2, -east), (3, -0.5 * east - math.copysign(90.0, east))):
        positions.take(second * SECOND, 60.0, longitude)
    assert positions.at(3 * SECOND // 2) == (60.0, east)
    assert positions.at(5 * SECOND // 2)[1] == pytest.approx(-math.copysign(179.925, east))


@pytest.mark.parametrize('pattern', ['out', 'nothing*.mcap', 'missing.mcap', 'a\0b', 'x' * 5000])
def test_nothing_found_is_one_line(pattern: str, tmp_path: Path) -> None:
    touched(tmp_path, 'out/drive/summary.json', 'out/drive/outputs.mcap')
    with pytest.raises(RecordingError, match=r'give files, folders or patterns of \.mcap'):
        found(tmp_path, pattern)

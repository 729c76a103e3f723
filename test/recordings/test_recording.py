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

from pathlib import Path

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')
from squeal_ros.recordings.recording import find_recordings, RecordingError  # noqa: E402


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
            'week/split/drive_0.db3', 'week/split/drive_1.db3', 'week/.hidden/x.mcap',
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


@pytest.mark.parametrize('pattern', ['out', 'nothing*.mcap', 'missing.mcap', 'a\0b', 'x' * 5000])
def test_nothing_found_is_one_line(pattern: str, tmp_path: Path) -> None:
    touched(tmp_path, 'out/drive/summary.json', 'out/drive/outputs.mcap')
    with pytest.raises(RecordingError, match=r'give files, folders or patterns of \.mcap'):
        found(tmp_path, pattern)

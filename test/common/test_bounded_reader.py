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

"""The opener of files that are read: regular files of a bounded size, one line for the rest."""

import os
from pathlib import Path

import pytest
from squeal_core.common.bounded_reader import check_readable, read_bounded, read_text_bounded
from squeal_core.common.errors import ModelFileError


def refused(path: str | Path, words: str, most: int = 100) -> None:
    for read in (read_bounded, check_readable):
        with pytest.raises(ModelFileError, match=words) as caught:
            read(path, most, ModelFileError)
        assert str(caught.value).startswith(str(path))
        assert '\n' not in str(caught.value)


def test_a_file_and_a_link_to_it_are_read(tmp_path: Path) -> None:
    path = tmp_path / 'file'
    path.write_bytes('µ\n'.encode())
    (tmp_path / 'link').symlink_to(path)
    assert read_bounded(tmp_path / 'link', 3, ModelFileError) == path.read_bytes()
    assert read_text_bounded(path, 3, ModelFileError) == 'µ\n'
    assert check_readable(path, 3, ModelFileError) == 3
    refused(path, 'has 3 bytes, more than the 2', 2)


def test_what_is_no_regular_file_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / 'pipe')
    refused(tmp_path / 'pipe', 'is a pipe')
    (tmp_path / 'link').symlink_to('/dev/zero')
    for path in ('/dev/zero', '/dev/full', '/dev/null', tmp_path / 'link'):
        refused(path, 'is a device')
    refused(tmp_path, 'is a folder')
    (tmp_path / 'loop').symlink_to(tmp_path / 'loop')
    refused(tmp_path / 'loop', 'Too many levels')
    refused(tmp_path / 'nothing', 'No such file.*check the path')
    refused('a\0b', 'null')


def test_a_file_that_is_larger_than_it_says_is_refused() -> None:
    status = Path('/proc/self/status')  # states a size of 0
    if not status.exists():
        pytest.skip('no /proc here')
    with pytest.raises(ModelFileError, match='more than the 10 that'):
        read_bounded(status, 10, ModelFileError)


def test_a_sparse_file_is_refused_by_its_size(tmp_path: Path) -> None:
    with (tmp_path / 'sparse').open('wb') as file:
        file.truncate(2**40)
    refused(tmp_path / 'sparse', f'has {2**40} bytes', 500_000_000)


def test_text_of_another_encoding_is_refused(tmp_path: Path) -> None:
    (tmp_path / 'latin').write_bytes(b'B\xe4r')
    with pytest.raises(ModelFileError, match='no UTF-8 text'):
        read_text_bounded(tmp_path / 'latin', 100, ModelFileError)

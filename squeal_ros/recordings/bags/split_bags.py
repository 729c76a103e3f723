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

"""Check that the storage files of a folder without metadata.yaml are those of one bag."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
import re

STORAGE = ('.mcap', '.db3', '.mcap.zstd', '.db3.zstd')
_PART = re.compile(r'(.*)_(\d+)')  # name of a storage file of rosbag2: of its folder, and a number
_LONGEST_GAP = 10_000_000_000  # ns between the parts of a bag: some topic is faster than that


def is_one_bag(folder: Path, files: Sequence[str]) -> bool:
    """
    Return whether files are those that rosbag2 wrote into the folder of one bag.

    They are where they are named after the folder, or, as folders are renamed, where several are
    numbered parts of one name and each begins as the one before ends. Times that cannot be read,
    as of a part that was cut off, tell nothing against it.

    Parameters
    ----------
    folder : Path
        That they are in.
    files : sequence of str
        Names of all recordings in it.

    """
    if not files or not all(file.endswith(STORAGE) for file in files):
        return False
    if {_stem(file) for file in files} == {folder.resolve().name}:
        return True
    parts = {int(part[2]): (part[1], file) for file in files
             if (part := _PART.fullmatch(_stem(file)))}
    names = {name for name, _ in parts.values()}
    if len(parts) < len(files) or len(names) > 1:
        return False
    return names == {folder.resolve().name} or len(parts) > 1 and _follow(
        [folder / parts[number][1] for number in sorted(parts)])


def folder_of(recording: Path) -> Path:
    """
    Return the folder that a recording is in.

    It is the recording's own where that is one without metadata.yaml whose files are not named
    after it: so a folder of a vehicle is one whether it holds one split bag or several drives.
    """
    own = not recording.is_dir() or (recording / 'metadata.yaml').is_file() or any(
        recording.name in (stem, stem.rpartition('_')[0])
        for stem in (_stem(path.name) for path in recording.iterdir()))
    return recording.parent if own else recording


def _stem(file: str) -> str:
    """Return the name of a storage file without its format and packing."""
    return file.removesuffix('.zstd').rpartition('.')[0]


def _follow(files: Sequence[Path]) -> bool:
    """Return whether each file begins as the one before ends, as far as their times are known."""
    times = [bounds for file in files if (bounds := _bounds(file))]
    return all(abs(after[0] - before[1]) <= _LONGEST_GAP for before, after in pairwise(times))


def _bounds(file: Path) -> tuple[int, int] | None:
    """Return the times of the first and the last message [ns]; None: not known."""
    try:
        from squeal_ros.recordings.bags.mcap_chunks import BagStorage

        with BagStorage(file) as storage:
            return (storage.start_time, storage.end_time) if storage.message_count else None
    except Exception:  # damaged, packed, or no rosbags: reading it says what is wrong
        return None

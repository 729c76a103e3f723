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


"""Storage files of a recorded bag: those that are read, and their metadata.yaml."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from squeal_core.common.bounded_reader import kind_of
from squeal_core.common.errors import short_repr, SquealError
from squeal_core.common.yaml_reader import read_yaml
from squeal_ros.recordings.bags.bag_bounds import unpack_file, unpack_message

GIVE_BAG = 'give a rosbag2 folder, or an .mcap, .db3 or .bag file'

_PACKED = '.zstd'
_SUFFIXES = tuple(f'{name}{packed}' for name in ('.mcap', '.db3') for packed in ('', _PACKED))


class BagError(SquealError):
    """A bag that cannot be read or written."""

    def __init__(self, path: object, what: str, remedy: str) -> None:
        super().__init__(f'{path}: {what}; {remedy}')


class BagFiles:
    """
    The storage files of a bag; those of a compressed folder are unpacked.

    Parameters
    ----------
    path : path
        A rosbag2 folder, or an .mcap or .db3 file.

    Attributes
    ----------
    files : list of paths
        To be read, in order of recording.
    notes : list of str
        What a user should know of them.
    counts : Counter
        Messages of each topic by metadata.yaml; empty without one.
    hashes : dict
        Of message types, likewise.
    unpack : callable
        Returns the bytes of a message as it was sent.

    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[str] = []
        self.counts: Counter[str] = Counter()
        self.hashes: dict[str, str] = {}
        self.unpack: Callable[[bytes], bytes] = unpack_message
        self._folder: TemporaryDirectory[str] | None = None
        if not path.exists():
            raise BagError(path, 'does not exist', 'check the path')
        self.files = self._storage_files()

    def _storage_files(self) -> list[Path]:
        """Return the files to read, or the folder where only its metadata says how."""
        if not self.path.is_dir():
            kind = kind_of(self.path.stat().st_mode)
            if kind:
                raise BagError(self.path, f'is {kind}', GIVE_BAG)
            self._note_log(self.path)
            return self._unpacked([self.path])
        present = sorted((p for p in self.path.iterdir() if p.name.endswith(_SUFFIXES)
                          and p.is_file()), key=_natural)
        try:
            listed, packed, form = self._read_metadata()
        except (BagError, KeyError, TypeError, ValueError, AttributeError) as error:
            if not present:
                raise BagError(self.path, 'has no storage file, and no metadata.yaml that can be '
                               f'read ({error})', GIVE_BAG) from None
            self.notes.append(f'{self.path}: metadata.yaml is missing or cannot be read; its '
                              'storage files are read without it')
            self.counts.clear()
            return self._unpacked(present)
        if packed in ('file', 'message') and form != 'zstd':
            raise BagError(self.path, f'is compressed by {short_repr(form)}', 'unpack it first')
        files = [file for file in listed if file.is_file()]
        missing = [file.name for file in listed if file not in files]
        if not files:
            files = present
        if not files:
            raise BagError(self.path, 'has none of its storage files '
                           f'({", ".join(missing) or "metadata.yaml lists none"})', GIVE_BAG)
        if missing:
            self.notes.append(f'{self.path}: {", ".join(missing)} is not there, and '
                              f'{", ".join(file.name for file in files)} is read')
        for file in files:
            self._note_log(file)
        return self._unpacked(files)

    def _read_metadata(self) -> tuple[list[Path], str, str]:
        """Read metadata.yaml; return the files it lists, and their compression."""
        about = read_yaml(
            self.path / 'metadata.yaml', BagError, most_bytes=5_000_000, most_nodes=200_000)[
            'rosbag2_bagfile_information']
        listed = [self.path / Path(name).name for name in about['relative_file_paths']]
        for item in about['topics_with_message_count']:
            topic = item['topic_metadata']
            self.counts[topic['name']] = int(item['message_count'])
            self.hashes[topic['type']] = str(topic.get('type_description_hash', ''))
        return (listed, str(about.get('compression_mode') or 'none').lower(),
                about.get('compression_format') or 'none')

    def _unpacked(self, files: list[Path]) -> list[Path]:
        """Return the files, packed ones unpacked into a folder that goes with this object."""
        result = []
        for file in files:
            if file.suffix == _PACKED:
                self._folder = self._folder or TemporaryDirectory()
                target = Path(self._folder.name, file.stem)
                self.notes += filter(None, [unpack_file(file, target, BagError)])
                file = target
            result.append(file)
        return result

    def _note_log(self, file: Path) -> None:
        log = file.with_name(f'{file.name}-wal')
        if log.is_file() and log.stat().st_size:
            self.notes.append(f'{file}: messages still in {log.name} are not read; open it once '
                              'with sqlite3 to have them written into it')


def _natural(path: Path) -> list[tuple[int, str]]:
    """Return a key by which bag_10 comes after bag_9."""
    parts, number = [], ''
    for letter in f'{path.name} ':
        if letter.isdecimal():
            number += letter
            continue
        if number:
            parts.append((int(number), ''))
            number = ''
        parts.append((-1, letter))
    return parts

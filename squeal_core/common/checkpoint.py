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

"""The finished parts of a file that is not, a small archive each, in a folder beside it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
import glob
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

from squeal_core.common.npz_archive import (
    ArchiveKind,
    Arrays,
    Header,
    read_archive,
    write_archive,
)
from squeal_core.common.output import make_folder

_Part = TypeVar('_Part')


@dataclass(frozen=True)
class Checkpoint(ABC, Generic[_Part]):
    """
    The finished parts of one file that takes long to compute.

    A part is written as soon as it is done, so a run that was interrupted or killed goes on from
    there. The folder's name holds the hash.

    Parameters
    ----------
    output : Path
        Where the file will be written.
    key : str
        Hash over all that the parts depend on.
    say : callable
        Told in one line what was kept, and what was damaged.

    """

    output: Path
    key: str
    say: Callable[[str], None] = field(default=lambda _: None)

    kind: ClassVar[ArchiveKind]
    whole: ClassVar[str]  # the file that a part is of, such as 'table'
    suffix: ClassVar[str]  # of the folder
    kept: ClassVar[str]  # the message on `found` parts of `total`
    wanted: ClassVar[Mapping[str, str]]  # arrays of a part, as of `read_archive`

    @abstractmethod
    def pack(self, part: _Part) -> tuple[Header, Mapping[str, Any]]:
        """Return the header and the arrays that hold a part."""

    @abstractmethod
    def unpack(self, header: Header, arrays: Arrays) -> _Part:
        """Return a part; a KeyError, TypeError, ValueError or StopIteration: it is none."""

    def check_shapes(self, header: Header, shapes: Mapping[str, tuple[int, ...]]) -> None:
        """Raise a SquealError for arrays that do not fit each other, before they are read."""

    @property
    def folder(self) -> Path:
        """Return the folder of the parts."""
        return self.output.with_name(f'{self.output.name}.{self.key[:12]}{self.suffix}')

    @property
    def count(self) -> int:
        """Return the number of parts that are kept."""
        return sum(1 for _ in self.folder.glob('*.npz'))

    def read(self, places: Collection[int]) -> dict[int, _Part]:
        """Return the finished ones of the parts at some places."""
        result = {}
        for place in places:
            if self._path(place).exists():
                try:
                    result[place] = self._part(place)
                except self.kind.error as error:
                    self.say(str(error))
        if result:
            self.say(self.kept.format(found=len(result), total=len(places)))
        return result

    def keep(self, place: int, part: _Part) -> None:
        """
        Write a finished part.

        Raises
        ------
        OutputError
            Where it cannot be written.

        """
        make_folder(self.folder)
        header, arrays = self.pack(part)
        write_archive(self._path(place), self.kind, {
            'schema': self.kind.schemas[-1], 'key': self.key, self.kind.contents: place,
            **header}, arrays)

    def remove(self) -> None:
        """Remove the parts, and what runs with other settings left for the same file."""
        pattern = f'{glob.escape(self.output.name)}.*{self.suffix}'
        for folder in self.output.parent.glob(pattern):
            with suppress(OSError):
                for path in folder.glob('*.npz*'):
                    path.unlink()
                folder.rmdir()

    def _path(self, place: int) -> Path:
        return self.folder / f'{place}.npz'

    def _part(self, place: int) -> _Part:
        path, kind = self._path(place), self.kind
        header, arrays = read_archive(path, kind, lambda _: self.wanted, self.check_shapes)
        if (header.get('key'), header.get(kind.contents)) != (self.key, place):
            raise kind.error(path, f'is a {kind.contents} of another {self.whole}', kind.again)
        try:
            return self.unpack(header, arrays)
        except (KeyError, TypeError, ValueError, StopIteration) as error:
            raise kind.error(path, f'holds no usable {kind.contents} ({error})', kind.again
                             ) from None

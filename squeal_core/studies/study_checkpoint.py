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

"""
The finished boxes of a study that is not finished, a small file each, in a folder beside it.

As of a table that is built: the folder's name holds a hash over all that results depend on.
"""

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
import glob
from pathlib import Path

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import LocatedError
from squeal_core.common.npz_archive import ArchiveKind, Header, read_archive, write_archive
from squeal_core.common.output import make_folder

SCHEMA = 1
_SUFFIX = '.parts'


class StudyPartError(LocatedError):
    """A finished box of a study that cannot be read."""


_KIND = ArchiveKind(
    noun='part of a study', contents='part', format='squeal_ros part of a study',
    schemas=range(SCHEMA, SCHEMA + 1), error=StudyPartError, again='it is computed again',
    renew='it is computed again', missing=lambda _: 'it is computed again')


@dataclass(frozen=True, eq=False)
class BoxResult:
    """Columns (P,) of a box by name, counts of solutions, why points are impossible or ''."""

    columns: dict[str, FloatArray]
    counts: dict[str, float]
    reason: str


@dataclass(frozen=True)
class StudyCheckpoint:
    """
    The finished boxes of one study.

    Parameters
    ----------
    output : Path
        Where the study will be written.
    key : str
        Hash over all that results depend on.
    say : callable
        Told in one line what was kept, and what was damaged.

    """

    output: Path
    key: str
    say: Callable[[str], None] = field(default=lambda _: None)

    @property
    def folder(self) -> Path:
        """Return the folder of the boxes."""
        return self.output.with_name(f'{self.output.name}.{self.key[:12]}{_SUFFIX}')

    def read(self, jobs: Iterable[int]) -> dict[int, BoxResult]:
        """Return the finished ones of some jobs."""
        found = {}
        for job in jobs:
            if self._path(job).exists():
                try:
                    found[job] = self._box(job)
                except StudyPartError as error:
                    self.say(str(error))
        if found:
            self.say(f'kept from an earlier run: {len(found)} of its parts')
        return found

    def keep(self, job: int, result: BoxResult) -> None:
        """
        Write a finished box.

        Raises
        ------
        OutputError
            Where it cannot be written.

        """
        make_folder(self.folder)
        header: Header = {'schema': SCHEMA, 'key': self.key, 'job': job, 'reason': result.reason,
                          'counts': result.counts, 'columns': list(result.columns)}
        write_archive(self._path(job), _KIND, header, {
            'values': np.array(list(result.columns.values()), float)})

    def remove(self) -> None:
        """Remove the boxes, and what studies with other settings left for the same file."""
        pattern = f'{glob.escape(self.output.name)}.*{_SUFFIX}'
        for folder in self.output.parent.glob(pattern):
            with suppress(OSError):
                for path in folder.glob('*.npz*'):
                    path.unlink()
                folder.rmdir()

    def _path(self, job: int) -> Path:
        return self.folder / f'{job}.npz'

    def _box(self, job: int) -> BoxResult:
        path = self._path(job)
        header, arrays = read_archive(path, _KIND, lambda _: {'values': '<f8'})
        if (header.get('key'), header.get('job')) != (self.key, job):
            raise StudyPartError(path, 'is a part of another study', 'it is computed again')
        try:
            return BoxResult(dict(zip(header['columns'], arrays['values'], strict=True)),
                             dict(header['counts']), str(header['reason']))
        except (KeyError, TypeError, ValueError) as error:
            raise StudyPartError(path, f'holds no usable part ({error})', 'it is computed again'
                                 ) from None

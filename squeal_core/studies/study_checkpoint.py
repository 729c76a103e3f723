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

"""Finished boxes of an unfinished study."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.checkpoint import Checkpoint
from squeal_core.common.errors import LocatedError
from squeal_core.common.npz_archive import ArchiveKind, Arrays, Header

SCHEMA = 1


class StudyPartError(LocatedError):
    """A finished box of a study that cannot be read."""


@dataclass(frozen=True, eq=False)
class BoxResult:
    """Columns (P,) of a box by name, counts of solutions, why points are impossible or ''."""

    columns: dict[str, FloatArray]
    counts: dict[str, float]
    reason: str


class StudyCheckpoint(Checkpoint[BoxResult]):
    """The finished boxes of one study, by number of their job."""

    kind = ArchiveKind(
        noun='part of a study', contents='part', format='squeal_ros part of a study',
        schemas=range(SCHEMA, SCHEMA + 1), error=StudyPartError, again='it is computed again',
        renew='it is computed again', missing=lambda _: 'it is computed again')
    whole, suffix = 'study', '.parts'
    kept = 'kept from an earlier run: {found} of its parts'
    wanted = {'values': '<f8'}

    def pack(self, part: BoxResult) -> tuple[Header, Mapping[str, Any]]:
        """Return the header and the arrays that hold a box."""
        header = {'reason': part.reason, 'counts': part.counts, 'columns': list(part.columns)}
        return header, {'values': np.array(list(part.columns.values()), float)}

    def unpack(self, header: Header, arrays: Arrays) -> BoxResult:
        """Return a box."""
        return BoxResult(dict(zip(header['columns'], arrays['values'], strict=True)),
                         dict(header['counts']), str(header['reason']))

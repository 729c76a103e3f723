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

"""The record of a study: figures at the points of a grid over any number of parameters."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.surrogate.grid_columns import EXPANSION, FULL, IMPOSSIBLE

SOURCES = {0.0: 'not done', FULL: 'full', EXPANSION: 'expansion', IMPOSSIBLE: 'impossible'}


@dataclass(frozen=True, eq=False, kw_only=True)
class Study:
    """
    Figures at the points of a grid; the last axis runs fastest.

    Parameters
    ----------
    axes : dict
        Values by parameter: of the operation in SI units, of the brake description in its own.
    columns : dict
        Figures (M,) by name, NaN where there is none; 'source' is a key of `SOURCES`.
    about : dict
        What was asked for, 'counts' of solutions, 'impossible' points and why.

    """

    axes: dict[str, FloatArray]
    columns: dict[str, FloatArray]
    about: dict[str, Any]

    __repr__ = repr_with_shapes

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(values) for values in self.axes.values())

    @property
    def size(self) -> int:
        return int(self.columns['source'].size)

    @property
    def done(self) -> NDArray[np.bool_]:
        """Return whether each point was evaluated, (M,); some of them may be impossible."""
        return np.asarray(self.columns['source'] != 0.0)

    def count(self, source: float) -> int:
        """Return the number of points of a source."""
        return int(np.count_nonzero(self.columns['source'] == source))

    def places(self) -> dict[str, FloatArray]:
        """Return each parameter at each point, (M,)."""
        grids = np.meshgrid(*self.axes.values(), indexing='ij')
        return {name: grid.ravel() for name, grid in zip(self.axes, grids, strict=True)}

    def grid(self, column: str) -> FloatArray:
        """Return a column as the grid."""
        return self.columns[column].reshape(self.shape)


def in_order(axes: Mapping[str, FloatArray], solved_order: tuple[str, ...],
             columns: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """
    Return columns in the order of the axes.

    Parameters
    ----------
    axes : mapping
        Values by parameter, as asked for.
    solved_order : tuple of str
        The parameters as they run in the columns given, the last one fastest.
    columns : mapping
        Figures by name.

    """
    shape = [len(axes[name]) for name in solved_order]
    order = [solved_order.index(name) for name in axes]
    return {name: np.ascontiguousarray(values.reshape(shape).transpose(order)).ravel()
            for name, values in columns.items()}

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

"""Mode shapes on a coarse grid of surfaces: for plots only, no result depends on them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, readonly, repr_with_shapes
from squeal_core.common.errors import ModelError
from squeal_core.modes.modal_basis import SampledShapes


@dataclass(frozen=True)
class Patch:
    """
    A surface of a component: points on `rows` arcs of `columns`, arc by arc.

    A closed one goes round: after the last point of an arc comes its first.
    """

    name: str
    rows: int
    columns: int
    closed: bool

    @property
    def size(self) -> int:
        return self.rows * self.columns

    def triangles(self) -> Iterator[tuple[int, int, int]]:
        """Yield corners, counted from the patch's first point."""
        for row in range(self.rows - 1):
            for column in range(self.columns if self.closed else self.columns - 1):
                a, b = (row * self.columns + c % self.columns for c in (column, column + 1))
                yield a, a + self.columns, b + self.columns
                yield a, b + self.columns, b


@dataclass(frozen=True, eq=False)
class SurfaceShapes:
    """
    Shapes of all N modes of a model at points of its surfaces.

    Parameters
    ----------
    points : (P, 3) array
        x, y, z [m], patch after patch; z along the axis.
    shapes : (P, 3, N) array
        Displacements in x, y, z, mass normalised and with the signs of the model's arrays
        [kg^-1/2].
    patches : tuple of Patch

    Raises
    ------
    ModelError
        For shapes that do not fit each other, and values that are not finite.

    """

    points: FloatArray
    shapes: FloatArray
    patches: tuple[Patch, ...]

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        for name in ('points', 'shapes'):
            object.__setattr__(self, name, readonly(getattr(self, name)))
        count = sum(patch.size for patch in self.patches)
        if self.points.shape != (count, 3) or self.shapes.shape[:2] != (count, 3) \
                or self.shapes.ndim != 3:
            raise ModelError(f'surface: points {self.points.shape}, shapes {self.shapes.shape}; '
                             f'give {(count, 3)} and {(count, 3, "N")} for its patches')
        if not (np.isfinite(self.points).all() and np.isfinite(self.shapes).all()):
            raise ModelError('surface: values are not finite; build the model again')

    @classmethod
    def of(cls, parts: Sequence[tuple[Patch, SampledShapes, FloatArray]]) -> 'SurfaceShapes':
        """
        Return the surfaces of components together, their modes in the order of the model.

        Parameters
        ----------
        parts : sequence of (patch, shapes, heights)
            z at which to draw [m], which may differ from where the shapes were taken.

        """
        total = sum(len(result.normal) for _, result, _ in parts)
        points, blocks, before = [], [], 0
        for _, result, height in parts:
            angle = result.points.angle
            c, s = np.cos(angle), np.sin(angle)
            points.append(np.column_stack([result.points.radius * c, result.points.radius * s,
                                           height]))
            block = np.zeros((angle.size, 3, total))
            here = slice(before, before + len(result.normal))
            block[:, 0, here] = (c * result.radial - s * result.tangential).T
            block[:, 1, here] = (s * result.radial + c * result.tangential).T
            block[:, 2, here] = result.normal.T
            blocks.append(block)
            before = here.stop
        # single precision is plenty for a plot, and half the file
        return cls(np.concatenate(points), np.concatenate(blocks).astype(np.float32),
                   tuple(patch for patch, _, _ in parts))

    def displaced(self, vector: ComplexArray, size: float) -> tuple[FloatArray, FloatArray]:
        """
        Return points at the extreme of a complex mode, and magnitudes of displacement.

        Parameters
        ----------
        vector : (N,) array
            Right vector of the mode, in modal coordinates.
        size : float
            The largest displacement that is drawn [m].

        Returns
        -------
        points : (P, 3) array
        amplitude : (P,) array
            Of the displacement, 0..1.

        """
        moved = self.motion(vector).real
        return self.points + size * moved, np.linalg.norm(moved, axis=1)

    def motion(self, vector: ComplexArray) -> ComplexArray:
        """
        Return the displacements of a complex mode over its cycle, the real part of u exp(i phase).

        Parameters
        ----------
        vector : (N,) array
            Right vector of the mode, in modal coordinates.

        Returns
        -------
        (P, 3) array
            u, which is at its extreme at phase 0: its largest displacement there is 1, the largest
            component of all positive.

        """
        u = self.shapes @ vector
        u = u * np.exp(-0.5j * np.angle(np.sum(u**2)))  # the phase in which it moves the most
        largest = np.linalg.norm(u.real, axis=1).max(initial=0.0)
        if largest == 0.0:
            return np.asarray(u)
        where = np.unravel_index(np.abs(u.real).argmax(), u.shape)
        return np.asarray(u * (np.sign(u.real[where]) / largest))

    def header(self) -> list[dict[str, Any]]:
        """Return the patches as a file's header holds them."""
        return [asdict(patch) for patch in self.patches]

    @classmethod
    def read(cls, patches: Any, arrays: Mapping[str, FloatArray]) -> 'SurfaceShapes | None':
        """Return the surfaces of a model file; None from one that holds none."""
        if not patches:
            return None
        result = tuple(Patch(str(p['name']), int(p['rows']), int(p['columns']), bool(p['closed']))
                       for p in patches)
        if not all(2 <= n <= 1000 for p in result for n in (p.rows, p.columns)):
            raise ModelError('surface: a patch has less than 2 or more than 1000 rows or columns')
        return cls(arrays['surface_points'], arrays['surface_shapes'], result)

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

"""Modes given at the nodes of a mesh, as any finite element package can export them."""

from dataclasses import dataclass, replace

import numpy as np
from squeal_core.common.arrays import FloatArray, readonly, repr_with_shapes
from squeal_core.common.errors import short_repr, SquealError


class ModesError(SquealError):
    """Modal results that cannot be used."""


@dataclass(frozen=True, eq=False)
class ElementBlock:
    """
    Elements of one kind: `tet4`, `tet10`, `hex8`, `hex20`, `hex27`, `wedge6`, `wedge15`.

    Parameters
    ----------
    kind : str
    nodes : (E, n) int array
        Indices into the nodes of the modes: corners first, then mid-edge nodes (bottom edges,
        top edges, vertical edges for hexahedra: the order of VTK).

    """

    kind: str
    nodes: FloatArray

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        object.__setattr__(self, 'nodes', readonly(self.nodes, np.int64))


@dataclass(frozen=True, eq=False)
class NodalModes:
    """
    Natural modes at nodes, in SI units, the rotation axis along z through the origin.

    Parameters
    ----------
    coordinates : (M, 3) array
        Cartesian [m].
    angular_frequencies : (N,) array
        Rising [rad/s].
    shapes : (N, M, 3) array
        Cartesian, mass normalised [kg^-1/2].
    elements : tuple of ElementBlock
        May be empty: then only planar layers of nodes can be integrated over.
    names : tuple of str
        Of the modes; filled in where empty.
    source : str
        Where they come from, for provenance.

    Raises
    ------
    ModesError
        For shapes that do not fit, values that are not finite, fewer than one mode or node.

    """

    coordinates: FloatArray
    angular_frequencies: FloatArray
    shapes: FloatArray
    elements: tuple[ElementBlock, ...] = ()
    names: tuple[str, ...] = ()
    source: str = ''

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        for name in ('coordinates', 'angular_frequencies', 'shapes'):
            array = readonly(getattr(self, name))
            if not np.all(np.isfinite(array)):
                raise ModesError(f'{self.source or "modes"}: {name} holds values that are not '
                                 'finite; export them again')
            object.__setattr__(self, name, array)
        n, m = self.angular_frequencies.size, len(self.coordinates)
        if self.coordinates.shape != (m, 3) or self.shapes.shape != (n, m, 3) or not n * m:
            raise ModesError(
                f'{self.source or "modes"}: coordinates {self.coordinates.shape}, shapes '
                f'{self.shapes.shape} and {n} frequencies do not fit; give (M, 3), (N, M, 3) '
                'and (N,)')
        if np.any(np.diff(self.angular_frequencies) < 0) or self.angular_frequencies[0] < 0:
            raise ModesError(f'{self.source or "modes"}: frequencies do not rise: '
                             f'{short_repr(self.angular_frequencies.tolist())}; sort the modes')
        if not self.names:
            object.__setattr__(self, 'names', tuple(f'mode {i + 1}' for i in range(n)))

    def keep(self, count: int) -> 'NodalModes':
        """Return the `count` lowest modes."""
        return replace(self, angular_frequencies=self.angular_frequencies[:count],
                       shapes=self.shapes[:count], names=self.names[:count])

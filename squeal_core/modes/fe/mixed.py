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
Modes of another package on elements of several kinds, wedges among them; needs no scikit-fem.

Each element's own shape functions carry the shapes and their theta derivatives, as in `solid`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.fe.locate import Cells, check_found, inverse, search
from squeal_core.modes.fe.mass import reference_nodes, rule, shape_functions
from squeal_core.modes.fe.polar import polar
from squeal_core.modes.modal_basis import Quadrature, SampledShapes
from squeal_core.modes.nodal_modes import ElementBlock, ModesError, NodalModes

_CHUNK = 20_000  # quadrature points at a time


@dataclass(frozen=True, eq=False)
class ElementModes:
    """
    Modes of another package, sampled through the elements they came with; a `ModalBasis`.

    Parameters
    ----------
    modes : NodalModes
        With elements of any kinds that `ElementBlock` names.

    Raises
    ------
    ModesError
        For no elements.

    """

    modes: NodalModes

    def __post_init__(self) -> None:
        if not self.modes.elements:
            raise ModesError(f'{self.modes.source or "modes"}: there are no elements; give some, '
                             'or nodes in planar layers')

    @property
    def angular_frequencies(self) -> FloatArray:
        return self.modes.angular_frequencies

    @property
    def names(self) -> tuple[str, ...]:
        return self.modes.names

    def sample(self, points: Quadrature) -> SampledShapes:
        """Return the shapes and their theta derivatives at points of the solid."""
        where = np.array([points.radius * np.cos(points.angle),
                          points.radius * np.sin(points.angle), points.height])
        best = np.full(points.radius.size, np.inf)
        result = np.zeros((2, 3, len(self.names), points.radius.size))
        for block in self.modes.elements:
            number, local, outside = search(self._cells(block), where)
            better = outside < best
            best[better] = outside[better]
            result[..., better] = self._at(block, number[better], local[:, better])
        check_found(best, where)
        return polar(result[0], result[1], points)

    def volume_layers(self) -> Iterator[SampledShapes]:
        """Yield samples at the elements' quadrature points, which together cover the volume."""
        for block in self.modes.elements:
            local, weight = rule(block.kind)
            step, cells = max(1, _CHUNK // len(weight)), self._cells(block)
            for start in range(0, len(block.nodes), step):
                number = np.arange(start, min(start + step, len(block.nodes)))
                every = np.tile(local.T, number.size)
                number = np.repeat(number, len(weight))
                (x, y, z), slopes = cells.geometry(number, every)
                volume = np.abs(np.linalg.det(slopes.transpose(2, 0, 1)))
                points = Quadrature(np.hypot(x, y), np.arctan2(y, x), z,
                                    volume * np.resize(weight, volume.shape))
                field, turned = self._at(block, number, every)
                yield polar(field, turned, points)

    def _cells(self, block: ElementBlock) -> Cells:
        def functions(x: FloatArray) -> tuple[FloatArray, FloatArray]:
            values, gradients = shape_functions(block.kind, x.T)
            return values.T, gradients.transpose(1, 2, 0)

        return Cells(self.modes.coordinates[block.nodes].transpose(2, 1, 0),
                     reference_nodes(block.kind), functions, block.kind.rstrip('0123456789'))

    def _at(self, block: ElementBlock, number: Any, local: FloatArray) -> FloatArray:
        """Return Cartesian components and (x d/dy - y d/dx) of them, (2, 3, N, P)."""
        cells = self._cells(block)
        values, slopes = cells.functions(local)
        where, jacobian = cells.geometry(number, local)
        gradients = np.einsum('pji,njp->nip', inverse(jacobian), slopes)
        turned = where[0] * gradients[:, 1] - where[1] * gradients[:, 0]
        count, size = values.shape
        rows, columns = np.repeat(np.arange(size), count), block.nodes[number].ravel()
        flat = self.modes.shapes.transpose(1, 0, 2).reshape(len(self.modes.coordinates), -1)
        return np.array([(coo_matrix(
            (table.T.ravel(), (rows, columns)), shape=(size, len(flat))).tocsr() @ flat).reshape(
                size, len(self.names), 3).transpose(2, 1, 0) for table in (values, turned)])

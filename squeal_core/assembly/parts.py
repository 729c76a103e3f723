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
The components of brakes, each solved and sampled once for all brakes that share it.

What a component depends on is its key: a disc on its dimensions and material, a pad on its own and
on the contact sector, samples on the component and the points. So of a series of brakes only
those parts are computed again that a change touches. Solutions may be kept on disk, too.
"""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from squeal_core.brake.dimensions import Brake, HatDisc, ModalResults, Pad
from squeal_core.common.arrays import FloatArray
from squeal_core.model import operators
from squeal_core.modes.component_modes import Component, read_component
from squeal_core.modes.modal_basis import ModalBasis, Quadrature, SampledShapes

_Part = TypeVar('_Part')
_DIGITS = 12  # of a height [m] above a pad's lower face: that of a thicker rotor rounds otherwise
MOST_BYTES = 400_000_000
_MOST_PARTS = 12  # some 40 MB each; those used longest ago go first


class PartCache:
    """
    Components of brakes and their samples, by what they depend on.

    Parameters
    ----------
    folder : path, optional
        Keeps solutions on disk (`resources.cache_folder()`); None: in memory only.
    most_bytes : int
        Of samples in memory; the ones used longest ago go first.

    """

    def __init__(self, folder: str | Path | None = None, *, most_bytes: int = MOST_BYTES) -> None:
        self.folder, self._most_bytes = folder, most_bytes
        self._parts: OrderedDict[Hashable, Any] = OrderedDict()
        self._samples: OrderedDict[Hashable, SampledShapes] = OrderedDict()
        self._bytes = 0

    def disc(self, brake: Brake, order: int) -> Component:
        """Return the disc of a brake, on section elements of an order."""
        disc, count = brake.disc, brake.disc_modes
        if isinstance(disc, ModalResults):
            half = 0.5 * brake.rotor_thickness
            return self._results(disc, count, brake, (half, -half))
        key = ('disc', disc, count, order)

        def solve() -> Component:
            from squeal_core.modes.fe.axisymmetric import disc_modes
            assert isinstance(disc, HatDisc)
            basis = disc_modes(disc, count, order=order, cache=self.folder)
            return Component(_SampledOnce(basis, key, self), disc.material.density)

        return self._once(key, solve)

    def pads(self, brake: Brake, elements: tuple[int, int, int]) -> tuple[Component, Component]:
        """Return both pads of a brake, on so many elements in r, theta and z."""
        half = 0.5 * brake.rotor_thickness
        first, second = brake.pads
        return (self._pad(first, brake, elements, half, half),
                self._pad(second, brake, elements, -half, -half - second.thickness))

    def _pad(self, pad: Pad | ModalResults, brake: Brake, elements: tuple[int, int, int],
             face: float, bottom: float) -> Component:
        contact, count = brake.contact, brake.pad_modes
        if isinstance(pad, ModalResults):
            return self._results(pad, count, brake, (face,))
        key = ('pad', pad, contact.inner_radius, contact.outer_radius, contact.angle, count,
               elements)

        def solve() -> ModalBasis:
            from squeal_core.modes.fe.solid import pad_modes
            return pad_modes(pad, contact, count, elements=elements, cache=self.folder)

        return Component(_SampledOnce(self._once(key, solve), key, self, bottom))

    def _results(self, results: ModalResults, count: int, brake: Brake,
                 faces: tuple[float, ...]) -> Component:
        contact = brake.contact
        key = ('results', results, count, contact.inner_radius, contact.outer_radius, faces)

        def read() -> Component:
            result = read_component(results, count, contact, faces)
            return replace(result, basis=_SampledOnce(result.basis, key, self))

        return self._once(key, read)

    def gyroscopic(self, disc: Component) -> FloatArray:
        """Return G0 of a disc."""
        def integrate() -> FloatArray:
            return operators.gyroscopic(disc.basis.volume_layers(), disc.density)

        return self._once(('gyroscopic', disc), integrate)

    def sampled(self, key: Hashable, compute: Callable[[], SampledShapes]) -> SampledShapes:
        """Return samples by their key."""
        if key in self._samples:
            self._samples.move_to_end(key)
            return self._samples[key]
        result = self._samples[key] = compute()
        self._bytes += _size(result)
        while self._bytes > self._most_bytes and len(self._samples) > 1:
            self._bytes -= _size(self._samples.popitem(last=False)[1])
        return result

    def _once(self, key: Hashable, compute: Callable[[], _Part]) -> _Part:
        if key not in self._parts:
            self._parts[key] = compute()
            while len(self._parts) > _MOST_PARTS:
                self._parts.popitem(last=False)
        self._parts.move_to_end(key)
        result: _Part = self._parts[key]
        return result


@dataclass(frozen=True, eq=False)
class _SampledOnce:
    """A component's modes whose samples are kept, `offset` [m] above where they were solved."""

    modes: ModalBasis
    key: Hashable
    cache: PartCache
    offset: float = 0.0

    @property
    def angular_frequencies(self) -> FloatArray:
        return self.modes.angular_frequencies

    @property
    def names(self) -> tuple[str, ...]:
        return self.modes.names

    def sample(self, points: Quadrature) -> SampledShapes:
        local = points if self.offset == 0.0 else replace(
            points, height=np.round(points.height - self.offset, _DIGITS))
        where = tuple(getattr(local, item.name).tobytes() for item in fields(Quadrature)[:3])
        result = self.cache.sampled((self.key, where), lambda: self.modes.sample(local))
        return replace(result, points=points)

    def volume_layers(self) -> Iterator[SampledShapes]:
        for layer in self.modes.volume_layers():
            at = layer.points
            yield replace(layer, points=replace(at, height=at.height + self.offset))


def _size(samples: SampledShapes) -> int:
    return 6 * samples.normal.nbytes

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

"""Shapes of modes, seen from above: of disc and pads alone, and of the whole brake."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, TypeAlias

try:
    from matplotlib import rc_context
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm
    from matplotlib.figure import Figure
    from matplotlib.patheffects import withStroke
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
import numpy as np
from squeal_core.brake.dimensions import HatDisc
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.modes.modal_basis import ModalBasis, Quadrature
from squeal_core.stability.eigensolution import complex_modes, Mode
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_core.verification import Parts
from squeal_core.verification.paper import PRINTED, TORSION
from squeal_core.view.saving import FigureTarget, save_figure
from squeal_core.view.stability_map import STYLE

Direction: TypeAlias = Literal['normal', 'tangential']
_LEVELS = np.linspace(-1.0, 1.0, 16)  # an even number of bands: none of them straddles zero
_NORM, _MAP, _DPI = BoundaryNorm(_LEVELS, 256), 'RdBu_r', 100
_HALO = [withStroke(linewidth=2.0, foreground='white')]
_WORDS = {'normal': 'out of plane', 'tangential': 'along the rotation'}


@dataclass(frozen=True, eq=False)
class _Patch:
    """A piece of surface, seen from above [mm], and the shapes (N, rows, columns) on it."""

    x: FloatArray
    y: FloatArray
    normal: FloatArray
    tangential: FloatArray
    radial: FloatArray
    place: slice

    def motion(self, vector: ComplexArray, direction: str) -> ComplexArray:
        """Return a component of the motion of modal coordinates (N,) of the brake."""
        shapes: FloatArray = getattr(self, direction)
        return np.asarray(np.tensordot(vector[self.place], shapes, (0, 0)))


@dataclass(frozen=True)
class ShapePlot:
    """The surfaces of the brake that are drawn: hat and rotor from above, and pads."""

    disc: tuple[_Patch, _Patch]
    pads: tuple[_Patch, _Patch]

    @classmethod
    @lru_cache(maxsize=1)  # five figures of the same parts
    def of(cls, parts: Parts) -> 'ShapePlot':
        disc, contact = parts.brake.disc, parts.brake.contact
        assert isinstance(disc, HatDisc)  # else there are no parts
        first, half = len(parts.pads[0].names), 0.5 * disc.rotor_thickness
        whole, sector = (0.0, 2.0 * np.pi), (-0.5 * contact.angle, 0.5 * contact.angle)
        own, last = slice(first, -len(parts.pads[1].names)), slice(-len(parts.pads[1].names), None)
        hat = _patch(parts.disc, (disc.clamp_radius, disc.hat_wall_outer_radius), whole,
                     half + disc.hat_height, own)
        rotor = _patch(parts.disc, (disc.hat_wall_outer_radius, disc.rotor_outer_radius), whole,
                       half, own)
        radii = contact.inner_radius, contact.outer_radius
        return cls((hat, rotor), (
            _patch(parts.pads[0], radii, sector, half, slice(0, first)),
            _patch(parts.pads[1], radii, sector, -half, last)))

    def in_phase(self, vector: ComplexArray, direction: Direction) -> ComplexArray:
        """Return a vector with the phase at which most is seen to move, its largest motion 1."""
        motion = np.concatenate([patch.motion(vector, direction).ravel()
                                 for patch in (*self.disc, *self.pads)])
        turn = np.exp(-0.5j * np.angle(np.sum(motion**2)))
        seen = (motion * turn).real
        return np.asarray(vector * turn / seen[np.abs(seen).argmax()])


def _patch(basis: ModalBasis, radii: tuple[float, float], angles: tuple[float, float],
           height: float, place: slice) -> _Patch:
    around = round(np.ptp(angles) / np.deg2rad(1.5)) + 1
    r, t = np.meshgrid(np.linspace(*radii, 25), np.linspace(*angles, around), indexing='ij')
    inside = np.clip(r, radii[0] * (1.0 + 1e-6), radii[1] * (1.0 - 1e-6)).ravel()
    s = basis.sample(Quadrature(inside, (1.0 - 1e-6) * t.ravel(), np.full(r.size, height),
                                np.ones(r.size)))
    normal, tangential, radial = (part.reshape(-1, *r.shape)
                                  for part in (s.normal, s.tangential, s.radial))
    return _Patch(1e3 * r * np.cos(t), 1e3 * r * np.sin(t), normal, tangential, radial, place)


def draw_components(parts: Parts, path: FigureTarget, title: str) -> None:
    """Draw the modes of the components that K09 names, as its fig. 8."""
    plot, model = ShapePlot.of(parts), parts.model
    with rc_context({**STYLE, 'axes.titlesize': 9, 'axes.titlelocation': 'center'}):
        figure = Figure(figsize=(9.0, 7.6), layout='constrained')
        panels = figure.subplots(3, 3).ravel()
        for axes, (_, name, words, *_) in zip(panels, PRINTED, strict=True):
            direction: Direction = 'tangential' if name == TORSION else 'normal'
            vector = np.eye(model.size, dtype=complex)[model.names.index(name)]
            patches = plot.pads[:1] if name.startswith('pad') else plot.disc
            _draw(axes, patches, plot.in_phase(vector, direction), direction)
            hertz = model.angular_frequencies[model.names.index(name)] / 2.0 / np.pi
            axes.set_title(f'{words}: {hertz:.0f} Hz\n{_WORDS[direction]}')
        _finish(figure, panels, path, title)


def draw_modes(parts: Parts, path: FigureTarget, title: str, point: OperatingPoint,
               numbers: Sequence[int], *, direction: Direction = 'normal') -> None:
    """Draw modes of the brake by their place in order of frequency, two in a row."""
    plot = ShapePlot.of(parts)
    every = complex_modes(parts.model, point).modes
    modes = [every[number - 1] for number in numbers]
    rows, columns = -(-len(modes) // 2), min(2, len(modes))
    with rc_context({**STYLE, 'axes.titlesize': 9, 'axes.titlelocation': 'center'}):
        figure = Figure(figsize=(5.2 * columns, 3.4 * rows + 1.2), layout='constrained')
        panels = figure.subplots(rows, 3 * columns, squeeze=False,
                                 width_ratios=(3, 1, 1) * columns).reshape(-1, 3)
        for row, mode in zip(panels, modes, strict=True):
            _mode(row, plot, parts.model, point, mode, direction)
        _finish(figure, panels.ravel(), path, f'{title}, Ω = {point.rotor_speed:g} rad/s, '
                f'µ = {point.friction:.3g}\nmotion {_WORDS[direction]}; pads drawn larger')


def _mode(row: Any, plot: ShapePlot, model: BrakeModel, point: OperatingPoint,
          mode: Mode, direction: Direction) -> None:
    vector = plot.in_phase(mode_vectors(model, point, mode.eigenvalue).right, direction)
    for axes, patches, words in zip(row, (plot.disc, *((pad,) for pad in plot.pads)), (
            f'mode {mode.index}: {mode.frequency_hz:.0f} Hz, {mode.growth_rate:+.1f} 1/s',
            'pad 1 (top)', 'pad 2'), strict=True):
        _draw(axes, patches, vector, direction)
        axes.set_title(words)
    for pad in plot.pads:
        _outline(row[0], pad, color='black', linestyle=(0, (4, 2)), path_effects=_HALO)
    if direction == 'tangential':
        rotor = plot.disc[1]
        out, along = (rotor.motion(vector, way).real for way in ('radial', 'tangential'))
        c, s = rotor.x / np.hypot(rotor.x, rotor.y), rotor.y / np.hypot(rotor.x, rotor.y)
        some = (slice(4, None, 8), slice(None, None, 12))
        row[0].quiver(rotor.x[some], rotor.y[some], (c * out - s * along)[some],
                      (s * out + c * along)[some], scale=14.0, width=0.009, zorder=3,
                      edgecolor='white', linewidth=0.5)


def _draw(axes: Any, patches: Sequence[_Patch], vector: ComplexArray,
          direction: Direction) -> None:
    for patch in patches:
        axes.contourf(patch.x, patch.y, patch.motion(vector, direction).real, levels=_LEVELS,
                      norm=_NORM, cmap=_MAP, extend='both')
        _outline(axes, patch, color='0.3')


def _outline(axes: Any, patch: _Patch, **look: Any) -> None:
    lines = [(patch.x[edge], patch.y[edge]) for edge in (0, -1)]
    if not np.allclose(patch.y[:, 0], patch.y[:, -1]):  # no ring
        lines += [(patch.x[:, edge], patch.y[:, edge]) for edge in (0, -1)]
    for x, y in lines:
        axes.plot(x, y, linewidth=0.8, **look)


def _finish(figure: Any, panels: Any, path: FigureTarget, title: str) -> None:
    for axes in panels:
        axes.set_aspect('equal')
        axes.set_axis_off()
    figure.colorbar(ScalarMappable(_NORM, _MAP), ax=list(panels), location='bottom', aspect=50,
                    shrink=0.6, label='displacement, of the largest shown', pad=0.04,
                    ticks=(-1, 0, 1))
    figure.suptitle(title, fontsize=11, x=0.01, ha='left')
    save_figure(figure, path, dpi=_DPI)

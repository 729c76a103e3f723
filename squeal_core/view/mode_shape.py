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

"""The shape of one mode in three dimensions: a slide, and one cycle of it as a GIF."""

from collections.abc import Iterator, Sequence
from pathlib import Path
import tempfile
from typing import Any, NamedTuple

try:
    from matplotlib import colormaps
    from matplotlib.animation import PillowWriter
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.signal import resample
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.common.errors import ModelError
from squeal_core.common.output import output_file
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.surface_shapes import SurfaceShapes
from squeal_core.view.saving import FigureTarget
from squeal_core.view.slide import (
    AMPLITUDES,
    DPI,
    GREY,
    SEVERAL,
    slide,
    slide_figure,
    slide_style,
)

FRAMES, RATE = 20, 10  # of an animation: frames of a cycle, and a second
_FINER = 3  # times as many points as the model has, between which shapes are interpolated
_DRAWN = 0.09  # largest displacement that is drawn, of the outer radius
_APART = 0.3  # how far pads are drawn from the disc, of the outer radius
_VIEW = {'elev': 28.0, 'azim': 35.0}
_NO_SHAPES = ('this model carries no shapes of its modes: it was made from matrices or by an '
              'early version; build it from a brake description, or draw --plot-kind damping or '
              'mechanism, which need none')


class DrawnSurface(NamedTuple):
    """A surface, points at rest (rows, columns, 3) [m] and their motion u there [m]."""

    name: str
    points: FloatArray
    motion: ComplexArray
    closed: bool

    def at(self, phase: float) -> tuple[FloatArray, FloatArray]:
        """Return points and sizes of displacements [m] at a phase of the cycle [rad]."""
        moved = (self.motion * np.exp(1j * phase)).real
        return self.points + moved, np.linalg.norm(moved, axis=-1)

    def outline(self) -> Iterator[FloatArray]:
        """Yield closed lines (n, 3) around it at rest."""
        points = self.points
        if self.closed:
            yield from (np.concatenate([row, row[:1]]) for row in (points[0], points[-1]))
        else:
            yield np.concatenate([points[0], points[:, -1], points[-1, ::-1], points[::-1, 0]])


class ShapeView(NamedTuple):
    """Drawing of a mode: its surfaces, the largest displacement [m], and words."""

    surfaces: Sequence[DrawnSurface]
    drawn: float
    title: str
    about: str


def check_shapes(model: BrakeModel) -> SurfaceShapes:
    """Return the shapes that a model carries; ModelError where it has none."""
    if model.surface is None:
        raise ModelError(_NO_SHAPES)
    return model.surface


def shape_view(model: BrakeModel, vector: ComplexArray, title: str, about: str) -> ShapeView:
    """
    Return the drawing of a mode.

    Parameters
    ----------
    model : BrakeModel
        With surface shapes.
    vector : (N,) array
        Right vector of the mode, in modal coordinates.
    title, about : str
        Two lines above the plot.

    Raises
    ------
    ModelError
        For a model that carries no shapes.

    """
    surface = check_shapes(model)
    radius = float(np.hypot(*surface.points[:, :2].T).max())
    surfaces = list(_surfaces(surface, _DRAWN * radius * surface.motion(vector),
                              _APART * radius))
    return ShapeView(surfaces, _DRAWN * radius, title, about)


def _surfaces(surface: SurfaceShapes, motion: ComplexArray,
              apart: float) -> Iterator[DrawnSurface]:
    first, middle = 0, float(np.median(surface.points[:, 2]))
    for patch in surface.patches:
        own = slice(first, first + patch.size)
        first = own.stop
        shape = (patch.rows, patch.columns, 3)
        points, moved = (_finer(values[own].reshape(shape), closed=patch.closed)
                         for values in (surface.points, motion))
        if not patch.closed:
            points = points + [0.0, 0.0, np.copysign(apart, points[..., 2].mean() - middle)]
        yield DrawnSurface(patch.name, points, moved, patch.closed)


def _finer(values: Any, *, closed: bool) -> Any:
    """Interpolate (rows, columns, 3): by splines, and by harmonics around a ring."""
    for axis in (0, 1):
        count = values.shape[axis]
        if axis == 1 and closed:
            values = resample(values, _FINER * count, axis=axis)
        else:
            values = make_interp_spline(np.arange(count), values, k=min(3, count - 1), axis=axis)(
                np.linspace(0.0, count - 1.0, _FINER * (count - 1) + 1))
    return values


def plot_shape(view: ShapeView, path: FigureTarget, *, overwrite: bool = True) -> None:
    """Draw the mode at its extreme: in three dimensions, and around the disc."""
    with slide(path, view.title, view.about, overwrite=overwrite) as figure:
        _draw(_panels(figure, view), view, 0.0)


def animate_shape(view: ShapeView, path: str | Path, *, overwrite: bool = True) -> None:
    """Write one cycle of the mode as a GIF that repeats."""
    with (slide_style(), tempfile.TemporaryDirectory() as folder,
          output_file(path, overwrite=overwrite) as partial):
        figure, writer = slide_figure(view.title, view.about), PillowWriter(fps=RATE)
        panels = _panels(figure, view)
        frames = Path(folder) / 'cycle.gif'
        with writer.saving(figure, frames, DPI):
            for phase in cycle():
                _draw(panels, view, phase)
                writer.grab_frame()
                figure.set_layout_engine('none')  # all frames as the first one
        partial.write_bytes(frames.read_bytes())


def cycle() -> FloatArray:
    """Return the phases of an animation's frames [rad]."""
    return np.arange(FRAMES) * 2.0 * np.pi / FRAMES


def _panels(figure: Any, view: ShapeView) -> tuple[Any, Any]:
    """Return axes of the body, and of the displacements around the disc where there is one."""
    ring = any(one.closed for one in view.surfaces)
    grid = figure.add_gridspec(1, 2 if ring else 1, width_ratios=(3, 2) if ring else (1,))
    body = figure.add_subplot(grid[0, 0], projection='3d')
    figure.colorbar(ScalarMappable(Normalize(0.0, 1.0), AMPLITUDES), ax=body, shrink=0.5,
                    location='bottom', label='displacement / largest', ticks=(0, 0.5, 1),
                    aspect=30, pad=0.02)
    return body, figure.add_subplot(grid[0, 1]) if ring else None


def _draw(panels: tuple[Any, Any], view: ShapeView, phase: float) -> None:
    body, around = panels
    body.clear()
    colours, faces, sizes = colormaps[AMPLITUDES], [], []
    for one in view.surfaces:
        points, size = one.at(phase)
        quads, own = _quads(points, one.closed), _quads(size[..., None], one.closed)
        faces.append(1e3 * quads)
        sizes.append(own.mean(axis=(1, 2)) / view.drawn)
        for edge in one.outline():
            body.plot(*(1e3 * edge.T), color=GREY, linewidth=0.9, linestyle=(0, (4, 3)))
    body.add_collection3d(Poly3DCollection(
        np.concatenate(faces), facecolors=colours(np.concatenate(sizes)), edgecolors='#00000030',
        linewidths=0.3))
    _frame(body, view)
    if around is not None:
        around.clear()
        _around(around, view, phase)


def _quads(values: FloatArray, closed: bool) -> FloatArray:
    """Return the corners (faces, 4, n) of a grid (rows, columns, n)."""
    if closed:
        values = np.concatenate([values, values[:, :1]], axis=1)
    corners = (values[:-1, :-1], values[1:, :-1], values[1:, 1:], values[:-1, 1:])
    return np.stack(corners, axis=2).reshape(-1, 4, values.shape[2])


def _frame(body: Any, view: ShapeView) -> None:
    """Set equal scales, names and labels; the box of axes would hide what it frames."""
    every = 1e3 * np.concatenate([one.points.reshape(-1, 3) for one in view.surfaces])
    low, high = every.min(axis=0), every.max(axis=0)
    pad = 1e3 * view.drawn * np.array([0.3, 0.3, 1.0])
    limits = np.stack([low - pad, high + pad], axis=1)
    body.set(xlim=limits[0], ylim=limits[1], zlim=limits[2], xlabel='x  mm', ylabel='y  mm',
             zticks=[], title='Pads drawn apart')
    body.set_box_aspect(np.ptp(limits, axis=1), zoom=1.22)
    body.view_init(**_VIEW)
    body.locator_params(nbins=4)
    for one in view.surfaces:
        if not one.closed:
            body.text(*(1e3 * one.points[-1, -1]), f'  {one.name}', fontsize=13)


def _around(axes: Any, view: ShapeView, phase: float) -> None:
    """Draw the displacements along the middle circle of the disc, over the angle."""
    ring = next(one for one in view.surfaces if one.closed)
    middle = len(ring.points) // 2
    angle = np.arctan2(ring.points[middle, :, 1], ring.points[middle, :, 0])
    order = np.argsort(angle)
    x, y, z = ring.motion[middle].T / view.drawn
    c, s = np.cos(angle), np.sin(angle)
    motion = np.array([z, c * y - s * x, c * x + s * y])
    end = 1.1 * (np.abs(motion).max() or 1.0)  # of the whole cycle
    shown = (motion * np.exp(1j * phase)).real
    for look, name, values in zip(SEVERAL, ('axial', 'tangential', 'radial'), shown, strict=False):
        axes.plot(np.rad2deg(angle[order]), values[order], color=look.colour, linestyle=look.dash,
                  linewidth=2.4, label=name)
    for one in view.surfaces:
        if not one.closed:
            sector = np.rad2deg(np.arctan2(one.points[..., 1], one.points[..., 0]))
            axes.axvspan(sector.min(), sector.max(), color='0.92', zorder=0,
                         label='pads' if one is view.surfaces[0] else None)
    axes.set(xlim=(-180.0, 180.0), ylim=(-end, end), xticks=range(-180, 181, 90),
             xlabel='angle around the disc  °', title="Around the disc, at the pads' middle")
    axes.set_ylabel('displacement / largest')
    axes.grid(color='0.9')
    axes.legend(loc='upper center', bbox_to_anchor=(0.5, -0.13), ncols=4, frameon=False,
                columnspacing=1.0, handlelength=2.2)

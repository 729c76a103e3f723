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

"""Plot of the convergence of the matrices with the planar mesh, and of growth rates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

try:
    import matplotlib
    from matplotlib.figure import Figure
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
import numpy as np
from squeal_core.view.saving import FigureTarget, save_figure

_MARKERS = 'os^vDP'
_RULES = ('firebrick', 'darkgoldenrod', 'teal')  # no colours of matrices


@dataclass(frozen=True)
class MeshRefinement:
    """
    Results of a mesh refinement, the coarsest mesh first.

    Parameters
    ----------
    title : str
    points : sequence of int
        How fine each mesh is.
    errors : mapping of str to sequence of float
        Relative error of each matrix on each mesh.
    growth_rates : sequence of float
        Largest growth rate of the brake built on each mesh [1/s]; may be empty.
    order : float
        Of convergence that theory says, drawn as a guide; 0: none.

    """

    title: str
    points: Sequence[int]
    errors: Mapping[str, Sequence[float]]
    growth_rates: Sequence[float] = field(default=())
    order: float = 0.0


def plot_mesh_convergence(rules: Sequence[MeshRefinement], meshes: MeshRefinement,
                          path: FigureTarget, *, growth_rate: float) -> None:
    """
    Draw errors and growth rates over the fineness of planar meshes to a PNG file.

    Parameters
    ----------
    rules : sequence of MeshRefinement
        Up to three: exact shapes on finer and finer grids, one rule each.
    meshes : MeshRefinement
        The default grid, fed from irregular nodes that lie denser and denser.
    path : path
        Where the file is.
    growth_rate : float
        What the growth rate would be without any error [1/s].

    """
    with matplotlib.rc_context({'font.size': 9, 'axes.titlesize': 9}):
        figure = Figure(figsize=(11.0, 7.6), layout='constrained')
        _draw(figure, rules, meshes, growth_rate)
        save_figure(figure, path, dpi=100)


def _draw(figure: Figure, rules: Sequence[MeshRefinement], meshes: MeshRefinement,
          growth_rate: float) -> None:
    grid = figure.add_gridspec(2, 6, height_ratios=(1.15, 1.0))
    top = [figure.add_subplot(grid[0, 2 * i:2 * i + 2]) for i in range(len(rules))]
    every = [e for ladder in rules for values in ladder.errors.values() for e in values if e]
    for axes, ladder in zip(top, rules, strict=True):
        _errors(axes, ladder)
        axes.set(xlabel='points across the contact in $\\theta$',
                 ylim=(0.4 * min(every), 4.0 * max(every)))
        if axes is not top[0]:
            axes.tick_params(labelleft=False)
    top[0].set_ylabel('relative error of the matrix')
    top[0].legend(ncols=2, frameon=False, loc='lower left')
    growth, nodes = (figure.add_subplot(grid[1, part]) for part in (slice(0, 3), slice(3, 6)))
    _growth_rates(growth, rules, growth_rate)
    _errors(nodes, meshes)
    nodes.set(xlabel='nodes round the disc', ylabel='relative error of the matrix')


def _errors(axes: Any, ladder: MeshRefinement) -> None:
    for number, (name, values) in enumerate(ladder.errors.items()):
        axes.loglog(ladder.points, values, color=f'C{number}', marker=_MARKERS[number % 6],
                    markersize=4, linewidth=1.1, label=name)
    axes.axhline(5e-3, color='0.5', linewidth=0.8, linestyle=':')
    axes.annotate('0.5 %', (1.0, 5e-3), xycoords=('axes fraction', 'data'), ha='right',
                  va='bottom', color='0.4')
    if ladder.order:
        points = np.array([ladder.points[0], ladder.points[-1]], float)
        start = 1.6 * max(values[0] for values in ladder.errors.values())
        axes.loglog(points, start * (points / points[0])**-ladder.order, color='0.3',
                    linewidth=0.9, linestyle='--')
        power = '' if ladder.order == 1.0 else f'^{ladder.order:g}'
        axes.annotate(f'$h{power}$', (points[0], start), textcoords='offset points',
                      xytext=(14, 1), color='0.3')
    _plain_ticks(axes, ladder.points)
    axes.set_title(ladder.title)


def _growth_rates(axes: Any, rules: Sequence[MeshRefinement], exact: float) -> None:
    for number, ladder in enumerate(rules):
        axes.loglog(ladder.points, ladder.growth_rates, color=_RULES[number],
                    marker=_MARKERS[number], markersize=5, label=ladder.title.partition('\n')[0])
    axes.axhline(exact, color='0.3', linewidth=0.9, linestyle='--')
    axes.annotate(f'exact: {exact:.1f} 1/s', (0.01, exact), xycoords=('axes fraction', 'data'),
                  xytext=(0, -3), textcoords='offset points', va='top', color='0.3')
    axes.set(xlabel='points across the contact in $\\theta$',
             ylabel='largest growth rate  1/s',
             title='what the errors do to the brake\n'
                   'largest growth rate over the contact grid')
    axes.legend(frameon=False)
    _plain_ticks(axes, sorted({p for ladder in rules for p in ladder.points}))


def _plain_ticks(axes: Any, points: Sequence[int]) -> None:
    apart = [points[0]]
    for point in points[1:]:
        if point > 1.25 * apart[-1]:
            apart.append(point)
    axes.set_xticks(apart, [str(point) for point in apart])
    axes.minorticks_off()
    axes.grid(color='0.9')

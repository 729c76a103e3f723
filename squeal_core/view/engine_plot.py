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

"""The picture of how right the online engine is: error against distance from an anchor."""

from dataclasses import dataclass

try:
    from matplotlib.figure import Figure
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error

from squeal_core.common.arrays import FloatArray
from squeal_core.view.saving import FigureTarget, save_figure


@dataclass(frozen=True, eq=False)
class ErrorsOverDistance:
    """
    Errors of oscillating modes [1/s] at points ever farther from anchors.

    Parameters
    ----------
    parameter : str
        What was moved.
    distance : (D,) array
        Relative change of the parameter.
    true, estimated : (D, samples) arrays
        Of the worst mode of each sample; infinite where a series diverges.

    """

    parameter: str
    distance: FloatArray
    true: FloatArray
    estimated: FloatArray


def plot_errors(found: list[ErrorsOverDistance], path: FigureTarget, *,
                tolerance: float = 0.1) -> None:
    """Draw true and estimated errors over the distance, a panel for each parameter, as PNG."""
    figure = Figure(figsize=(11.0, 3.6), layout='constrained')
    axes = figure.subplots(1, len(found), sharey=True, squeeze=False)[0]
    for ax, one in zip(axes, found, strict=True):
        for values, colour, name in ((one.estimated, 'darkorange', 'estimate'),
                                     (one.true, 'navy', 'true error')):
            ordered = values.copy()
            ordered.sort(axis=1)
            low, middle, high = (ordered[:, int(q * (ordered.shape[1] - 1))] for q in (0, 0.5, 1))
            ax.fill_between(100 * one.distance, low, high, color=colour, alpha=0.2, lw=0)
            ax.plot(100 * one.distance, middle, color=colour, label=name)
        ax.axhline(tolerance, color='grey', ls='--', lw=0.8)
        ax.set(xscale='log', yscale='log', ylim=(1e-7, 1e2), title=one.parameter,
               xlabel='distance from the anchor, %')
        ax.grid(alpha=0.3)
    axes[0].set_ylabel('error of the worst mode, 1/s')
    axes[0].legend(loc='lower right', fontsize=9)
    axes[0].annotate('tolerance', (0.02, tolerance), xycoords=('axes fraction', 'data'),
                     va='bottom', fontsize=8, color='grey')
    save_figure(figure, path, dpi=110)

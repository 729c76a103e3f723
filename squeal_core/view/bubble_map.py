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

"""The bubble map: frequencies over one parameter, unstable modes as bubbles by damping ratio."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.lines import Line2D
import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.studies.sweep_record import Sweep
from squeal_core.studies.unstable_modes import UnstableMode
from squeal_core.view.saving import FigureTarget
from squeal_core.view.slide import GREY, MECHANISMS, slide
from squeal_core.view.stability_map import axis_of, conditions, shown_to

_LARGEST = 900.0  # points^2, area of the largest bubble
_LEAST = 14.0  # of the smallest that is drawn: it could not be seen else
_USUAL_KHZ = 8.0
_GAP = 0.042  # of the height, from one name to the next


def plot_bubbles(record: Sweep, modes: Sequence[UnstableMode], names: Mapping[str, str],
                 path: FigureTarget, *, title: str = '', overwrite: bool = True) -> None:
    """
    Draw the bubble map.

    Parameters
    ----------
    record : Sweep
        Of one parameter, tracked.
    modes : sequence of UnstableMode
        What `unstable_modes` gives.
    names : mapping
        Of modes, by identity.
    path : path or binary file
        PNG, SVG or PDF.
    title : str
        Above it.
    overwrite : bool
        Whether an existing file may be replaced.

    Notes
    -----
    The area of a bubble is in proportion to the damping ratio below zero. Lines are all modes
    that oscillate.

    """
    (parameter,) = record.axes
    x, label = axis_of(record, parameter)
    top = max([_USUAL_KHZ, *(1.06e-3 * mode.frequency_hz for mode in modes)])
    scale = _LARGEST / max((-mode.damping_ratio for mode in modes), default=1.0)
    heading = title or f'Unstable modes over {label.split("  ")[0]}'
    about = (f'{conditions(record)}{shown_to(record, 1e3 * top)}; '
             'names where the damping ratio is lowest')
    with slide(path, heading, about, overwrite=overwrite) as figure:
        axes = figure.subplots()
        khz = np.where(np.isin(record.kinds, ('flutter', 'stable')), record.frequencies_hz / 1e3,
                       np.nan)
        axes.plot(x, khz, color='0.78', linewidth=0.7, zorder=1)
        for mechanism, look in MECHANISMS.items():
            own = [mode for mode in modes if mode.mechanism == mechanism]
            axes.scatter([x[mode.place] for mode in own],
                         [mode.frequency_hz / 1e3 for mode in own],
                         s=[max(-scale * mode.damping_ratio, _LEAST) for mode in own],
                         marker=look.marker, facecolor=f'{look.colour}90' if look.colour[0] == '#'
                         else look.colour, edgecolor=look.colour, linewidth=0.9, zorder=2)
        axes.set(xlabel=label, ylabel='frequency  kHz', ylim=(0.0, top))
        axes.margins(x=0.025)
        _names(axes, x, modes, names, top)
        _legend(figure, modes, scale)


def _names(axes: Any, x: FloatArray, modes: Sequence[UnstableMode], names: Mapping[str, str],
           top: float) -> None:
    """Write names at the right edge, apart from each other, joined to the largest bubbles."""
    worst = {identity: min((mode for mode in modes if mode.identity == identity),
                           key=lambda mode: mode.damping_ratio) for identity in names}
    ranked = sorted(worst.items(), key=lambda item: item[1].frequency_hz)
    heights = spread([mode.frequency_hz / 1e3 for _, mode in ranked], _GAP * top, top)
    for (identity, mode), height in zip(ranked, heights, strict=True):
        axes.annotate(
            names[identity], (x[mode.place], mode.frequency_hz / 1e3), (1.03, height),
            textcoords=axes.get_yaxis_transform(), va='center', fontsize=13,
            annotation_clip=False,
            arrowprops={'arrowstyle': '-', 'color': GREY, 'linewidth': 0.8, 'shrinkA': 2.0,
                        'shrinkB': 0.0, 'relpos': (0.0, 0.5)})


def spread(heights: Sequence[float], gap: float, top: float) -> list[float]:
    """
    Return rising heights at least a gap apart, near to those given and below the top.

    Parameters
    ----------
    heights : sequence of float
        Rising.
    gap, top : float
        In the same unit.

    """
    gap = min(gap, top / max(len(heights), 1))
    result: list[float] = []
    for height in heights:
        result.append(max(height, result[-1] + gap if result else 0.5 * gap))
    for place in reversed(range(len(result))):
        above = result[place + 1] if place + 1 < len(result) else top + 0.5 * gap
        result[place] = min(result[place], above - gap)
    return result


def _legend(figure: Any, modes: Sequence[UnstableMode], scale: float) -> None:
    """Draw the legend: mechanisms with numbers of bubbles, sizes of three damping ratios."""
    handles = [Line2D([], [], color='0.7', linewidth=1.0, label='modes that oscillate')]
    for mechanism, look in MECHANISMS.items():
        count = sum(mode.mechanism == mechanism for mode in modes)
        if count:
            handles.append(Line2D([], [], linestyle='', marker=look.marker, color=look.colour,
                                  markersize=12, label=f'{mechanism} ({count})'))
    largest = _LARGEST / scale
    handles += [Line2D([], [], linestyle='', marker='o', markerfacecolor='none', color='black',
                       markersize=float(np.sqrt(scale * ratio)),
                       label=f'damping ratio −{100.0 * ratio:.2g} %')
                for ratio in (largest, 0.25 * largest) if modes]
    figure.legend(handles=handles, loc='outside lower center', ncols=4, frameon=False,
                  columnspacing=1.6, handletextpad=0.9, borderpad=1.0)  # of the largest bubble

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

"""Bars of modes: damping ratios against a threshold, and terms of a growth rate."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from squeal_core.stability.eigensolution import Mode
from squeal_core.stability.mechanism import Mechanism
from squeal_core.view.contributions import ranked_terms
from squeal_core.view.saving import FigureTarget
from squeal_core.view.slide import GREY, Look, number, slide

INDUSTRY = (0.25, 0.5)
"""Damping ratio below zero from which industry takes a mode for squeal, low and high use [%]."""
MOST_BARS = 24
_ABAQUS = 50.0  # per cent of the damping ratio, per unit of -2 Re / |Im| (Re small beside Im)
_VERDICTS = {'beyond the threshold': Look('#D55E00', '', '//'),
             'unstable, within the threshold': Look('#E69F00', '', '..'),
             'stable': Look('#0072B2', '', '')}
_RISE, _FALL, _TOTAL = Look('#D55E00', '', '//'), Look('#0072B2', '', '\\\\'), Look('0.6', '', '')


class DampingBar(NamedTuple):
    """A bar: name of the mode, frequency [Hz], damping ratio [%] and verdict."""

    name: str
    frequency_hz: float
    percent: float
    verdict: str


def damping_bars(modes: Sequence[Mode], names: Sequence[str], threshold: float,
                 band_hz: tuple[float, float]) -> list[DampingBar]:
    """
    Return the least stable oscillating modes of a band, in order of frequency.

    Parameters
    ----------
    modes : sequence of Mode
        All of a point.
    names : sequence of str
        Of each.
    threshold : float
        Damping ratio below zero from which a mode counts [%].
    band_hz : (2,) floats
        Low and high end [Hz].

    """
    low, high = band_hz
    inside = [(100.0 * mode.damping_ratio, mode, name) for mode, name in zip(
        modes, names, strict=True) if mode.kind in ('flutter', 'stable')
        and low <= mode.frequency_hz <= high]
    kept = sorted(inside, key=lambda one: one[0])[:MOST_BARS]
    verdicts = tuple(_VERDICTS)
    return [DampingBar(name, mode.frequency_hz, percent, verdicts[
        2 if not mode.unstable else 0 if percent <= -threshold else 1])
        for percent, mode, name in sorted(kept, key=lambda one: one[1].frequency_hz)]


def plot_damping(bars: Sequence[DampingBar], path: FigureTarget, *, threshold: float, title: str,
                 about: str, overwrite: bool = True) -> None:
    """
    Draw damping ratios as bars, unstable ones below zero, with the threshold.

    Parameters
    ----------
    bars : sequence of DampingBar
        What `damping_bars` gives.
    path : path or binary file
        PNG, SVG or PDF.
    threshold : float
        Damping ratio below zero from which a mode counts [%].
    title, about : str
        Two lines above it.
    overwrite : bool
        Whether an existing file may be replaced.

    """
    with slide(path, title, about, overwrite=overwrite) as figure:
        axes = figure.subplots()
        axes.axhspan(-INDUSTRY[1], -INDUSTRY[0], color='0.9', zorder=0,
                     label=f"−{INDUSTRY[0]:g} to −{INDUSTRY[1]:g} %: thresholds in industry's use")
        axes.axhline(0.0, color='black', linewidth=1.0)
        axes.axhline(-threshold, color='black', linewidth=1.8, linestyle='--',
                     label=f'threshold −{threshold:g} %: unstable modes below it count as squeal')
        for verdict, look in _VERDICTS.items():
            own = [(place, bar.percent) for place, bar in enumerate(bars)
                   if bar.verdict == verdict]
            if own:
                place, height = zip(*own, strict=True)
                axes.bar(place, height, width=0.7, color=look.colour, hatch=look.hatch,
                         edgecolor='white', label=f'{verdict}: {len(own)}')
        axes.set_xticks(range(len(bars)), [f'{bar.name}: {bar.frequency_hz:.0f} Hz'
                                           for bar in bars],
                        rotation=90 if len(bars) > 8 else 0, fontsize=12)
        words = (f'the {len(bars)} least stable of the squeal band' if len(bars) == MOST_BARS
                 else 'all that oscillate in the squeal band')
        axes.set(ylabel='damping ratio −Re λ / |λ|  %', xlim=(-0.7, max(len(bars), 1) - 0.3),
                 xlabel=f'mode: frequency; {words}')
        axes.grid(axis='y', color='0.85')
        axes.margins(y=0.12)
        scale = axes.secondary_yaxis('right', functions=(lambda own: own / _ABAQUS,
                                                         lambda its: its * _ABAQUS))
        scale.set_ylabel('as Abaqus prints it, −2 Re λ / |Im λ|')
        figure.legend(loc='outside lower center', ncols=3, frameon=False)


def plot_mechanism(why: Mechanism, path: FigureTarget, *, title: str, about: str,
                   overwrite: bool = True) -> None:
    """
    Draw the terms of a growth rate: bars that begin where the one before ends.

    Parameters
    ----------
    why : Mechanism
        Of one mode.
    path : path or binary file
        PNG, SVG or PDF.
    title, about : str
        Two lines above it.
    overwrite : bool
        Whether an existing file may be replaced.

    """
    terms, total = ranked_terms(why.contributions), why.mode.growth_rate
    ends = np.concatenate([[0.0], np.cumsum([*terms.values()])])
    with slide(path, title, about, overwrite=overwrite) as figure:
        axes = figure.subplots()
        rows = [(name.replace('_', ' '), low, high - low, _RISE if high >= low else _FALL)
                for name, (low, high) in zip(terms, pairwise(ends.tolist()), strict=True)]
        rows.append(('growth rate', 0.0, total, _TOTAL))
        for place, (_, start, width, look) in enumerate(rows):
            axes.barh(place, width, left=start, height=0.62, color=look.colour, hatch=look.hatch,
                      edgecolor='white')
            _value(axes, place, start, width)
        for place, end in enumerate(ends[1:].tolist()):
            axes.plot([end, end], [place - 0.31, place + 1.31], color=GREY, linewidth=1.0)
        axes.axvline(0.0, color='black', linewidth=1.0)
        axes.set_yticks(range(len(rows)), [row[0] for row in rows])
        axes.invert_yaxis()
        axes.use_sticky_edges = False  # numbers stand beyond the ends of bars
        axes.margins(x=0.14)
        axes.grid(axis='x', color='0.88')
        axes.set(xlabel='contribution to the growth rate  1/s',
                 title=f'{why.label}: bars add up to the growth rate, {number(total, 4)} 1/s')


def _value(axes: Any, place: int, start: float, width: float) -> None:
    """Write a bar's number beside the end that it leads to."""
    side = 1.0 if width >= 0.0 else -1.0
    axes.annotate(number(width, 4), (start + width, place), (6.0 * side, 0.0),
                  textcoords='offset points', va='center', ha='left' if side > 0 else 'right',
                  fontsize=13)

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

"""Brakes side by side on a slide: growth, frequencies, critical friction, risk over a drive."""

from collections.abc import Callable, Sequence
from functools import partial
import math
from typing import Any

import numpy as np
from squeal_core.monitor.results.drive_risk import DriveRisk
from squeal_core.studies.brake_comparison import BrakeComparison, ComparedMode, mac_of
from squeal_core.view.saving import FigureTarget
from squeal_core.view.slide import GREY, Look, SEVERAL, slide

_MOST = 14  # rows
_APART = 0.16  # of a row, between the markers of brakes
_TICKS_APART = 5.0  # of values on a logarithmic scale: the texts of nearer ones overlap
_Row = Sequence[ComparedMode | None]


def plot_comparison(result: BrakeComparison, rows: Sequence[_Row], risks: Sequence[DriveRisk],
                    path: FigureTarget, *, title: str, conditions: str,
                    drive: str, bounds: tuple[float, float], overwrite: bool = True) -> None:
    """
    Draw matched modes row by row, those with the largest growth rates at most.

    Parameters
    ----------
    result : BrakeComparison
        The brakes.
    rows : sequence of rows
        Of `result.rows()`, those to show.
    risks : sequence of DriveRisk
        Of each brake; empty: there was no drive.
    path : path or binary file
        PNG, SVG or PDF.
    title : str
        Above it; empty: one by the names.
    conditions : str
        Operating point in words.
    drive : str
        Its name.
    bounds : (2,) floats
        Of the friction in which boundaries were looked for.
    overwrite : bool
        Whether an existing file may be replaced.

    """
    names = [brake.name for brake in result.brakes]
    shown = sorted(sorted(rows, key=lambda row: -_growth(row))[:_MOST], key=_frequency)
    about = f'{conditions}; matched by ' + '; '.join(dict.fromkeys(
        match.basis for match in result.matches)) + (
            f'; the {_MOST} of {len(rows)} modes that grow most' if len(rows) > _MOST else '')
    title = title or f'Brakes compared: {", ".join(names)}'
    with slide(path, title, about, overwrite=overwrite) as figure:
        panels = figure.subplots(1, 4 if risks else 3, width_ratios=(4, 3, 3, 2.2)[
            :4 if risks else 3])
        _rows(panels[0], shown, _growths)
        _rows(panels[1], shown, _shifts)
        _rows(panels[2], shown, partial(_boundaries, result, bounds[1]))
        _scale_growth(panels[0], max(map(_growth, shown), default=0.0))
        panels[0].set_yticks(range(len(shown)), [_label(row) for row in shown])
        panels[1].set(xlabel=f'frequency against\n{names[0]}  %')
        panels[2].set(xlabel=f'critical friction\n(at {bounds[1]:g}: stable up to it)',
                      xlim=(bounds[0], bounds[1] + 0.03 * (bounds[1] - bounds[0])))
        macs = panels[2].secondary_yaxis('right')
        macs.set_yticks(range(len(shown)), [_macs(result, row) for row in shown], fontsize=12)
        macs.tick_params(length=0)
        panels[2].set_title('MAC', loc='right', fontsize=13)
        if risks:
            _risks(panels[3], names, risks, drive)
        _legend(figure, panels[0], names)


def _scale_growth(axes: Any, unstable: float) -> None:
    """Scale growth rates: linear as far as modes are unstable, logarithmic far below zero."""
    linear = float(f'{unstable:.1g}') if unstable > 0.0 else 10.0
    axes.set_xscale('symlog', linthresh=linear, linscale=0.9)
    decades = 10.0 ** np.arange(np.ceil(np.log10(2.0 * linear)), 7.0)
    low, high = axes.get_xlim()
    apart = decades[0] >= _TICKS_APART * linear
    ticks = (*-decades[::-1], *([-linear] if apart else []), 0.0, linear / 2.0, linear)
    axes.set_xticks([tick for tick in ticks if low <= tick <= high])
    axes.tick_params(axis='x', labelsize=12)
    axes.xaxis.set_major_formatter('{x:g}')
    axes.minorticks_off()
    axes.axvline(0.0, color='black', linewidth=1.0)
    axes.set(xlabel=f'growth rate  1/s\n(linear from −{linear:g} to {linear:g})')


def _growth(row: _Row) -> float:
    return max(mode.growth_rate for mode in row if mode is not None)


def _frequency(row: _Row) -> float:
    return next(mode.frequency_hz for mode in row if mode is not None)


def _label(row: _Row) -> str:
    mode = next(mode for mode in row if mode is not None)
    return f'{mode.identity}  {mode.component}  {mode.frequency_hz:.0f} Hz'


def _macs(result: BrakeComparison, row: _Row) -> str:
    values = [mac_of(result, row, place) for place in range(1, len(row))]
    return ', '.join('–' if math.isnan(value) else f'{value:.2f}' for value in values)


def _growths(row: _Row) -> list[float]:
    return [math.nan if mode is None else mode.growth_rate for mode in row]


def _shifts(row: _Row) -> list[float]:
    first = row[0]
    return [math.nan if mode is None or first is None
            else 100.0 * (mode.frequency_hz / first.frequency_hz - 1.0) for mode in row]


def _boundaries(result: BrakeComparison, bound: float, row: _Row) -> list[float]:
    """Return critical frictions: the bound where a mode is stable up to it, NaN: not known."""
    return [math.nan if mode is None or not brake.boundaries_known
            else bound if math.isnan(mode.critical_friction) else mode.critical_friction
            for brake, mode in zip(result.brakes, row, strict=True)]


def _rows(axes: Any, rows: Sequence[_Row], values: Callable[[_Row], list[float]]) -> None:
    """Draw a marker a brake in each row, joined by a line."""
    for place, row in enumerate(rows):
        middle = 0.5 * (len(row) - 1)
        marks = [(value, place + _APART * (i - middle), SEVERAL[i % len(SEVERAL)])
                 for i, value in enumerate(values(row)) if not math.isnan(value)]
        axes.plot([x for x, *_ in marks], [y for _, y, _ in marks], color=GREY, linewidth=1.2,
                  zorder=1)
        for x, y, look in marks:
            axes.plot(x, y, look.marker, color=look.colour, markersize=9, zorder=2,
                      clip_on=False)
    axes.set(ylim=(len(rows) - 0.5, -0.5), yticks=[])
    axes.grid(axis='x', color='0.88')
    for line in np.arange(0.5, len(rows) - 1.0):
        axes.axhline(line, color='0.93', linewidth=0.8, zorder=0)
    axes.margins(x=0.08)


def _risks(axes: Any, names: Sequence[str], risks: Sequence[DriveRisk], drive: str) -> None:
    """Draw mean risks as bars, with the largest; unknown ones are labelled."""
    for place, risk in enumerate(risks):
        look: Look = SEVERAL[place % len(SEVERAL)]
        if risk.unknown:
            axes.text(place, 0.02, 'not known', rotation=90, ha='center', va='bottom')
            continue
        axes.bar(place, risk.mean_risk, width=0.6, color=look.colour, hatch=look.hatch,
                 edgecolor='white')
        axes.plot([place - 0.3, place + 0.3], 2 * [risk.peak_risk], color='black', linewidth=2.0)
    axes.set_xticks(range(len(risks)), ['–' if risk.unknown else f'{risk.mean_risk:.2f}'
                                        for risk in risks])
    axes.set(ylim=(0.0, 1.05), xlim=(-0.6, len(names) - 0.4),
             ylabel='squeal risk while braking', xlabel=f'mean over\n{drive}\n(line: largest)')
    axes.grid(axis='y', color='0.88')


def _legend(figure: Any, axes: Any, names: Sequence[str]) -> None:
    handles = [axes.plot([], [], look.marker, color=look.colour, markersize=11, label=name)[0]
               for name, look in zip(names, SEVERAL * (1 + len(names) // len(SEVERAL)),
                                     strict=False)]
    figure.legend(handles=handles, loc='outside lower center', ncols=min(len(names), 4),
                  frameon=False)

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

"""Charts of the occurrence of brake noise over conditions, as SAE J2521 and VDA 306 have them."""

from collections.abc import Callable, Sequence
from itertools import pairwise
import math
from typing import Any, NamedTuple

import numpy as np
from squeal_core.calibration.scores import braking_numbers
from squeal_core.common.arrays import FloatArray
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.sound.comparison import Comparison
from squeal_core.sound.matching import MatchedApplication
from squeal_core.view.report.application_shares import classes, Shares, shares
from squeal_core.view.report.charts import KELVIN, NOT_KNOWN
from squeal_core.view.report.figure import Figure, GREY, LEGEND, packed, style, Trace
from squeal_core.view.report.markup import label
from squeal_core.view.report.runs import Run


class Condition(NamedTuple):
    """Condition over which occurrence is shown, with the width of its classes."""

    name: str
    title: str
    unit: str
    width: float
    value: Callable[[ApplicationRecord], float]
    of_all: bool = False


CONDITIONS = (
    Condition('frequency', 'frequency', 'kHz', 0.5,
              lambda one: one.frequency_hz / 1e3, of_all=True),
    Condition('pressure', 'mean brake pressure', 'bar', 5.0, lambda one: one.pressure_pa / 1e5),
    Condition('temperature', 'temperature at the start', '°C', 25.0,
              lambda one: one.temperature_k - KELVIN),
    Condition('speed', 'rotor speed at the start', 'rad/s', 10.0,
              lambda one: abs(one.rotor_speed_rad_s)))


def occurrence(runs: Sequence[Run], condition: Condition,
               comparisons: Sequence[Comparison] = ()) -> Figure:
    """
    Return the share of applications with predicted squeal over a condition, and with measured.

    Parameters
    ----------
    runs : sequence of Run
        Whose applications are counted.
    condition : Condition
        What the shares are over.
    comparisons : sequence of Comparison
        With measured squeal, one a run; none: nothing was measured.

    """
    name, _, _, width, value, of_all = condition
    about: dict[str, Any] = {'name': f'occurrence-{name}', 'title': f'Occurrence over {name}'}
    values = [np.array([value(one) for one in run.known]) for run in runs]
    hits = [np.array([one.alarm for one in run.known], bool) for run in runs]
    brakings = [run.known_brakings for run in runs]
    names = [label(run.name) if len(runs) > 1 else 'predicted' for run in runs]
    for run, result in zip(runs, comparisons, strict=False):
        heard = [one for one in result.matches.applications if one.outcome != 'not known']
        values.append(np.array([_measured_value(one, condition) for one in heard]))
        hits.append(np.array([one.measured for one in heard], bool))
        brakings.append(braking_numbers([
            (one.recording, one.start, one.end) for one in (result.braking for result in heard)]))
        names.append(f'{label(run.name)}, measured' if len(runs) > 1 else 'measured')
    counted = [own[hit] if of_all else own for own, hit in zip(values, hits, strict=True)]
    everything = np.concatenate([own[np.isfinite(own)] for own in counted])
    if not any(len(own) for own in values):
        return Figure(**about, unknown=NOT_KNOWN)
    if not everything.size:
        return Figure(**about, unknown=(
            f'No squeal is predicted in the {sum(map(len, values))} brake applications of which '
            'it is known.' if of_all else _without(runs, name)))
    edges = classes(everything, width)
    traces = [_bars(words, place, shares(own, hit, number, edges, of_all=of_all))
              for place, (words, own, hit, number) in enumerate(
                  zip(names, values, hits, brakings, strict=True))]
    left_out = sum(int(np.isnan(own).sum()) for own in values[:len(runs)]) if not of_all else 0
    return Figure(**about, traces=traces, layout=_layout(condition, edges, len(traces)),
                  caption=_caption(condition, bool(comparisons)) + (
                      f' Left out: {left_out} applications without a {name}.' if left_out else ''))


def _without(runs: Sequence[Run], name: str) -> str:
    """Return the reason why no application has a condition."""
    inputs = {one['signal'] for run in runs for result in run.results
              for one in result.summary.get('inputs') or ()}
    return f'Not known: no brake application has a {name}' + (
        '.' if name in inputs or not inputs else
        f'; the settings name no {name} of a brake as an input.')


def _caption(condition: Condition, is_measured: bool) -> str:
    if not condition.of_all:
        words = 'Share of the known brake applications of the class with ' + (
            'predicted or measured squeal' if is_measured else 'predicted squeal')
    else:
        words = ('Share of the known brake applications with predicted squeal whose worst mode is '
                 'in the class') + (', and of those with measured squeal whose pitch is'
                                    if is_measured else '')
    return f'{words}; bars of error: 95 %, by brakings of the vehicle.'


def _layout(condition: Condition, edges: FloatArray, bars: int) -> dict[str, Any]:
    """Return the layout: classes are categories, between which the ticks are."""
    names = _class_names(edges)
    return {
        'xaxis': {'title': {'text': f'{condition.title}  {condition.unit}'}, 'type': 'category',
                  'categoryorder': 'array', 'categoryarray': names, 'tickson': 'boundaries',
                  'range': [-0.5, len(names) - 0.5], 'showgrid': True, 'automargin': True},
        'barmode': 'group', 'bargap': max(0.2, 1.0 - 0.1 * bars * len(names)),
        'yaxis': {'title': {'text': 'share of applications  %'}, 'rangemode': 'tozero'},
        'showlegend': bars > 1, 'legend': LEGEND}


def _class_names(edges: FloatArray) -> list[str]:
    return [f'{low:g} to {high:g}' for low, high in pairwise(edges.tolist())]


def _measured_value(one: MatchedApplication, condition: Condition) -> float:
    """Return the condition of an application; its frequency is the measured pitch."""
    if not condition.of_all:
        return condition.value(one.braking.worst)
    return one.events[0].frequency_hz / 1e3 if one.events else math.nan


def _bars(name: str, place: int, result: Shares) -> Trace:
    percent = 100.0 * result.share
    return {
        'type': 'bar', 'name': name, 'x': _class_names(result.edges), 'y': packed(percent),
        'customdata': packed(np.column_stack(
            [result.counts, 100 * result.low, 100 * result.high])),
        'marker': {'color': style(place).colour,
                   'pattern': {'shape': ('', '/', 'x', '.', '\\', '-')[place % 6]}},
        'error_y': {'type': 'data', 'symmetric': False, 'thickness': 1, 'color': GREY,
                    'array': packed(100 * result.high - percent),
                    'arrayminus': packed(percent - 100 * result.low)},
        'hovertemplate': '%{x}: %{y:.1f} % of %{customdata[0]} applications<br>95 %: '
                         '%{customdata[1]:.1f} to %{customdata[2]:.1f} %<extra></extra>'}

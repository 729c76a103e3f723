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

"""Friction over pressure and speed, with the predicted stability boundary."""

from collections.abc import Sequence
import math
from typing import Any

import numpy as np
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.view.report.condition_maps import (
    ConditionRanges,
    FrictionBoundary,
    LEAST_TICKS,
)
from squeal_core.view.report.figure import Figure, GREY, packed, points, style, Trace
from squeal_core.view.report.runs import Run


def condition_ranges(runs: Sequence[Run]) -> ConditionRanges:
    """Return ranges that hold the applications of all runs, with three classes of either."""
    records = [one.record for run in runs for one in run.applications]
    pressures = _known([one.pressure_max_pa for one in records])
    speeds = _known([abs(value) for one in records
                     for value in (one.rotor_speed_rad_s, one.rotor_speed_end_rad_s)])
    means = _known([one.pressure_pa for one in records])
    return ConditionRanges(
        5e5 * math.ceil(max(pressures, default=1e5) / 5e5 + 1e-9),
        10.0 * math.ceil(max(speeds, default=1.0) / 10.0 + 1e-9),
        _thirds(means, 1e5), _thirds(_known([_speed(one) for one in records]), 5.0))


def _known(values: Sequence[float]) -> list[float]:
    return [value for value in values if math.isfinite(value)]


def _thirds(values: Sequence[float], step: float) -> tuple[float, ...]:
    """Return the limits between three classes of about as many values, on a grid."""
    if not values:
        return ()
    return tuple(sorted({step * max(1, round(value / step))
                         for value in np.quantile(values, [1 / 3, 2 / 3]).tolist()}))


def _speed(one: ApplicationRecord) -> float:
    return 0.5 * (abs(one.rotor_speed_rad_s) + abs(one.rotor_speed_end_rad_s))


def friction_chart(runs: Sequence[Run], boundary: FrictionBoundary) -> Figure:
    """Return the chart of all applications of the runs."""
    about: dict[str, Any] = {'name': 'friction', 'title': 'Friction chart', 'wide': True}
    records = [one.record for run in runs for one in run.applications
               if math.isfinite(one.record.friction)]
    if not records:
        return Figure(**about, unknown='Not known: no brake application has a friction.')
    traces: list[Trace] = []
    limits = (boundary.ranges.speed_classes, boundary.ranges.pressure_classes)
    lines = 0
    for over in (0, 1):
        names = _class_names(limits[over], *((1.0, 'rad/s'), (1e5, 'bar'))[over])
        for place, name in enumerate(names):
            traces += _points(records, over, place, name, limits[over])
        own = [line for place, name in enumerate(names)
               for line in _boundary(boundary, over, place, name)]
        traces += [*own, *([_explained(over)] if own else [])]
        lines += len(own)
    caption = ('Mean friction of each brake application: filled where squeal is predicted, open '
               'where not, crossed where not known. ' + _of_boundary(boundary, lines))
    return Figure(**about, caption=caption, traces=traces, height=440, layout={
        'grid': {'rows': 1, 'columns': 2, 'pattern': 'independent', 'xgap': 0.12},
        'xaxis': {'title': {'text': 'brake pressure  bar'}, 'rangemode': 'tozero'},
        'xaxis2': {'title': {'text': 'rotor speed  rad/s'}, 'rangemode': 'tozero'},
        'yaxis': {'title': {'text': 'friction coefficient'}},
        'yaxis2': {'matches': 'y'}, 'hovermode': 'closest', 'showlegend': True,
        'legend': {'x': 0, 'y': 1.02, 'yanchor': 'bottom', 'orientation': 'h',
                   'title': {'text': 'speed'}},
        'legend2': {'x': 0.56, 'y': 1.02, 'yanchor': 'bottom', 'orientation': 'h',
                    'title': {'text': 'pressure'}}})


def _of_boundary(boundary: FrictionBoundary, lines: int) -> str:
    """Return the caption of the lines of the stability boundary, or the reason for none."""
    if not boundary.known:
        return ('The predicted stability boundary is not known: no tick has a friction margin, '
                'which takes a look-up table (`squeal tabulate`).')
    if not lines:
        return ('There is no line of the predicted stability boundary: of every class there are '
                f'too few ticks with a friction margin ({LEAST_TICKS} in each of two neighbouring '
                'steps of pressure or speed).')
    return ('Lines, in the colour of a class: predicted stability boundary, the median over the '
            'ticks of the class of the critical friction nearest to the present one. On one side '
            'of it a mode of the squeal band is unstable, mostly above; it leaps where another '
            'mode is nearest.')


def _explained(over: int) -> Trace:
    """Return the line that stands for all others in a legend."""
    axis = '' if over == 0 else '2'
    return {'type': 'scatter', 'mode': 'lines', 'name': 'stability boundary', 'x': [None],
            'y': [None], 'line': {'color': GREY, 'width': 2.5}, 'legend': f'legend{axis}',
            'xaxis': f'x{axis}', 'yaxis': f'y{axis}'}


def _class_names(limits: Sequence[float], unit: float, name: str) -> list[str]:
    ends = [f'{limit / unit:g}' for limit in limits]
    if not ends:
        return ['all']
    return [f'below {ends[0]} {name}',
            *(f'{low} to {high} {name}' for low, high in zip(ends, ends[1:], strict=False)),
            f'from {ends[-1]} {name}']


def _points(records: Sequence[ApplicationRecord], over: int, place: int, name: str,
            limits: Sequence[float]) -> list[Trace]:
    """Return the points of a class: mean friction over mean pressure or speed."""
    own, axis = style(place), '' if over == 0 else '2'
    result = [one for one in records
              if np.digitize(one.pressure_pa if over else _speed(one), limits) == place]
    symbols = {True: own.symbol, False: f'{own.symbol}-open', None: 'x-thin'}
    return [{
        **points(len(result)), 'name': name, 'legendgroup': f'{over}{place}',
        'legend': f'legend{axis}', 'xaxis': f'x{axis}', 'yaxis': f'y{axis}',
        'x': packed([_speed(one) if over else one.pressure_pa / 1e5 for one in result]),
        'y': packed([one.friction for one in result]),
        'customdata': packed([(one.peak_risk, one.pressure_pa / 1e5, _speed(one))
                              for one in result]),
        'marker': {'color': own.colour, 'size': 7, 'opacity': 0.75,
                   'symbol': [symbols[one.alarm] for one in result],
                   'line': {'color': own.colour, 'width': 1.2}},
        'hovertemplate': 'friction %{y:.3f}, risk %{customdata[0]:.2f}<br>%{customdata[1]:.1f} '
                         'bar, %{customdata[2]:.0f} rad/s<extra></extra>'}] if result else []


def _boundary(boundary: FrictionBoundary, over: int, place: int, name: str) -> list[Trace]:
    """Return the line of a class; none where no two points of it are neighbours."""
    own, axis = style(place), '' if over == 0 else '2'
    condition, friction = boundary.curve(over, place)
    if not np.isfinite(friction[1:] + friction[:-1]).any():
        return []
    return [{
        'type': 'scatter', 'mode': 'lines', 'name': f'boundary, {name}', 'showlegend': False,
        'legendgroup': f'{over}{place}', 'legend': f'legend{axis}',
        'xaxis': f'x{axis}', 'yaxis': f'y{axis}',
        'x': packed(condition / (1.0 if over else 1e5)), 'y': packed(friction),
        'line': {'color': own.colour, 'dash': own.dash, 'width': 2.5},
        'hovertemplate': f'boundary, {name}: friction %{{y:.3f}}<extra></extra>'}]

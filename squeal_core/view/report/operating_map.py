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

"""Pressure over speed, coloured by risk, with the path of the worst brake application."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.view.report.condition_maps import OperatingMap
from squeal_core.view.report.figure import (
    boxes,
    Figure,
    GREY,
    hatched,
    LEGEND,
    packed,
    RISKS,
    Trace,
)

_MOST_STEPS = 2_000  # of the path


def operating_map(drive: OperatingMap, path: Mapping[str, FloatArray], name: str,
                  words: str, title: str) -> Figure:
    """
    Return the map of a run.

    Parameters
    ----------
    drive : OperatingMap
        Of all its ticks.
    path : mapping
        Arrays of the ticks of the worst application; empty: there is none.
    name : str
        Id of the figure.
    words : str
        What the path is of.
    title : str
        Above the figure.

    """
    about: dict[str, Any] = {'name': name, 'title': title, 'wide': True}
    if not np.isfinite(drive.risk).any():
        return Figure(**about, unknown='Not known: no tick of sliding under load has a squeal '
                                       'risk.')
    pressures, speeds = drive.centres
    x, y = packed(speeds), packed(pressures / 1e5)
    unknown = np.argwhere((drive.unknown > 0) & np.isnan(drive.risk))
    traces: list[Trace] = [{
        'type': 'heatmap', 'x': x, 'y': y, 'z': packed(drive.risk.T), 'zmin': 0, 'zmax': 1,
        'colorscale': RISKS, 'name': 'risk', 'xgap': 0.5, 'ygap': 0.5,
        'colorbar': {'title': {'text': 'largest<br>risk'}, 'thickness': 14},
        'hovertemplate': '%{x:.1f} rad/s, %{y:.1f} bar: risk up to %{z:.2f}<extra></extra>'}]
    if unknown.size:
        across, up = ((unknown[:, axis, None] + [0.0, 1.0]) * (centres[1] - centres[0])
                      for axis, centres in enumerate((speeds, pressures / 1e5)))
        traces.append(boxes(across, up, name='not known', **hatched(GREY)) | {'showlegend': True})
    if path:
        traces += _path(path)
    return Figure(**about, height=460, traces=traces, caption=(
        'Largest squeal risk of all ticks of sliding under load in each cell; hatched: only ticks '
        f'whose risk is not known.{words}'), layout={
            'xaxis': {'title': {'text': 'rotor speed  rad/s'}},
            'yaxis': {'title': {'text': 'brake pressure  bar'}, 'rangemode': 'nonnegative'},
            'hovermode': 'closest', 'legend': LEGEND})


def _path(path: Mapping[str, FloatArray]) -> list[Trace]:
    """Return the path of an application: a line, and its start, its end and its worst tick."""
    step = max(1, len(path['time_s']) // _MOST_STEPS)
    x, y = np.abs(path['rotor_speed_rad_s']), path['pressure_pa'] / 1e5
    time, risk = path['time_s'] - path['time_s'][0], path['squeal_risk']
    ends = [0, len(time) - 1]
    names = ['start', 'end']
    if np.isfinite(risk).any():
        ends.append(int(np.nanargmax(risk)))
        names.append('largest risk')
    line = {
        'type': 'scatter', 'mode': 'lines', 'name': 'worst application', 'x': packed(x[::step]),
        'y': packed(y[::step]), 'customdata': packed(np.column_stack([time, risk])[::step]),
        'line': {'color': '#D55E00', 'width': 3},
        'hovertemplate': '%{customdata[0]:.1f} s: %{x:.1f} rad/s, %{y:.1f} bar, risk '
                         '%{customdata[1]:.2f}<extra></extra>'}
    marks = {
        'type': 'scatter', 'mode': 'markers+text', 'name': 'its start, end, largest risk',
        'x': packed(x[ends]), 'y': packed(y[ends]), 'text': names,
        'textposition': ['top right', 'top left', 'bottom right'][:len(ends)],
        'textfont': {'size': 13, 'shadow': 'auto'}, 'hoverinfo': 'skip',
        'marker': {'size': 12, 'color': '#D55E00', 'line': {'color': '#ffffff', 'width': 2},
                   'symbol': ['circle', 'square', 'star'][:len(ends)]}}
    return [line, marks]

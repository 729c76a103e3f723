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


"""Figures of the page of a fleet: shares by group, and the map of operating regions."""

from collections.abc import Mapping, Sequence

import numpy as np
from squeal_core.view.report.figure import Figure, GREY, LEGEND, packed, RISKS, STYLES, Trace
from squeal_core.view.report.fleet_groups import Group, PRESSURE_STEP, Region, SPEED_STEP
from squeal_core.view.report.markup import label

MOST_BARS = 40


def share_bars(groups: Mapping[str, Group], *, name: str, title: str, axis: str,
               unknown: str = '', wide: bool = True) -> Figure:
    """
    Return the share that is not known, and that with predicted squeal, of each group.

    Parameters
    ----------
    groups : mapping
        By name, in the order of the bars; the first 40 are drawn.
    name, title : str
        Id and heading of the figure.
    axis : str
        What the groups are.
    unknown : str
        Why there is none, where there is none.
    wide : bool
        Whether it takes the page's width.

    """
    if not groups:
        return Figure(name, title, unknown=unknown, wide=wide)
    shown = dict(list(groups.items())[:MOST_BARS])
    more = f' The first {MOST_BARS} of {len(groups)}.' if len(groups) > MOST_BARS else ''
    return Figure(name, title, wide=wide, traces=[_unknown(shown), _squeal(shown)], caption=(
        'Hatched: braking time of which the squeal risk is not known. Blue: known brake '
        f'applications with predicted squeal; bars of error: 95 %.{more}'), layout={
            'barmode': 'group', 'bargap': max(0.25, 1.0 - 0.1 * len(shown)), 'legend': LEGEND,
            'xaxis': {'type': 'category', 'title': {'text': axis}, 'automargin': True},
            'yaxis': {'title': {'text': 'share  %'}, 'rangemode': 'tozero'}})


def _names(groups: Mapping[str, Group]) -> list[str]:
    return [label(one or 'not known') for one in groups]


def _unknown(groups: Mapping[str, Group]) -> Trace:
    own = list(groups.values())
    return {
        'type': 'bar', 'name': 'not known, of the braking time', 'x': _names(groups),
        'y': packed([100.0 * one.unknown_share for one in own]),
        'customdata': packed([one.braking_s for one in own]),
        'marker': {'color': 'rgba(136, 136, 136, 0.15)', 'line': {'color': GREY, 'width': 1},
                   'pattern': {'shape': '/', 'fgcolor': GREY, 'fillmode': 'overlay'}},
        'hovertemplate': '%{x}: %{y:.1f} % of %{customdata:.1f} s not known<extra></extra>'}


def _squeal(groups: Mapping[str, Group]) -> Trace:
    share, low, high = 100.0 * np.array([one.known_alarms.share for one in groups.values()]).T
    return {
        'type': 'bar', 'name': 'squeal predicted, of known applications', 'x': _names(groups),
        'y': packed(share), 'customdata': packed(np.column_stack(
            [[one.alarms for one in groups.values()], [one.known for one in groups.values()],
             low, high])),
        'marker': {'color': STYLES[0].colour},
        'error_y': {'type': 'data', 'symmetric': False, 'thickness': 1, 'color': GREY,
                    'array': packed(high - share), 'arrayminus': packed(share - low)},
        'hovertemplate': '%{x}: %{y:.1f} %, %{customdata[0]} of %{customdata[1]} applications'
                         '<br>95 %: %{customdata[2]:.1f} to %{customdata[3]:.1f} %<extra></extra>'}


def region_map(regions: Mapping[Region, Group]) -> Figure:
    """Return the share of applications with predicted squeal by pressure and speed."""
    name, title = 'region-map', 'Operating regions'
    if not any(one.known for one in regions.values()):
        return Figure(name, title, wide=True, unknown='Not known: there is no brake application '
                      'of which the squeal risk is known.')
    shape = tuple(max(getattr(one, key) for one in regions) + 1 for key in ('pressure', 'speed'))
    share, counts = np.full(shape, np.nan), np.zeros((*shape, 3))
    for at, one in regions.items():
        share[at] = 100.0 * one.known_alarms.share[0]
        counts[at] = one.alarms, one.known, one.applications
    unknown = [at for at, one in regions.items() if not one.known]
    x, y = ((np.arange(count) + 0.5) * step for count, step in (
        (shape[1], SPEED_STEP), (shape[0], PRESSURE_STEP / 1e5)))
    return Figure(name, title, wide=True, height=460, traces=[{
        'type': 'heatmap', 'x': packed(x), 'y': packed(y), 'z': packed(share), 'zmin': 0,
        'zmax': 100, 'colorscale': RISKS, 'xgap': 1, 'ygap': 1, 'customdata': packed(
            np.concatenate([counts, np.broadcast_to(share[..., None], (*shape, 1))], axis=2)),
        'colorbar': {'title': {'text': 'squeal<br>predicted %'}, 'thickness': 14},
        'hovertemplate': '%{x:.0f} rad/s, %{y:.1f} bar: %{z:.1f} %<br>%{customdata[0]} of '
                         '%{customdata[1]} known of %{customdata[2]} applications'
                         '<extra></extra>'}, *_marks(unknown)], caption=(
        'Share of the known brake applications with predicted squeal, by mean pressure and rotor '
        'speed at the start. Crosses: applications of which none is known.'), layout={
            'xaxis': {'title': {'text': 'rotor speed  rad/s'}, 'rangemode': 'tozero'},
            'yaxis': {'title': {'text': 'brake pressure  bar'}, 'rangemode': 'tozero'},
            'hovermode': 'closest', 'showlegend': False})


def _marks(unknown: Sequence[Region]) -> list[Trace]:
    return [{'type': 'scatter', 'mode': 'markers', 'name': 'not known',
             'x': packed([(one.speed + 0.5) * SPEED_STEP for one in unknown]),
             'y': packed([(one.pressure + 0.5) * PRESSURE_STEP / 1e5 for one in unknown]),
             'marker': {'symbol': 'x-thin-open', 'size': 9, 'color': GREY},
             'hovertemplate': '%{x:.0f} rad/s, %{y:.1f} bar: not known<extra></extra>'}
            ] if unknown else []


def region_words(at: Region) -> tuple[str, str]:
    """Return the ends of a region: pressure [bar] and rotor speed [rad/s]."""
    bar = PRESSURE_STEP / 1e5
    return (f'{at.pressure * bar:.0f} to {(at.pressure + 1) * bar:.0f}',
            f'{at.speed * SPEED_STEP:.0f} to {(at.speed + 1) * SPEED_STEP:.0f}')


def known_regions(regions: Mapping[Region, Group]) -> list[tuple[Region, Group]]:
    """Return regions with predicted squeal: those with most of it first."""
    result = [(at, one) for at, one in regions.items() if one.alarms]
    return sorted(result, key=lambda item: (item[1].alarms, *item[1].rank), reverse=True)

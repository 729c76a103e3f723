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

"""A stretch of a drive over time, on linked axes: inputs, risk, unstable modes, the unknown."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from squeal_core.calibration.events import MeasuredEvent
from squeal_core.view.report.charts import KELVIN
from squeal_core.view.report.envelope import StretchEnvelope
from squeal_core.view.report.figure import (
    boxes,
    Figure,
    fitted_range,
    GREY,
    hatched,
    LEGEND,
    packed,
    style,
    Trace,
)
from squeal_core.view.report.markup import label

_BRAKING = 'rgba(86, 180, 233, 0.18)'
_SHADE = 'y'  # axis over the whole height, below all others
_LANES, _MODES = 'y2', 'y8'


class _Panel(NamedTuple):
    """A row of the figure: its column, title and unit, and its fraction of the height."""

    axis: str
    column: str
    title: str
    scale: float
    offset: float
    height: float


_PANELS = (
    _Panel(_LANES, '', '', 1.0, 0.0, 0.8),
    _Panel('y3', 'rotor_speed_rad_s', 'speed<br>rad/s', 1.0, 0.0, 1.0),
    _Panel('y4', 'pressure_pa', 'pressure<br>bar', 1e-5, 0.0, 1.0),
    _Panel('y5', 'friction', 'friction', 1.0, 0.0, 1.0),
    _Panel('y6', 'temperature_k', 'temperature<br>°C', 1.0, -KELVIN, 1.0),
    _Panel('y7', 'squeal_risk', 'squeal risk', 1.0, 0.0, 1.2),
    _Panel(_MODES, '', 'unstable<br>modes  kHz', 1.0, 0.0, 1.5))
_GAP = 0.018
_WITHOUT_SCALE = {'showticklabels': False, 'ticks': '', 'showgrid': False,
                  'zeroline': False}  # where nothing is drawn


def timeline(envelope: StretchEnvelope, *, name: str, title: str, what: str,
             measured: Sequence[MeasuredEvent] = ()) -> Figure:
    """
    Return the timeline of a stretch.

    Parameters
    ----------
    envelope : StretchEnvelope
        The stretch.
    name, title : str
        Id and heading of the figure.
    what : str
        Of which recording and which stretch it is, for the caption.
    measured : sequence of MeasuredEvent
        Of the recording, of known pitch.

    """
    if not envelope.brakes:
        return Figure(name, title, unknown=f'Not known: there is no tick in {what}.', wide=True)
    brakes = list(envelope.brakes)
    traces = [*_areas(envelope), *_lanes(envelope, brakes)]
    for place, brake in enumerate(brakes):
        traces += _curves(envelope, brake, place)
    traces += [*_modes(envelope), *_empty(envelope)]
    heard = [event for event in measured if event.time <= envelope.end
             and max(event.time, event.end) >= envelope.start]
    traces += _heard(envelope, heard)
    points = ('one point a tick' if envelope.single else
              f'the smallest and the largest value in each {envelope.width:.3g} s')
    return Figure(name, title, wide=True, height=860, traces=traces, caption=(
        f'{what}; {points}. Blue: some brake is known to slide under load. Hatched: the squeal '
        'risk of some brake is not known; of which one, the first row says. Click a brake in the '
        'legend to hide it.' + ' Stars and lines among the modes: measured squeal.' * bool(heard)),
        layout=_layout(envelope, brakes, heard))


def _areas(envelope: StretchEnvelope) -> Iterator[Trace]:
    """Yield the areas behind all panels: braking of any brake, and unknown of any."""
    every = envelope.brakes.values()
    sliding = envelope.stretches(np.any([one.sliding for one in every], axis=0))
    unknown = envelope.stretches(np.any([one.unknown for one in every], axis=0))
    about = {'yaxis': _SHADE, 'showlegend': True}
    yield boxes(sliding, (0.0, 1.0), name='braking', fillcolor=_BRAKING, **about)
    yield boxes(unknown, (0.0, 1.0), name='not known', **about, **hatched(GREY))


def _lanes(envelope: StretchEnvelope, brakes: Sequence[str]) -> Iterator[Trace]:
    """Yield a lane a brake: a bar while it brakes, hatched while its risk is not known."""
    for place, brake in enumerate(brakes):
        own, colour = envelope.brakes[brake], style(place).colour
        ends = place - 0.36, place + 0.36
        about = {'name': label(brake), 'legendgroup': label(brake)}
        yield boxes(envelope.stretches(own.sliding & ~own.unknown), ends, yaxis=_LANES,
                    fillcolor=colour, opacity=0.75, **about)
        yield boxes(envelope.stretches(own.unknown), ends, yaxis=_LANES, **about,
                    **hatched(colour))


def _curves(envelope: StretchEnvelope, brake: str, place: int) -> Iterator[Trace]:
    own = style(place)
    for panel in _PANELS:
        if not panel.column:
            continue
        start, step, value = envelope.curve(brake, panel.column)
        if not np.isfinite(value).any():
            continue
        yield {
            'type': 'scatter', 'mode': 'lines', 'name': label(brake), 'legendgroup': label(brake),
            'showlegend': panel.column == 'rotor_speed_rad_s', 'xaxis': 'x', 'yaxis': panel.axis,
            'x0': start, 'dx': step, 'y': packed(value * panel.scale + panel.offset),
            'line': {'color': own.colour, 'dash': own.dash, 'width': 1.4},
            'connectgaps': False, 'hovertemplate': '%{y:.4g}'}


def _empty(envelope: StretchEnvelope) -> Iterator[Trace]:
    """Yield a trace without a point for panels of which nothing is known: they are drawn, too."""
    for panel in _PANELS:
        if panel.column and not _is_known(envelope, panel) or (
                panel.axis == _MODES and not envelope.modes().size):
            yield {'type': 'scatter', 'xaxis': 'x', 'yaxis': panel.axis, 'showlegend': False,
                   'x': [float(envelope.times[0])], 'y': [None]}


def _modes(envelope: StretchEnvelope) -> Iterator[Trace]:
    marks = envelope.modes()
    if marks.size:
        time, frequency, growth = marks.T
        yield {
            'type': 'scatter', 'mode': 'markers', 'name': 'unstable mode', 'showlegend': False,
            'xaxis': 'x', 'yaxis': _MODES, 'x': packed(time), 'y': packed(frequency / 1e3),
            'marker': {'size': 4, 'color': packed(growth), 'colorscale': 'Viridis', 'cmin': 0,
                       'reversescale': True, 'showscale': True, 'colorbar': {
                           'title': {'text': 'growth<br>rate 1/s'}, 'len': 0.22, 'y': 0.09,
                           'thickness': 12}},
            'hovertemplate': '%{y:.2f} kHz, growth %{marker.color:.1f} 1/s'}


def _heard(envelope: StretchEnvelope, measured: Sequence[MeasuredEvent]) -> list[Trace]:
    """Return measured events as lines from start to end among the modes, with a star each."""
    if not measured:
        return []
    rows = [(event.time - envelope.origin, max(event.time, event.end) - envelope.origin, event)
            for event in measured]
    return [{
        'type': 'scatter', 'mode': 'lines+markers', 'name': 'measured squeal', 'xaxis': 'x',
        'yaxis': _MODES, 'connectgaps': False, 'line': {'color': GREY, 'width': 3},
        'x': packed(np.ravel([(start, end, np.nan) for start, end, _ in rows])),
        'y': packed(np.ravel([(kilohertz, kilohertz, np.nan) for *_, event in rows
                              for kilohertz in [event.frequency_hz / 1e3]])),
        'marker': {'symbol': 'star-open', 'size': packed(np.tile([11.0, 0.0, 0.0], len(rows))),
                   'color': GREY},
        'text': [label(event.place or 'brake not known') for *_, event in rows for _ in range(3)],
        'hovertemplate': 'measured %{y:.2f} kHz<br>%{text}<extra></extra>'}]


def _layout(envelope: StretchEnvelope, brakes: Sequence[str],
            measured: Sequence[MeasuredEvent]) -> dict[str, Any]:
    times = envelope.times
    layout: dict[str, Any] = {
        'xaxis': {'title': {'text': 'time from the start of the recording  s'}, 'anchor': _MODES,
                  'range': [float(times[0]), float(times[-1])], 'showspikes': True,
                  'spikemode': 'across', 'spikethickness': 1, 'spikedash': 'dot'},
        'yaxis': {'visible': False, 'range': [0, 1], 'fixedrange': True, 'domain': [0, 1]},
        'hovermode': 'x', 'hoversubplots': 'axis', 'margin': {'l': 85, 'r': 20, 't': 20, 'b': 50},
        'legend': LEGEND, 'dragmode': 'zoom',
        'plot_bgcolor': 'rgba(0,0,0,0)', 'annotations': []}
    unit = (1.0 - _GAP * (len(_PANELS) - 1)) / sum(panel.height for panel in _PANELS)
    top = 1.0
    for panel in _PANELS:
        bottom = max(0.0, top - unit * panel.height)
        axis: dict[str, Any] = {
            'title': {'text': panel.title, 'font': {'size': 11}}, 'domain': [bottom, top],
            'anchor': 'x', 'rangemode': 'tozero' if panel.offset == 0.0 else 'normal'}
        layout[f'yaxis{panel.axis[1:]}'] = axis
        if panel.column and not _is_known(envelope, panel):
            axis |= _WITHOUT_SCALE
            _say(layout, panel, 'not known in this stretch')
        top = bottom - _GAP
    layout['yaxis2'] |= {'tickvals': list(range(len(brakes))), 'range': [len(brakes) - 0.5, -0.5],
                         'ticktext': list(map(label, brakes)), 'fixedrange': True,
                         'showgrid': False, 'zeroline': False}
    layout['yaxis7']['range'] = [0, 1]
    modes = envelope.modes()[:, 1]
    hertz = [*modes.tolist(), *(event.frequency_hz for event in measured)]
    layout['yaxis8'] |= {'range': fitted_range(np.array(hertz) / 1e3)} if hertz else _WITHOUT_SCALE
    if not modes.size:
        _say(layout, _PANELS[-1], 'no unstable mode where it is known')
    return layout


def _is_known(envelope: StretchEnvelope, panel: _Panel) -> bool:
    return any(np.isfinite(own.high[panel.column]).any() for own in envelope.brakes.values())


def _say(layout: dict[str, Any], panel: _Panel, text: str) -> None:
    layout['annotations'].append({
        'xref': 'paper', 'yref': f'{panel.axis} domain', 'x': 0.5, 'y': 0.5, 'text': text,
        'showarrow': False})

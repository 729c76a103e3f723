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

"""Charts of levels and frequencies, as SAE J2521 and VDA 306 have them."""

from collections.abc import Iterator, Sequence
import math
from typing import Any

import numpy as np
from squeal_core.calibration.events import MeasuredEvent
from squeal_core.common.arrays import FloatArray
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.result_files import ReplayResult
from squeal_core.sound.comparison import Comparison
from squeal_core.view.report.application_shares import exceedance
from squeal_core.view.report.figure import (
    Figure,
    fitted_range,
    GREY,
    LEGEND,
    packed,
    points,
    style,
    Trace,
)
from squeal_core.view.report.markup import label
from squeal_core.view.report.runs import end_of, Located, Run, start_of

DECIBELS = 20.0 / math.log(10.0)  # of a neper
KELVIN = 273.15
NOT_KNOWN = 'Not known: there is no brake application of which the squeal risk is known.'


def main_peaks(runs: Sequence[Run]) -> Figure:
    """Return the frequency of the worst mode of each application over its level."""
    about: dict[str, Any] = {'name': 'main-peak', 'title': 'Main peak'}
    if not any(run.known for run in runs):
        return Figure(**about, unknown=NOT_KNOWN)
    traces = [trace for place, run in enumerate(runs) for trace in _peaks(run, place)]
    if not traces:
        return Figure(**about, unknown='No mode of the squeal band is known of any application.')
    return Figure(**about, caption=(
        'Worst mode of each brake application: its frequency over the predicted level, that is '
        'the build-up above the noise floor (1 neper is 8.7 dB). Filled: squeal predicted.'
        ), traces=traces, layout={
            'xaxis': {'title': {'text': 'largest build-up  dB above the noise floor'}},
            'yaxis': {'title': {'text': 'frequency  kHz'}, 'range': fitted_range(
                [one.frequency_hz / 1e3 for run in runs for one in run.known])},
            'hovermode': 'closest', 'legend': LEGEND})


def _peaks(run: Run, place: int) -> Iterator[Trace]:
    """Yield the points of a run: those with predicted squeal filled, the others open."""
    own = style(place)
    for alarm, words in ((True, 'squeal predicted'), (False, 'not')):
        result = [one for one in run.known if bool(one.alarm) == alarm
                  and math.isfinite(one.frequency_hz)]
        if result:
            yield {
                **points(len(result)), 'name': f'{label(run.name)}: {words}',
                'x': packed([DECIBELS * one.build_up_nepers for one in result]),
                'y': packed([one.frequency_hz / 1e3 for one in result]),
                'text': [label(one.brake) for one in result],
                'customdata': packed([(one.peak_risk, one.growth_rate_1_s) for one in result]),
                'marker': {'color': own.colour, 'size': 8, 'opacity': 0.8,
                           'symbol': own.symbol + ('' if alarm else '-open')},
                'hovertemplate': '%{y:.3f} kHz, %{x:.1f} dB<br>%{text}, risk '
                                 '%{customdata[0]:.2f}, growth %{customdata[1]:+.1f} 1/s'
                                 '<extra></extra>'}


def frequencies_over_time(runs: Sequence[Run],
                          comparisons: Sequence[Comparison] = ()) -> Figure:
    """Return the frequencies of all events over the recorded time, and of measured ones."""
    about: dict[str, Any] = {'name': 'frequency-time', 'title': 'Frequency over time',
                             'wide': True}
    none = (NOT_KNOWN if all(run.nothing_known for run in runs) else
            '' if any(run.events for run in runs) else
            'No squeal event is predicted while the risk was known.')
    measured = [_measured_events(run, result)
                for run, result in zip(runs, comparisons, strict=False)]
    if none and not any(measured):
        return Figure(**about, unknown=none)
    traces = []
    for place, run in enumerate(runs):
        brakes = run.brakes if len(runs) == 1 else ['']
        for number, brake in enumerate(brakes):
            own = [at for at in run.events if brake in ('', at.record.brake)]
            if own:
                traces.append(_event_marks(run, own, label(brake or run.name), place + number))
    traces += [_measured_marks(runs[place], marks, len(runs) > 1, place)
               for place, marks in enumerate(measured) if marks]
    longest = max(run.offsets[-1] for run in runs)
    return Figure(**about, caption=(
        (none or 'Every predicted squeal event, at its start. Size: its largest risk.')
        + (' Stars: every measured one of known pitch.' if any(measured) else '') + (
            ' Recordings are drawn one after the other.' if longest else '')),
        traces=traces, layout={
            'xaxis': {'title': {'text': 'recorded time  s'}, 'rangemode': 'tozero'},
            'yaxis': {'title': {'text': 'frequency  kHz'}, 'range': fitted_range(
                [*(at.record.frequency_hz / 1e3 for run in runs for at in run.events),
                 *(at.record.frequency_hz / 1e3 for marks in measured for at in marks)])},
            'hovermode': 'closest', 'legend': LEGEND,
            'shapes': [{'type': 'line', 'x0': time, 'x1': time, 'yref': 'paper', 'y0': 0, 'y1': 1,
                        'line': {'color': GREY, 'width': 1, 'dash': 'dot'}}
                       for run in runs[:1] for time in run.offsets[1:60]]})


def _event_marks(run: Run, events: Sequence[Any], name: str, place: int) -> Trace:
    own = style(place)
    records = [at.record for at in events]
    return {
        **points(len(records)), 'name': name,
        'x': packed([run.elapsed(at, at.record.start_s) for at in events], 'f8'),
        'y': packed([one.frequency_hz / 1e3 for one in records]),
        'text': [f'{label(one.brake)}, {label(one.clock_time or f"{one.start_s:.1f} s")}, '
                 f'risk {one.peak_risk:.2f}, {label(one.mechanism)}' for one in records],
        'marker': {'color': own.colour, 'symbol': own.symbol, 'opacity': 0.8,
                   'size': packed([5.0 + 9.0 * (one.peak_risk if one.peak_risk > 0 else 0.0)
                                   for one in records])},
        'hovertemplate': '%{y:.3f} kHz at %{x:.1f} s<br>%{text}<extra></extra>'}


def _measured_events(run: Run, found: Comparison) -> list[Located]:
    """Return the measured events of a run that have a pitch."""
    return [Located(i, event) for i, result in enumerate(run.results)
            for event in measured_in(result, found)]


def _measured_marks(run: Run, at: Sequence[Located], is_named: bool, place: int) -> Trace:
    return {
        **points(len(at)), 'name': f'{label(run.name)}, measured' if is_named else 'measured',
        'x': packed([run.elapsed(one, one.record.time) for one in at], 'f8'),
        'y': packed([one.record.frequency_hz / 1e3 for one in at]),
        'text': [label(one.record.place or 'brake not known') for one in at],
        'marker': {'color': style(place).colour if is_named else GREY, 'symbol': 'star-open',
                   'size': 11},
        'hovertemplate': 'measured %{y:.3f} kHz at %{x:.1f} s<br>%{text}<extra></extra>'}


def measured_in(result: ReplayResult, found: Comparison) -> list[MeasuredEvent]:
    """Return the measured events of known pitch in a recording."""
    return [event for event in (
        *(event for one in found.matches.applications if one.braking.recording == result.name
          for event in one.events),
        *(event for event in found.matches.unmatched if event.recording in ('', result.name)
          and start_of(result) <= event.time <= end_of(result)))
          if math.isfinite(event.frequency_hz)]


def worst_levels(runs: Sequence[Run]) -> Figure:
    """Return the cumulated relative frequency of the worst level per application."""
    about: dict[str, Any] = {
        'name': 'worst-level', 'title': 'Cumulated relative frequency of the worst level'}
    if not any(run.known for run in runs):
        return Figure(**about, unknown=NOT_KNOWN)
    traces: list[Trace] = []
    for place, (name, records) in enumerate(_groups(runs)):
        for panel, levels in enumerate((
                [DECIBELS * one.build_up_nepers for one in records],
                [one.peak_risk for one in records])):
            traces.append(_reached(levels, name, place, panel))
    return Figure(**about, caption=(
        'Share of the known brake applications whose worst level is at least the one below.'),
        traces=traces, layout={
            'grid': {'rows': 1, 'columns': 2, 'pattern': 'independent'},
            'xaxis': {'title': {'text': 'largest build-up  dB'}},
            'xaxis2': {'title': {'text': 'largest squeal risk'}, 'range': [0, 1]},
            'yaxis': {'title': {'text': 'share of applications  %'}, 'range': [0, 102]},
            'yaxis2': {'range': [0, 102]}, 'legend': LEGEND})


def _groups(runs: Sequence[Run]) -> Iterator[tuple[str, list[ApplicationRecord]]]:
    """Yield the groups with a curve each: all and each brake of one run, or each run."""
    if len(runs) > 1:
        yield from ((label(run.name), run.known) for run in runs)
        return
    yield 'all brakes', runs[0].known
    for brake in runs[0].brakes:
        yield label(brake), [one for one in runs[0].known if one.brake == brake]


def _reached(levels: Sequence[float], name: str, place: int, panel: int) -> Trace:
    level, share = exceedance(levels)
    own, axis = style(place), '' if panel == 0 else '2'
    x: FloatArray = np.concatenate([level[:1] * 0.0, level])
    return {
        'type': 'scatter', 'mode': 'lines', 'name': name, 'legendgroup': name,
        'showlegend': panel == 0, 'xaxis': f'x{axis}', 'yaxis': f'y{axis}',
        'x': packed(x), 'y': packed(100.0 * np.concatenate([share[:1], share])),
        'line': {'color': own.colour, 'dash': own.dash, 'shape': 'vh', 'width': 2},
        'hovertemplate': '%{y:.1f} % reach %{x:.3g}<extra>%{fullData.name}</extra>'}

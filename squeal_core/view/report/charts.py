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

"""Charts of brake noise, as SAE J2521 and VDA 306 have them, from tables of applications."""

from collections.abc import Callable, Iterator, Sequence
import math
from typing import Any, NamedTuple

import numpy as np
from squeal_core.calibration.events import MeasuredEvent
from squeal_core.calibration.scores import braking_numbers
from squeal_core.common.arrays import FloatArray
from squeal_core.monitor.drive_applications import ApplicationRecord
from squeal_core.monitor.result_files import ReplayResult
from squeal_core.sound.comparison import Comparison
from squeal_core.sound.matching import MatchedApplication
from squeal_core.view.report.application_shares import classes, exceedance, Shares, shares
from squeal_core.view.report.figure import Figure, GREY, LEGEND, packed, points, style, Trace
from squeal_core.view.report.markup import label
from squeal_core.view.report.runs import end_of, Located, Run, start_of

DECIBELS = 20.0 / math.log(10.0)  # of a neper
KELVIN = 273.15
NOT_KNOWN = 'Not known: there is no brake application of which the squeal risk is known.'


class Condition(NamedTuple):
    """What occurrence is shown over, with the width of its classes."""

    name: str
    title: str
    unit: str
    width: float
    value: Callable[[ApplicationRecord], float]
    of_all: bool = False


CONDITIONS = (
    Condition('frequency', 'frequency of the worst mode', 'kHz', 0.5,
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
    name, title, unit, width, value, of_all = condition
    about: dict[str, Any] = {'name': f'occurrence-{name}', 'title': f'Occurrence over {name}'}
    values = [np.array([value(one) for one in run.known]) for run in runs]
    hits = [np.array([one.alarm for one in run.known], bool) for run in runs]
    brakings = [run.known_brakings for run in runs]
    names = [label(run.name) if len(runs) > 1 else 'predicted' for run in runs]
    for run, found in zip(runs, comparisons, strict=False):
        heard = [one for one in found.matches.applications if one.outcome != 'not known']
        values.append(np.array([_measured_value(one, condition) for one in heard]))
        hits.append(np.array([one.measured for one in heard], bool))
        brakings.append(braking_numbers([
            (one.recording, one.start, one.end) for one in (found.braking for found in heard)]))
        names.append(f'{label(run.name)}, measured' if len(runs) > 1 else 'measured')
    counted = [own[hit] if of_all else own for own, hit in zip(values, hits, strict=True)]
    everything = np.concatenate([own[np.isfinite(own)] for own in counted])
    if not any(len(own) for own in values):
        return Figure(**about, unknown=NOT_KNOWN)
    if not everything.size:
        return Figure(**about, unknown=(
            f'No squeal is predicted in the {sum(map(len, values))} brake applications of which '
            'it is known.' if of_all else f'Not known: no brake application has a {name}.'))
    edges = classes(everything, width)
    traces = [_bars(words, place, shares(own, hit, number, edges, of_all=of_all))
              for place, (words, own, hit, number) in enumerate(
                  zip(names, values, hits, brakings, strict=True))]
    left_out = sum(int(np.isnan(own).sum()) for own in values[:len(runs)]) if not of_all else 0
    caption = ('Share of the known brake applications ' + (
        'whose worst mode is in the class' if of_all else 'of the class')
        + (' with predicted or measured squeal' if comparisons else ' with predicted squeal')
        + '; bars of error: 95 %, by brakings of the vehicle.' + (
            f' Left out: {left_out} applications without a {name}.' if left_out else ''))
    return Figure(**about, caption=caption, traces=traces, layout={
        'xaxis': {'title': {'text': f'{title}  {unit}'},
                  'range': [float(edges[0]), float(edges[-1])]}, 'barmode': 'group', 'bargap': 0.1,
        'yaxis': {'title': {'text': 'share of applications  %'}, 'rangemode': 'tozero'},
        'showlegend': len(traces) > 1, 'legend': LEGEND})


def _measured_value(one: MatchedApplication, condition: Condition) -> float:
    """Return the condition of an application; its frequency is the measured pitch."""
    if not condition.of_all:
        return condition.value(one.braking.worst)
    return one.events[0].frequency_hz / 1e3 if one.events else math.nan


def _bars(name: str, place: int, found: Shares) -> Trace:
    percent = 100.0 * found.share
    return {
        'type': 'bar', 'name': name, 'x': packed(found.edges[:-1] + 0.5 * np.diff(
            found.edges)), 'y': packed(percent), 'customdata': packed(np.column_stack(
                [found.edges[:-1], found.edges[1:], found.counts, 100 * found.low,
                 100 * found.high])),
        'marker': {'color': style(place).colour,
                   'pattern': {'shape': ('', '/', 'x', '.', '\\', '-')[place % 6]}},
        'error_y': {'type': 'data', 'symmetric': False, 'thickness': 1, 'color': GREY,
                    'array': packed(100 * found.high - percent),
                    'arrayminus': packed(percent - 100 * found.low)},
        'hovertemplate': '%{customdata[0]:.4g} to %{customdata[1]:.4g}: %{y:.1f} % of '
                         '%{customdata[2]} applications<br>95 %: %{customdata[3]:.1f} to '
                         '%{customdata[4]:.1f} %<extra></extra>'}


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
            'yaxis': {'title': {'text': 'frequency  kHz'}, 'rangemode': 'tozero'},
            'hovermode': 'closest', 'legend': LEGEND})


def _peaks(run: Run, place: int) -> Iterator[Trace]:
    """Yield the points of a run: those with predicted squeal filled, the others open."""
    own = style(place)
    for alarm, words in ((True, 'squeal predicted'), (False, 'not')):
        found = [one for one in run.known if bool(one.alarm) == alarm
                 and math.isfinite(one.frequency_hz)]
        if found:
            yield {
                **points(len(found)), 'name': f'{label(run.name)}: {words}',
                'x': packed([DECIBELS * one.build_up_nepers for one in found]),
                'y': packed([one.frequency_hz / 1e3 for one in found]),
                'text': [label(one.brake) for one in found],
                'customdata': packed([(one.peak_risk, one.growth_rate_1_s) for one in found]),
                'marker': {'color': own.colour, 'size': 8, 'opacity': 0.8,
                           'symbol': own.symbol + ('' if alarm else '-open')},
                'hovertemplate': '%{y:.2f} kHz, %{x:.1f} dB<br>%{text}, risk '
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
    measured = [_measured_marks(run, found, len(runs) > 1, place) for place, (run, found)
                in enumerate(zip(runs, comparisons, strict=False))]
    if none and not any(measured):
        return Figure(**about, unknown=none)
    traces = []
    for place, run in enumerate(runs):
        brakes = run.brakes if len(runs) == 1 else ['']
        for number, brake in enumerate(brakes):
            own = [at for at in run.events if brake in ('', at.record.brake)]
            if own:
                traces.append(_event_marks(run, own, label(brake or run.name), place + number))
    traces += filter(None, measured)
    longest = max(run.offsets[-1] for run in runs)
    return Figure(**about, caption=(
        (none or 'Every predicted squeal event, at its start. Size: its largest risk.')
        + (' Stars: every measured one of known pitch.' if any(measured) else '') + (
            ' Recordings are drawn one after the other.' if longest else '')),
        traces=traces, layout={
            'xaxis': {'title': {'text': 'recorded time  s'}, 'rangemode': 'tozero'},
            'yaxis': {'title': {'text': 'frequency  kHz'}, 'rangemode': 'tozero'},
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
        'hovertemplate': '%{y:.2f} kHz at %{x:.1f} s<br>%{text}<extra></extra>'}


def _measured_marks(run: Run, found: Comparison, is_named: bool, place: int) -> Trace | None:
    """Return the measured events of a run that have a pitch; None: there is none."""
    at = [Located(i, event) for i, result in enumerate(run.results)
          for event in measured_in(result, found)]
    if not at:
        return None
    return {
        **points(len(at)), 'name': f'{label(run.name)}, measured' if is_named else 'measured',
        'x': packed([run.elapsed(one, one.record.time) for one in at], 'f8'),
        'y': packed([one.record.frequency_hz / 1e3 for one in at]),
        'text': [label(one.record.place or 'brake not known') for one in at],
        'marker': {'color': style(place).colour if is_named else GREY, 'symbol': 'star-open',
                   'size': 11},
        'hovertemplate': 'measured %{y:.2f} kHz at %{x:.1f} s<br>%{text}<extra></extra>'}


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
    """Yield what has a curve of its own: all and each brake of one run, or each run."""
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

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

"""Measured squeal beside the predicted one: outcomes, scores, pitches, calibration curve."""

from collections import Counter
from collections.abc import Iterator
import math
from typing import Any

import numpy as np
from squeal_core.sound.comparison import ahead_or_late, Comparison, HIT_ALONE
from squeal_core.sound.matching import MatchedApplication, OUTCOMES
from squeal_core.sound.prediction_scores import SCORES_NOT_KNOWN
from squeal_core.view.report.figure import Figure, GREY, LEGEND, packed, style
from squeal_core.view.report.markup import Content, element, Markup, prose, table
from squeal_core.view.report.words import clock, DASH, number, risk

_LISTED = 20  # applications


def measured_section(result: Comparison, of_run: str) -> list[Markup]:
    """Return the notes of a comparison, then outcomes, pitches, lead times and scores."""
    return [element('h3', f'Measured squeal{of_run}'),
            element('ul', [element('li', prose(note)) for note in result.notes]),
            _outcomes(result), *_pitches(result), *_scores(result), *_applications(result)]


def _outcomes(result: Comparison) -> Markup:
    counts = result.counts
    known = sum(counts.values()) - counts['not known']
    heard = counts['hit'] + counts['miss']
    why = Counter(one.why for one in result.matches.applications if one.outcome == 'not known')
    share = f'{100.0 * heard / known:.1f} %' if known else 'not known'
    rows: list[list[Content]] = [
        [name, str(counts[name]), result.hits_in_words() if name == 'hit' else '']
        for name in OUTCOMES[:-1]]
    rows.append(['not known', str(counts['not known']),
                 '; '.join(f'{count}: {reason}' for reason, count in why.most_common())])
    rows.append(['with measured squeal', str(heard), f'{share} of {known} known ones'])
    what = {'brake': 'of one brake each'}.get(
        result.unit, 'of brakes that the events do not tell apart: '
        + ', '.join(' + '.join(group) for group in result.matches.groups))
    return table(('outcome', 'applications', ''), rows, numbers_from=1,
                 caption=f'Brake applications, {what}')


def _pitches(result: Comparison) -> Iterator[Markup]:
    pitch = result.as_json()['frequency']
    if result.hits['count']:
        yield element('p', f'{HIT_ALONE.capitalize()}: some alarm was up in the same braking.')
    if pitch['events'] and not pitch['with_unstable_mode']:
        yield element('p', f'Pitch: no unstable mode was predicted at any of {pitch["events"]} '
                           'events.')
    if pitch['with_unstable_mode']:
        yield element('p', (
            f'Pitch: the nearest predicted unstable mode is off by '
            f'{100 * pitch["median_relative_error"]:.1f} % in the median; within 2 % at '
            f'{pitch["within_2_percent"]} of {pitch["events"]} events; none was predicted at '
            f'{pitch["events"] - pitch["with_unstable_mode"]}.'))
    if words := result.lead_in_words():
        yield element('p', f'Alarm: {words}.')


def _scores(result: Comparison) -> Iterator[Markup]:
    scores = result.scores
    if scores.predictors:
        def row(name: str) -> list[Content]:
            one = scores.predictors[name]
            own, ends = one.score, one.intervals
            return [name, number(own.brier, '.3f'), number(own.brier_skill, '+.2f'),
                    number(own.calibration_error, '.3f'), *(
                        _with_ends(value, span) for value, span in (
                            (one.precision, ends['precision']), (one.recall, ends['recall']),
                            (own.correlation, ends['correlation']),
                            (own.roc_area, own.roc_interval),
                            (own.precision_area, own.precision_interval)))]

        yield table(('', 'Brier', 'skill', 'ECE', 'precision', 'recall', 'Matthews', 'ROC area',
                     'PR area'), map(row, scores.predictors),
                    caption='Scores, with 95 % intervals, beside the base rate and a table over '
                            'pressure, speed and temperature, each learned on the other half')
    for note in scores.notes:
        yield element('p', prose(note))


def _with_ends(value: float, ends: tuple[float, float]) -> str:
    if math.isnan(value):
        return DASH
    return f'{value:.2f} ({number(ends[0], ".2f")} to {number(ends[1], ".2f")})'


def _applications(result: Comparison) -> Iterator[Markup]:
    shown = [one for one in result.matches.applications
             if one.outcome in ('miss', 'false alarm', 'hit')]
    shown.sort(key=lambda one: ('miss', 'false alarm', 'hit').index(one.outcome))
    if shown:
        yield table(('start', 'recording', 'brakes', 'outcome', 'risk', 'predicted Hz',
                     'measured Hz', 'alarm'), map(_row, shown[:_LISTED]), numbers_from=4,
                    caption='Misses and false alarms first')
    if len(shown) > _LISTED:
        yield element('p', f'{len(shown) - _LISTED} more: see --json.')


def _row(one: MatchedApplication) -> list[Content]:
    return [clock(one.braking.start), one.braking.recording, ', '.join(one.braking.brakes),
            one.outcome, risk(one.braking.risk),
            number(one.braking.worst.frequency_hz, '.0f'),
            ', '.join(number(event.frequency_hz, '.0f') for event in one.events[:4]) or DASH,
            DASH if math.isnan(one.lead_time) else ahead_or_late(one.lead_time)]


def measured_figures(result: Comparison, name: str, of_run: str) -> list[Figure]:
    """Return the calibration curve and the pitches of a comparison."""
    return [_calibration(result, f'calibration-{name}', f'Predicted risk against measured squeal'
                         f'{of_run}'),
            _pitch_chart(result, f'pitch-{name}', f'Predicted against measured pitch{of_run}')]


def _diagonal(low: float, high: float, words: str) -> dict[str, Any]:
    return {'type': 'scatter', 'mode': 'lines', 'x': [low, high], 'y': [low, high], 'name': words,
            'line': {'color': GREY, 'dash': 'dash', 'width': 1}, 'hoverinfo': 'skip'}


def _calibration(result: Comparison, name: str, title: str) -> Figure:
    curve = np.array(result.scores.curve, float).reshape(-1, 3)
    if not len(curve):
        return Figure(name, title, unknown='Not known: ' + ('; '.join(
            note.removeprefix(SCORES_NOT_KNOWN) for note in result.scores.notes)
            or 'there are too few applications whose outcome is known') + '.')
    own = style(0)
    return Figure(name, title, caption=(
        'Calibration curve: share of brake applications with measured squeal over their predicted '
        'largest risk, in equally full bins. On the dashed line the risk is what it says.'),
        traces=[_diagonal(0.0, 1.0, 'calibrated'), {
            'type': 'scatter', 'mode': 'lines+markers', 'name': 'prediction',
            'x': packed(curve[:, 0]), 'y': packed(curve[:, 1]), 'customdata': packed(curve[:, 2]),
            'line': {'color': own.colour}, 'marker': {'size': 9, 'symbol': own.symbol},
            'hovertemplate': 'risk %{x:.2f}: squeal in %{y:.2f} of %{customdata} applications'
                             '<extra></extra>'}],
        layout={'xaxis': {'title': {'text': 'predicted risk'}, 'range': [0, 1]},
                'yaxis': {'title': {'text': 'share with measured squeal'}, 'range': [0, 1.02]},
                'legend': LEGEND})


def _pitch_chart(result: Comparison, name: str, title: str) -> Figure:
    pairs = np.array([(pitch, pitch * (1.0 + error)) for pitch, error in result.frequency_errors
                      if not math.isnan(error)]).reshape(-1, 2) / 1e3
    if not len(pairs):
        return Figure(name, title, unknown='No unstable mode was predicted at any measured event '
                                           'of known pitch.')
    own = style(1)
    low, high = 0.95 * float(pairs.min()), 1.05 * float(pairs.max())
    return Figure(name, title, caption=(
        'Nearest unstable mode that was predicted at the time of each measured event; events at '
        'which none was predicted are not drawn.'), traces=[_diagonal(low, high, 'equal'), {
            'type': 'scatter', 'mode': 'markers', 'name': 'events', 'x': packed(pairs[:, 0]),
            'y': packed(pairs[:, 1]), 'marker': {'color': own.colour, 'symbol': own.symbol,
                                                 'size': 8, 'opacity': 0.7},
            'hovertemplate': 'measured %{x:.3f} kHz, predicted %{y:.3f} kHz<extra></extra>'}],
        layout={'xaxis': {'title': {'text': 'measured  kHz'}, 'range': [low, high]},
                'yaxis': {'title': {'text': 'predicted  kHz'}, 'range': [low, high]},
                'hovermode': 'closest', 'legend': LEGEND})

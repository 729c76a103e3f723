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

"""Comparison of predicted with measured squeal: outcomes, pitches, lead times and scores."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common.wording import counted, risk_in_words
from squeal_core.monitor.results.event_places import event_places
from squeal_core.sound.brakings import Predictions
from squeal_core.sound.clock_check import check_clocks, time_in_words
from squeal_core.sound.listening import Listening, MeasuredSquealError, read_listenings
from squeal_core.sound.matching import (
    match,
    MatchedApplication,
    Matches,
    OUTCOMES,
    SAME_PITCH,
)
from squeal_core.sound.prediction_scores import PredictionScores, score_predictions, scored

FORMAT = 1
_SHOWN = 20  # applications that are listed as text
HIT_ALONE = 'a hit alone says nothing of pitch or time'


@dataclass(frozen=True)
class Comparison:
    """
    Predicted and measured squeal of some recordings.

    Parameters
    ----------
    recordings : tuple of str
    listenings : tuple of Listening
    matches : Matches
    scores : PredictionScores
    notes : tuple of str
        What it rests on, and what is not known.

    """

    recordings: tuple[str, ...]
    listenings: tuple[Listening, ...]
    matches: Matches
    scores: PredictionScores
    notes: tuple[str, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Return the number of brake applications of each outcome."""
        return {outcome: self.matches.count(outcome) for outcome in OUTCOMES}

    @property
    def unit(self) -> str:
        """Return the unit of an application: a brake, or brakes that events do not distinguish."""
        groups = self.matches.groups
        if all(len(group) == 1 for group in groups):
            return 'brake'
        return 'vehicle' if len(groups) == 1 else 'group of brakes'

    @property
    def frequency_errors(self) -> list[tuple[float, float]]:
        """Measured pitch and relative error of the nearest predicted unstable mode; NaN: none."""
        return [(event.frequency_hz, error / event.frequency_hz)
                for one in self.matches.applications
                for event, error in zip(one.events, one.frequency_errors, strict=True)
                if not math.isnan(event.frequency_hz)]

    @property
    def lead_times(self) -> list[float]:
        """Lead times of the hits whose alarm and squeal have a start [s]."""
        return [one.lead_time for one in self.matches.applications
                if not math.isnan(one.lead_time)]

    @property
    def hits(self) -> dict[str, int]:
        """Return the number of hits, and of those with right pitch, time or both."""
        hits = [one for one in self.matches.applications if one.outcome == 'hit']
        return {'count': len(hits), 'pitch_within_2_percent': sum(one.pitch_fits for one in hits),
                'alarm_first': sum(one.alarm_first for one in hits),
                'both': sum(one.pitch_fits and one.alarm_first for one in hits)}

    def hits_in_words(self) -> str:
        """Return of how many hits pitch and time were right; empty without hits."""
        hits = self.hits
        if not hits['count']:
            return ''
        return (f'of {counted(hits["count"], "hit")}, pitch within {SAME_PITCH:.0%} in '
                f'{hits["pitch_within_2_percent"]}, alarm before the squeal in '
                f'{hits["alarm_first"]}, both in {hits["both"]}')

    def as_json(self) -> dict[str, Any]:
        """Return all of it as plain data; NaN: not known."""
        return {
            'format': FORMAT, 'recordings': list(self.recordings),
            'measured': [str(one.path) for one in self.listenings], 'unit': self.unit,
            'groups': [list(group) for group in self.matches.groups],
            'counts': self.counts, 'hits': self.hits, 'scores': self.scores.as_json(),
            'frequency': self._frequency(), 'lead_time': self._lead_time(),
            'applications': [_as_json(one) for one in self.matches.applications],
            'events_in_no_application': [
                {'time_s': one.time, 'frequency_hz': one.frequency_hz, 'brake': one.place}
                for one in self.matches.unmatched],
            'notes': list(self.notes)}

    def _frequency(self) -> dict[str, Any]:
        errors = np.array([error for _, error in self.frequency_errors])
        known = np.abs(errors[~np.isnan(errors)])
        return {'events': errors.size, 'with_unstable_mode': known.size,
                'median_relative_error': float(np.median(known)) if known.size else math.nan,
                'largest_relative_error': float(known.max()) if known.size else math.nan,
                'within_2_percent': int((known <= SAME_PITCH).sum())}

    def _lead_time(self) -> dict[str, Any]:
        times = self.lead_times
        return {'hits': len(times), **dict(zip(
            ('least_s', 'median_s', 'largest_s'),
            np.quantile(times, (0.0, 0.5, 1.0)).tolist() if times else [math.nan] * 3,
            strict=True)), 'alarm_first': sum(time > 0.0 for time in times)}

    def lines(self) -> list[str]:
        """Return the comparison as text, unknown results first."""
        counts, matches = self.counts, self.matches
        unknown = Counter(one.why for one in matches.applications if one.outcome == 'not known')
        return [
            *(f'note: {text}' for text in self.notes),
            f'{counted(sum(counts.values()), "brake application")} ({self._of_what()}) in '
            f'{counted(len(self.recordings), "recording")}; not known: {counts["not known"]}'
            + ''.join(f'; {number}: {why}' for why, number in unknown.most_common()),
            ', '.join(f'{number} {_plural(outcome, number)}' for outcome, number in counts.items()
                      if outcome != 'not known'),
            *self._hit_lines(), *self._pitch_lines(), *self._lead_lines(), *self.scores.lines(),
            *self._application_lines()]

    def _of_what(self) -> str:
        return {'brake': 'of one brake each', 'vehicle': 'of the vehicle: the events name no '
                'brakes'}.get(self.unit, 'of ' + ', '.join(map('+'.join, self.matches.groups)))

    def _hit_lines(self) -> list[str]:
        words = self.hits_in_words()
        return [f'{words} ({HIT_ALONE})'] if words else []

    def _pitch_lines(self) -> list[str]:
        result = self._frequency()
        if not result['events']:
            return []
        if not result['with_unstable_mode']:
            return [f'pitch: no unstable mode was predicted at any of {result["events"]} events']
        none = result['events'] - result['with_unstable_mode']
        return ['pitch: nearest predicted unstable mode off by '
                f'{result["median_relative_error"]:.1%} (median), '
                f'{result["largest_relative_error"]:.1%} at most; within {SAME_PITCH:.0%} at '
                f'{result["within_2_percent"]} of {result["events"]} events, none predicted at '
                f'{none}']

    def _lead_lines(self) -> list[str]:
        words = self.lead_in_words()
        return [f'alarm: {words}'] if words else []

    def lead_in_words(self) -> str:
        """Return the lead time of alarms before squeal, in words; empty where not known."""
        result = self._lead_time()
        if not result['hits']:
            return ''
        ends = [ahead_or_late(result[f'{name}_s']) for name in ('least', 'median', 'largest')]
        spread = f' (median; {ends[0]} to {ends[2]})' if result['hits'] > 1 else ''
        return (f'{ends[1]}{spread}, before the squeal in {result["alarm_first"]} of '
                f'{counted(result["hits"], "hit")}')

    def _application_lines(self) -> list[str]:
        shown = [one for one in self.matches.applications
                 if one.outcome in ('hit', 'miss', 'false alarm')]
        lines = [_in_words(one) for one in shown[:_SHOWN]]
        return lines + [f'  and {len(shown) - _SHOWN} more'] * (len(shown) > _SHOWN)


def compare(results: Sequence[Predictions],
            measured: str | Path | Sequence[str | Path]) -> Comparison:
    """
    Compare the squeal that replays predicted with the squeal that was measured.

    Parameters
    ----------
    results : sequence of ReplayResult
        One a recording.
    measured : path or sequence of paths
        Tables as `squeal listen` writes them, with the JSON beside them where it is there; on the
        clocks of the recordings.

    Returns
    -------
    Comparison

    Raises
    ------
    EventFileError, MeasuredSquealError
        For a table that cannot be used, or that is of another time than all recordings.

    """
    names = [result.name for result in results]
    for name in names:
        if names.count(name) > 1:
            raise MeasuredSquealError(name, f'{names.count(name)} results are of a recording of '
                                      'this name', 'give one result of each recording')
    brakes, axles = _brakes(results)
    places = event_places(brakes, axles)
    listenings = read_listenings(measured, places)
    notes = check_clocks(results, listenings)
    matches = match(results, listenings, brakes, places)
    if matches.unmatched:
        notes.append(f'{len(matches.unmatched)} of {sum(len(one.events) for one in listenings)} '
                     'events are in no brake application of their brake, the first at '
                     f'{time_in_words(matches.unmatched[0].time)}')
    return Comparison(tuple(names), tuple(listenings), matches,
                      score_predictions(scored(matches.applications)), tuple(notes))


def _brakes(results: Sequence[Predictions]) -> tuple[list[str], tuple[str, ...]]:
    """Return the brakes of the results in order, and the axles of the settings."""
    found: dict[str, None] = {}
    axles: tuple[str, ...] = ('auto',)
    for result in results:
        inputs: Any = result.summary.get('inputs') or ()
        found |= dict.fromkeys([*(one['brake'] for one in inputs),
                                *(one.brake for one in result.applications)])
        try:
            axles = tuple(json.loads(_settings(result))['axles'])
        except (ValueError, KeyError, TypeError):
            continue  # settings written otherwise: axles by the names of the brakes
    return list(found), axles


def _settings(result: Predictions) -> Any:
    settings: Any = result.summary.get('settings') or {}
    return settings.get('yaml') or ''


def _as_json(one: MatchedApplication) -> dict[str, Any]:
    braking, worst = one.braking, one.braking.worst
    return {
        'recording': braking.recording, 'brakes': list(braking.brakes), 'start_s': braking.start,
        'end_s': braking.end, 'outcome': one.outcome, 'why_not_known': one.why,
        'alarm': braking.alarm, 'peak_risk': braking.risk,
        'predicted_frequency_hz': worst.frequency_hz, 'pressure_pa': worst.pressure_pa,
        'rotor_speed_rad_s': worst.rotor_speed_rad_s, 'temperature_k': worst.temperature_k,
        'lead_time_s': one.lead_time,
        'measured': [{'time_s': event.time, 'end_s': event.end, 'brake': event.place,
                      'frequency_hz': event.frequency_hz, 'level_db': event.level_db,
                      'nearest_unstable_mode_off_by_hz': error}
                     for event, error in zip(one.events, one.frequency_errors, strict=True)]}


def _in_words(one: MatchedApplication) -> str:
    braking = one.braking
    parts = [f'  {one.outcome}: {braking.recording}, {"+".join(braking.brakes)}, '
             f'{braking.start:.1f} to {braking.end:.1f} s, risk up to '
             f'{risk_in_words(braking.risk)}']
    if one.events:
        pitches = ['no known pitch' if math.isnan(event.frequency_hz) else
                   f'{event.frequency_hz:.0f} Hz' for event in one.events]
        parts.append('measured ' + ', '.join(pitches[:4]) + ' ...' * (len(pitches) > 4))
    known = [error for error in one.frequency_errors if not math.isnan(error)]
    if known:
        parts.append(f'nearest unstable mode off by {min(known, key=abs):+.0f} Hz')
    if not math.isnan(one.lead_time):
        parts.append(f'alarm {ahead_or_late(one.lead_time)}')
    return ', '.join(parts)


def ahead_or_late(lead_time: float) -> str:
    """Return a lead time [s] in words."""
    return f'{abs(lead_time):.2f} s {"ahead" if lead_time >= 0.0 else "late"}'


def _plural(outcome: str, number: int) -> str:
    plurals = {'hit': 'hits', 'miss': 'misses', 'false alarm': 'false alarms',
               'correct silence': 'correct silences'}
    return outcome if number == 1 else plurals[outcome]

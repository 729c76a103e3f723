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

"""Sections "Summary", "Differences" and "Data quality" of the page, as tables."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
import json
import math
from typing import Any

import numpy as np
from squeal_core.view.report.application_shares import Alarms, difference
from squeal_core.view.report.charts import DECIBELS, KELVIN
from squeal_core.view.report.markup import Content, element, Markup, table
from squeal_core.view.report.runs import end_of, Located, Run, start_of
from squeal_core.view.report.words import (
    clock,
    DASH,
    duration,
    number,
    percent,
    percent_down,
    risk,
)

_WORST_EVENTS = 10
_MOST_CHANGES = 40  # lines of settings


def summary_section(run: Run) -> list[Markup]:
    """Return the predicted squeal of a run by brake, and the worst events."""
    return [_applications(run), *_worst_events(run)]


def _alarms(run: Run, brake: str = '') -> Alarms:
    own = [(bool(one.alarm), number) for one, number in zip(
        run.known, run.known_brakings.tolist(), strict=True) if brake in ('', one.brake)]
    return Alarms(sum(hit for hit, _ in own), len(own), len({number for _, number in own}))


def share_words(alarms: Alarms) -> str:
    """Return the share of applications with predicted squeal, with its 95 % interval."""
    if not alarms.known:
        return 'not known'
    share, low, high = alarms.share
    return f'{percent(share)} ({100 * low:.0f} to {100 * high:.0f} %)'


def _applications(run: Run) -> Markup:
    def row(name: str, brake: str) -> list[Content]:
        own = [one.record for one in run.applications if brake in ('', one.record.brake)]
        alarms = _alarms(run, brake)
        risks = [one.peak_risk for one in own if math.isfinite(one.peak_risk)]
        return [name, str(len(own)), str(alarms.known), str(alarms.hits) if alarms.known else DASH,
                share_words(alarms), risk(max(risks, default=math.nan)),
                risk(float(np.median(risks)) if risks else math.nan)]

    return table(
        ('brake', 'applications', 'known', 'squeal predicted', 'share of known (95 %)',
         'largest risk', 'median of largest risks'),
        [row('all', ''), *(row(brake, brake) for brake in run.brakes)],
        caption='Brake applications')


def _worst_events(run: Run) -> Iterator[Markup]:
    if run.nothing_known:
        yield element('p', 'Squeal events: not known.')
        return
    if not run.events:
        yield element('p', 'No squeal event is predicted while the squeal risk was known.')
        return
    count, several = len(run.events), len(run.results) > 1
    place = any(math.isfinite(at.record.latitude_deg) for at in run.events)
    columns = [column for column in _EVENT if (column[0] != 'recording' or several)
               and (column[0] != 'position' or place)]
    yield table([name for name, _ in columns],
                [[words(run, at) for _, words in columns] for at in run.events[:_WORST_EVENTS]],
                numbers_from=3 if several else 2, caption=_of_events(count))
    if any(at.record.growth_rate_1_s <= 0.0 for at in run.events[:_WORST_EVENTS]):
        yield element('p', 'Events of a growth below 0 and the mechanism stable: the mode of the '
                      'nominal brake is stable there; the risk is of those brakes of the ensemble '
                      'in which it grows.')


def _of_events(count: int) -> str:
    """Return the caption of the table of events, with the meaning of its risks and times."""
    words = 'The predicted squeal event' if count == 1 else (
        f'The worst {_WORST_EVENTS} of {count} predicted squeal events, by risk'
        if count > _WORST_EVENTS else f'{count} predicted squeal events, worst first, by risk')
    return (f'{words}. Risk: the largest at its ticks; that of a brake application, above, '
            'includes the last half tick and may be larger. An event lasts until its alarm is '
            'over, so it may end after the braking (risk_hold)')


_EVENT: tuple[tuple[str, Callable[[Run, Located], str]], ...] = (
    ('start', lambda run, at: clock(at.record.start_s)),
    ('recording', lambda run, at: run.results[at.recording].name),
    ('brake', lambda run, at: at.record.brake),
    ('duration s', lambda run, at: f'{at.record.end_s - at.record.start_s:.1f}'),
    ('frequency Hz', lambda run, at: number(at.record.frequency_hz, '.0f')),
    ('mode', lambda run, at: str(at.record.mode_number or DASH)),
    ('growth 1/s', lambda run, at: number(at.record.growth_rate_1_s, '+.1f')),
    ('build-up dB', lambda run, at: number(DECIBELS * at.record.build_up_nepers)),
    ('risk', lambda run, at: risk(at.record.peak_risk)),
    ('speed rad/s', lambda run, at: number(at.record.rotor_speed_rad_s)),
    ('pressure bar', lambda run, at: number(at.record.pressure_pa / 1e5)),
    ('friction', lambda run, at: number(at.record.friction, '.3f')),
    ('temperature °C', lambda run, at: number(at.record.temperature_k - KELVIN, '.0f')),
    ('mechanism', lambda run, at: at.record.mechanism or DASH),
    ('position', lambda run, at: f'{number(at.record.latitude_deg, ".5f")}, '
                                 f'{number(at.record.longitude_deg, ".5f")}'))


def differences_section(runs: Sequence[Run]) -> list[Markup]:
    """Return the differences of further runs from the first: figures, models, settings."""
    return [*_stretches(runs), _figures(runs), *_versions(runs)]


def _stretches(runs: Sequence[Run]) -> Iterator[Markup]:
    """Yield a warning for each run of other recordings than the first, or other parts of them."""
    first = _parts(runs[0])
    for run in runs[1:]:
        own = _parts(run)
        if own == first:
            continue
        other = [f'{key[0]} from {" to ".join(map(clock, own[key]))}, and not from '
                 f'{" to ".join(map(clock, first[key]))}'
                 for key in own if key in first and own[key] != first[key]]
        yield element('p', f'{run.name} and {runs[0].name} are not of the same drive: {run.name} '
                      f'has {other[0] if other else "other recordings"}. Shares may differ for '
                      'that alone; to compare models or settings replay the same stretch of the '
                      'same recordings.', class_='warning')


def _parts(run: Run) -> dict[tuple[str, str], tuple[float, float]]:
    """Return the ends of the stretch [s] of each recording, by its name and hash."""
    return {(result.name, str(result.summary['recording'].get('sha256'))): (
        round(start_of(result), 1), round(end_of(result), 1)) for result in run.results}


_FIGURES: tuple[tuple[str, Callable[[Run], float], Callable[[float], str]], ...] = (
    ('recordings', lambda run: len(run.results), lambda value: f'{value:.0f}'),
    ('braking time', lambda run: run.total('braking_s'), duration),
    ('risk known, share of braking time', lambda run: run.known_share, percent_down),
    ('brake applications', lambda run: len(run.applications), lambda value: f'{value:.0f}'),
    ('of these known', lambda run: len(run.known), lambda value: f'{value:.0f}'),
    ('largest risk', lambda run: _quantile(run, 'peak_risk', 1.0), risk),
    ('median of the largest risks', lambda run: _quantile(run, 'peak_risk', 0.5), risk),
    ('90 % of build-ups are below',
     lambda run: DECIBELS * _quantile(run, 'build_up_nepers', 0.9),
     lambda value: f'{number(value)} dB'),
    ('median frequency of predicted squeal', lambda run: _median_frequency(run),
     lambda value: f'{number(value, ".0f")} Hz'))


def _quantile(run: Run, name: str, at: float) -> float:
    values = [getattr(one, name) for one in run.known if math.isfinite(getattr(one, name))]
    return float(np.quantile(values, at)) if values else math.nan


def _median_frequency(run: Run) -> float:
    values = [one.frequency_hz for one in run.squealing if math.isfinite(one.frequency_hz)]
    return float(np.median(values)) if values else math.nan


def _figures(runs: Sequence[Run]) -> Markup:
    first, *others = runs
    rows: list[list[Content]] = [[
        'applications with predicted squeal', share_words(_alarms(first)),
        *(cell for run in others for cell in (share_words(_alarms(run)), _change(first, run)))]]
    for name, value, words in _FIGURES:
        own = value(first)
        rows.append([name, words(own), *(cell for run in others for cell in (
            words(value(run)), _signed(value(run) - own, words)))])
    return table(('', first.name, *(cell for run in others for cell in (
        run.name, f'{run.name} minus {first.name}'))), rows)


def _change(first: Run, run: Run) -> Content:
    """Return the difference of the shares, and whether it is more than chance."""
    if not (first.known and run.known):
        return 'not known'
    change, low, high = (100.0 * value for value in difference(_alarms(first), _alarms(run)))
    words = f'{change:+.1f} points ({low:+.1f} to {high:+.1f})'
    return element('strong', words) if low > 0.0 or high < 0.0 else (
        f'{words}, within what chance makes of it')


def _signed(change: float, words: Callable[[float], str]) -> str:
    if not math.isfinite(change):
        return DASH
    return f'{"−" if change < 0.0 else "+"}{words(abs(change))}' if change else 'equal'


def _versions(runs: Sequence[Run]) -> Iterator[Markup]:
    """Yield the models, tables and settings that differ, and the lines that do."""
    first = runs[0].results[0].summary
    for run in runs[1:]:
        other = run.results[0].summary
        changed = [kind for kind in ('model', 'table', 'emulator', 'calibration', 'software')
                   if _identity(first.get(kind)) != _identity(other.get(kind))]
        words = f'{run.name} against {runs[0].name}: ' + (
            f'different {", ".join(changed)}' if changed else
            'same model, table, emulator, calibration and software')
        lines = _changes(_settings(first), _settings(other))
        yield element('p', words + ('; settings differ:' if lines else '; same settings.'))
        if lines:
            more = [f'and {len(lines) - _MOST_CHANGES} more'] if len(lines) > _MOST_CHANGES else []
            yield element('pre', '\n'.join([*lines[:_MOST_CHANGES], *more]))


def _settings(summary: Mapping[str, Any]) -> dict[str, str]:
    """Return the settings one a line, by the path of their key."""
    try:
        return dict(_leaves('', json.loads(summary['settings']['yaml'])))
    except ValueError:  # not written as JSON: lines are compared as they are
        return dict.fromkeys(summary['settings']['yaml'].splitlines(), '')


def _leaves(path: str, value: Any) -> Iterator[tuple[str, str]]:
    items = value.items() if isinstance(value, dict) else (
        ((one.get('name', place) if isinstance(one, dict) else place, one)
         for place, one in enumerate(value)) if isinstance(value, list) else None)
    if items is None:
        yield path, json.dumps(value)
    else:
        for key, one in items:
            yield from _leaves(f'{path}.{key}' if path else str(key), one)


def _changes(first: Mapping[str, str], other: Mapping[str, str]) -> list[str]:
    return [f'{key}: {first.get(key, "not set")} -> {other.get(key, "not set")}'
            for key in dict.fromkeys([*first, *other]) if first.get(key) != other.get(key)]


def _identity(about: Any) -> Any:
    return about.get('sha256', about) if isinstance(about, dict) else about


def quality_section(run: Run) -> list[Markup]:
    """Return the quality of each input over all recordings of a run."""
    inputs: dict[tuple[str, ...], list[Mapping[str, Any]]] = {}
    for result in run.results:
        for one in result.summary.get('inputs') or ():
            key = tuple(str(one[name]) for name in ('brake', 'signal', 'source', 'unit'))
            inputs.setdefault(key, []).append(one)
    if not inputs:
        return [element('p', 'Not known: the results hold no figures of their inputs.')]
    return [table(('brake', 'input', 'source', 'evaluated in', 'recordings', 'messages',
                   'least rate Hz', 'gaps', 'longest gap s', 'stale s', 'invalid s',
                   'invalid, by reason'),
                  [_quality(key, found) for key, found in inputs.items()], numbers_from=4)]


def _quality(key: tuple[str, ...], result: Sequence[Mapping[str, Any]]) -> list[Content]:
    invalid: Counter[str] = Counter()
    for one in result:
        invalid.update(one.get('invalid_s') or {})

    def of(name: str) -> list[float]:
        return [value for one in result if (value := one.get(name)) is not None]

    return [*key, str(len(result)), f'{sum(of("messages")):.0f}',
            number(min(of('rate_hz'), default=math.nan)), f'{sum(of("gaps")):.0f}',
            number(max(of('longest_gap_s'), default=math.nan), '.2f'),
            number(sum(of('stale_s'))), number(sum(invalid.values())),
            ', '.join(f'{reason}: {seconds:.1f} s' for reason, seconds in invalid.most_common())
            or DASH]

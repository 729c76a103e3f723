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

"""Section "What is known" of the page: it comes first, so that no chart reads like silence."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from squeal_core.common.wording import counted
from squeal_core.monitor.results.result_files import ReplayResult, SOURCE_FILES
from squeal_core.risk.ensemble import MOSTLY_PRIOR, NOT_CALIBRATED
from squeal_core.view.report.markup import Content, element, Markup, prose, table
from squeal_core.view.report.runs import end_of, Run, start_of
from squeal_core.view.report.words import clock, DASH, duration, percent_down

_MOST_LINES = 12


def known_section(run: Run) -> list[Markup]:
    """Return the section on known risk: how much of the braking, which recordings, its basis."""
    return [*_warnings(run), element('p', _headline(run), class_='headline'),
            *risk_bases(one.summary for one in run.results), _recordings(run), *_reasons(run),
            *_notes(run), _versions(run)]


def _headline(run: Run) -> str:
    braking, count = run.total('braking_s'), len(run.results)
    where = f'{counted(count, "recording")}, {duration(sum(map(_length, run.results)))}'
    if not braking:
        return f'No braking in {where}, so there is nothing to assess.'
    never = sorted({brake for one in run.results
                    for brake in one.summary['report']['never_known']})
    return (f'Squeal risk known for {percent_down(run.known_share)} of the braking time '
            f'({run.total("risk_known_s"):.1f} of {braking:.1f} s of all brakes) in {where}; '
            f'assessed {percent_down(run.total("assessed_s") / braking)}.'
            + (f' Never known in some recording: {", ".join(never)}.' if never else ''))


def risk_bases(summaries: Iterable[Mapping[str, Any]]) -> Iterator[Markup]:
    """Yield the basis of the level of the squeal risk."""
    bases = [one.get('risk_basis') or ('' if one.get('calibration') else NOT_CALIBRATED)
             for one in summaries]
    for basis in filter(None, dict.fromkeys(bases)):
        yield element('p', f'Squeal risk: {basis}.' + (
            ' Its changes over a drive say more than its level.'
            if MOSTLY_PRIOR in basis else ''))


def _warnings(run: Run) -> Iterator[Markup]:
    if run.nothing_known:
        yield element('p', 'Nothing is known of squeal in this run: the squeal risk was never '
                      'known while a brake was used. Empty charts below are no silence.',
                      class_='warning', role='alert')
    partial = [one.name for one in run.results if one.summary.get('partial')]
    if partial:
        yield element('p', 'Replayed in part only, as the replay was interrupted: '
                      f'{", ".join(partial)}.', class_='warning')
    different = {_model(one) for one in run.results}
    if len(different) > 1:
        yield element('p', f'These recordings were replayed with {len(different)} different '
                      'models or settings.', class_='warning')


def _model(result: ReplayResult) -> tuple[Any, ...]:
    return tuple((result.summary.get(kind) or {}).get('sha256')
                 for kind in (*SOURCE_FILES, 'settings'))


def _length(result: ReplayResult) -> float:
    return end_of(result) - start_of(result)


def _recordings(run: Run) -> Markup:
    def row(one: ReplayResult) -> list[Content]:
        report, recording = one.summary['report'], one.summary['recording']
        braking = report['braking_s']
        never = report['never_known']
        return [one.name, str(recording.get('kind', '')), clock(start_of(one)),
                duration(_length(one)), f'{braking:.1f} s', DASH if not braking else percent_down(
                    report['assessed_s'] / braking),
                DASH if not braking else percent_down(report['risk_known_s'] / braking),
                ', '.join(never) or DASH, short_hash(recording.get('sha256'))]

    return table(('recording', 'kind', 'start', 'duration', 'braking time', 'assessed',
                  'risk known', 'never known', 'SHA-256'), map(row, run.results),
                 numbers_from=3)


def _reasons(run: Run) -> Iterator[Markup]:
    """Yield the reasons for unknown risk, by braking time."""
    result: dict[tuple[str, str, str], float] = {}
    for one in run.results:
        rate = float(one.summary['rate_hz'])
        for brake, about in one.summary['report']['brakes'].items():
            for reason in about['reasons']:
                key = brake, str(reason['state']), f'{reason["text"]}; {reason["remedy"]}'
                result[key] = result.get(key, 0.0) + reason['braking_ticks'] / rate
    ranked = sorted(((seconds, *key) for key, seconds in result.items()), reverse=True)
    rows = [(brake, f'{seconds:.1f} s', state, *map(prose, text.rpartition('; ')[::2]))
            for seconds, brake, state, text in ranked if seconds > 0.0]
    if rows:
        yield table(('brake', 'braking time', 'state', 'why not known, at first', 'remedy'),
                    rows[:_MOST_LINES], caption='Not known, and why', numbers_from=9)
    if len(rows) > _MOST_LINES:
        yield element('p', f'{len(rows) - _MOST_LINES} more reasons are in the summaries.')


def _notes(run: Run) -> Iterator[Markup]:
    lines = dict.fromkeys(
        text for one in run.results for text in (
            *(f'{finding["what"]}; {finding["remedy"]}'
              for finding in one.summary['report']['findings']),
            *one.summary['report']['notes']))
    if lines:
        yield element('ul', [element('li', prose(line)) for line in list(lines)[:_MOST_LINES]])


def _versions(run: Run) -> Markup:
    """Return the table of model, settings and software, with names and hashes."""
    rows: dict[tuple[str, str, str], None] = {}
    for summary in (one.summary for one in run.results):
        rows |= dict.fromkeys(source_rows(summary))
        rows['settings', f'{summary["rate_hz"]:g} Hz',
             str(summary['settings'].get('sha256'))] = None
        rows['software', ', '.join(f'{name} {version}' for name, version
                                   in summary['software'].items()), DASH] = None
    return table(('', 'name', 'SHA-256'), rows, caption='Model, settings and software',
                 numbers_from=9)


def source_rows(sources: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Yield kind, name and SHA-256 of the files that results rest on."""
    for kind in SOURCE_FILES:
        about = sources.get(kind) or {}
        yield (kind, str(about.get('name') or Path(about.get('path') or 'none').name),
               str(about.get('sha256') or DASH))


def short_hash(value: Any) -> Markup:
    """Return the first digits of a hash, with all of it as a title."""
    text = str(value or DASH)
    return element('span', text[:12], title=text)

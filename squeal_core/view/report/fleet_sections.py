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


"""Tables of the page of a fleet: what is known, groups, operating regions, recordings."""

from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import quote

from squeal_core.common.wording import counted
from squeal_core.view.report.fleet_charts import known_regions, region_words
from squeal_core.view.report.fleet_groups import FleetData, Group, Row
from squeal_core.view.report.known import risk_bases, short_hash, source_rows
from squeal_core.view.report.markup import Content, element, Markup, prose, table
from squeal_core.view.report.summary import share_words
from squeal_core.view.report.words import DASH, duration, number, percent, risk

MOST_ROWS = 50  # of a table; the CSV files have all
_MOST_RECORDINGS = 500
_MOST_REASONS = 12
_COLUMNS = ('braking time', 'risk not known', 'applications', 'known', 'squeal predicted',
            'share of known (95 %)', 'largest risk')


def known_section(data: FleetData) -> Iterator[Markup]:
    """Yield the section on known risk: fraction of the braking, failures, reasons."""
    total, manifest = data.total, data.folder.manifest
    if manifest.get('partial'):
        yield element('p', f'In part only: {manifest["partial"]}.', class_='warning')
    for key, what in (('failed', 'could not be evaluated'), ('not_reached', 'were not reached')):
        if count := manifest[f'recordings_{key}']:
            yield element('p', f'{count} of {manifest["recordings_found"]} recordings {what}; '
                          'nothing below counts them.', class_='warning')
    if total.braking_s and not total.risk_known_s:
        yield element('p', 'Nothing is known of squeal in this fleet: the squeal risk was never '
                      'known while a brake was used. Empty charts below are no silence.',
                      class_='warning', role='alert')
    yield element('p', _headline(data), class_='headline')
    yield from risk_bases([manifest['sources']])
    yield element('p', ' '.join(_counting(manifest)))
    yield from _failures(data)
    yield from _notes(data)
    yield from _reasons(data)
    yield _sources(manifest)


def _headline(data: FleetData) -> str:
    total = data.total
    vehicles = len([name for name in data.vehicles if name])
    where = (counted(total.recordings, 'recording')
             + (f' of {counted(vehicles, "vehicle")}' if vehicles else '')
             + f', {duration(sum(one.duration_s for _, one in data.recordings))}')
    if not total.braking_s:
        return f'No braking in {where}, so there is nothing to assess.'
    unknown = round(total.braking_s - total.risk_known_s, 6)
    return ((f'Squeal risk not known for {percent(total.unknown_share)} of the braking time '
             f'({unknown:.1f} of {total.braking_s:.1f} s of all brakes) in {where}' if unknown else
             f'Squeal risk known for all of the braking time ({total.braking_s:.1f} s of all '
             f'brakes) in {where}')
            + f'; of {counted(total.known, "known brake application")} {total.alarms} with '
              'predicted squeal.')


def _failures(data: FleetData) -> Iterator[Markup]:
    rows = [(label.recording, label.vehicle or DASH, failure.error)
            for label, failure in data.folder.rows('failures') if failure.reached]
    if rows:
        yield table(('recording', 'vehicle', 'why'), rows[:MOST_ROWS], numbers_from=9,
                    caption='Not evaluated, and why')
        yield from _more(len(rows), MOST_ROWS, 'failures')


def _counting(manifest: Mapping[str, Any]) -> Iterator[str]:
    """Yield notes on counting and on confidence intervals."""
    if copies := manifest['recordings_copied']:
        yield f'Copies of other recordings, which count once: {copies}.'
    yield ('Intervals (95 %) take as many independent trials as there were brakings of a vehicle: '
           'brakes that are applied at once count once. One over several vehicles holds for '
           'these, not for others.')


def _notes(data: FleetData) -> Iterator[Markup]:
    """Yield notes on data lost or assumed as recordings were read."""
    rows = [(label.recording, label.vehicle or DASH, one.notes)
            for label, one in data.recordings if one.notes]
    if rows:
        yield element('p', f'{len(rows)} of {len(data.recordings)} recordings have notes, as of '
                      'parts that are damaged and lost.', class_='warning')
        yield table(('recording', 'vehicle', 'notes'), rows[:MOST_ROWS], numbers_from=9,
                    caption='Lost or supposed as recordings were read')
        yield from _more(len(rows), MOST_ROWS, 'recordings')


def _more(count: int, most: int, name: str) -> Iterator[Markup]:
    if count > most:
        yield element('p', f'{count - most} more are in {name}.csv.')


def _reasons(data: FleetData) -> Iterator[Markup]:
    """Yield the reasons for unknown risk, by braking time: the main one of each recording."""
    result: dict[str, tuple[float, int, str]] = {}
    for _, one in data.recordings:
        unknown = one.braking_s - one.risk_known_s
        if unknown > 0.0:
            text, _, remedy = one.why_not_known.rpartition('; ')
            seconds, count, first = result.get(remedy, (0.0, 0, text or remedy or DASH))
            result[remedy] = seconds + unknown, count + 1, first
    rows = [(duration(seconds), str(count), prose(first), prose(remedy or DASH))
            for remedy, (seconds, count, first) in sorted(
                result.items(), key=lambda item: item[1], reverse=True)]
    if rows:
        yield table(('braking time not known', 'recordings', 'main reason, at first', 'remedy'),
                    rows[:_MOST_REASONS], numbers_from=9, caption='Not known, and why')


def _sources(manifest: Mapping[str, Any]) -> Markup:
    sources = manifest['sources']
    rows: list[tuple[Content, ...]] = [
        (kind, name, short_hash(digest)) for kind, name, digest in source_rows(sources)]
    settings, software = sources.get('settings') or {}, sources.get('software') or {}
    rows.append(('settings', f'{sources.get("rate_hz")} Hz', short_hash(settings.get('sha256'))))
    rows.append(('software', ', '.join(f'{name} {one}' for name, one in software.items()), DASH))
    return table(('', 'name', 'SHA-256'), rows, caption='Model, settings and software',
                 numbers_from=9)


def group_table(groups: Mapping[str, Group], what: str, file: str) -> Iterator[Markup]:
    """
    Yield the table of groups.

    Parameters
    ----------
    groups : mapping
        By name, in the order of the rows.
    what : str
        Heading of the first column.
    file : str
        Name of the table in which all of them are.

    """
    rows: list[list[Content]] = [[name or 'not known', str(one.recordings), *_figures(one)]
                                 for name, one in list(groups.items())[:MOST_ROWS]]
    yield table((what, 'recordings', *_COLUMNS), rows)
    yield from _more(len(groups), MOST_ROWS, file)


def _figures(one: Group) -> list[Content]:
    return [duration(one.braking_s), percent(one.unknown_share), *_shares(one)]


def _shares(one: Group) -> list[Content]:
    return [str(one.applications), str(one.known), str(one.alarms) if one.known else DASH,
            share_words(one.known_alarms), risk(one.peak_risk)]


def region_table(data: FleetData) -> Iterator[Markup]:
    """Yield the operating regions with most predicted squeal."""
    worst = known_regions(data.regions)
    if not worst:
        yield element('p', 'No squeal is predicted in a brake application of which it is known.')
        return
    total = sum(one.alarms for _, one in worst)
    yield table(('pressure bar', 'speed rad/s', 'of all predicted squeal', *_COLUMNS[2:]), [
        [*region_words(at), percent(one.alarms / total), *_shares(one)]
        for at, one in worst[:10]], numbers_from=2,
        caption=f'{min(10, len(worst))} of {len(worst)} operating regions with predicted squeal. '
                'Largest risks are here of brake applications, which include the last half tick; '
                'elsewhere on this page of ticks')


def recordings_section(data: FleetData, pages: Mapping[str, str], how: str) -> Iterator[Markup]:
    """
    Yield the recordings, worst first, each with a link to its page.

    Parameters
    ----------
    data : FleetData
        Whose recordings they are.
    pages : mapping
        Where the page of a result is, relative to this one.
    how : str
        How the pages are made that are not there.

    """
    ranked = worst_first(data)
    yield table(('recording', 'vehicle', 'date', 'mileage km', 'duration', *_COLUMNS),
                [_recording(row, pages, data.brakings[row[0].recording])
                 for row in ranked[:_MOST_RECORDINGS]], numbers_from=2)
    yield from _more(len(ranked), _MOST_RECORDINGS, 'recordings')
    if any(one.result not in pages for _, one in ranked):
        yield element('p', how, class_='notice')


def worst_first(data: FleetData) -> list[Row]:
    """Return the recordings: those with most predicted squeal first, then by unknown time."""
    def key(row: Row) -> tuple[float, ...]:
        one = row[1]
        return (-one.applications_with_alarm, -one.peak_risk if one.peak_risk >= 0.0 else 1.0,
                one.risk_known_s - one.braking_s)

    return sorted(data.recordings, key=key)


def _recording(row: Row, pages: Mapping[str, str], brakings: int) -> list[Content]:
    label, one = row
    group = Group()
    group.add(one, brakings)
    page = pages.get(one.result)
    return [element('a', label.recording, href=quote(page)) if page else label.recording,
            label.vehicle or DASH, label.date or DASH, number(label.mileage_km, ',.0f'),
            duration(one.duration_s), *_figures(group)]

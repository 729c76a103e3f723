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


"""The tables of a fleet and their manifest, from the results of its recordings."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
import json
import math
from pathlib import Path
from typing import Any, NamedTuple

from squeal_core.common.errors import in_one_line
from squeal_core.common.json_values import plain
from squeal_core.common.output import OutputFiles
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.fleet_files import (
    FleetBrake,
    FleetFailure,
    FleetLabel,
    FleetRecording,
    FORMAT,
    MANIFEST,
    RECORDINGS,
    TABLES,
)
from squeal_core.monitor.results.record_tables import JoinedWriter, ResultError
from squeal_core.monitor.results.result_files import ReplayResult, TableFormat
from squeal_core.monitor.results.result_summary import file_hash
from squeal_core.monitor.results.squeal_events import clock_time
from squeal_ros.recordings.fleet.fleet_vehicles import VehicleRow

_TOTALS = ('duration_s', 'braking_s', 'assessed_s', 'risk_known_s', 'applications',
           'applications_known', 'applications_with_alarm', 'events')
_MOST_NOTES = 2_000  # characters


class Member(NamedTuple):
    """One recording of a fleet: its result, or the error and whether the run came to it."""

    name: str
    path: Path
    vehicle: VehicleRow
    digest: str = ''
    result: Path | None = None
    result_digest: str = ''
    error: str = ''
    reached: bool = True
    copy_of: str = ''


def write_tables(folder: Path, members: Sequence[Member], about: Mapping[str, Any],
                 formats: Sequence[TableFormat]) -> dict[str, Any]:
    """
    Write the tables and the manifest of a fleet, all or none; return the manifest.

    Parameters
    ----------
    folder : Path
        Of the fleet.
    members : sequence of Member
        In the order of the rows.
    about : mapping
        What else the manifest says.
    formats : sequence of str
        'csv', which is always written, and 'parquet'.

    """
    with OutputFiles(overwrite=True) as files:
        outputs = {(name, kind): files.add(folder / f'{name}.{kind}')
                   for name in TABLES for kind in dict.fromkeys(('csv', *formats))}
        manifest = files.add(folder / MANIFEST)  # is committed last
        with ExitStack() as stack:
            writers = {key: stack.enter_context(_writer(*key, output.partial))
                       for key, output in outputs.items()}
            rows, totals, failed = _write_rows(_with_originals(members), writers)
        reached = sum(failure.reached for _, failure in failed)
        content = {
            'format': FORMAT, 'recordings_found': len(members),
            'recordings_evaluated': rows[RECORDINGS], 'recordings_copied': rows['copies'],
            'recordings_failed': reached, 'recordings_not_reached': len(failed) - reached,
            'recordings_with_notes': rows['notes'], 'totals': totals, **about,
            'failures': [{'recording': label.recording, 'vehicle': label.vehicle,
                          **failure._asdict()} for label, failure in failed],
            'tables': {f'{name}.{kind}': {'rows': rows[name], 'sha256': file_hash(
                output.partial)[0]} for (name, kind), output in outputs.items()}}
        manifest.partial.write_text(json.dumps(plain(content), indent=1), encoding='utf-8')
    return content


def _writer(name: str, kind: TableFormat, path: Path) -> Any:
    kinds = (FleetLabel, TABLES[name])
    if kind == 'parquet':
        from squeal_core.monitor.results.parquet_table import ParquetWriter
        return ParquetWriter(path, kinds)
    return JoinedWriter(path, kinds)


def _with_originals(members: Iterable[Member]) -> Iterator[Member]:
    """Yield members, those with the content of an earlier one with its name."""
    first: dict[Path, str] = {}
    for one in members:
        original = first.setdefault(one.result, one.name) if one.result else one.name
        yield one if original == one.name else one._replace(copy_of=original)


def _write_rows(members: Iterable[Member], writers: Mapping[tuple[str, TableFormat], Any]
                ) -> tuple[Counter[str], dict[str, float], list[tuple[FleetLabel, FleetFailure]]]:
    """Write the rows of all recordings; return their numbers by table, totals and failures."""
    rows: Counter[str] = Counter()
    totals = dict.fromkeys(_TOTALS, 0)
    failed = []
    for member in members:
        label, records = _labelled(member)
        for name, record in records:
            rows[name] += 1
            if name == 'failures':
                failed.append((label, record))
            elif name == RECORDINGS:
                rows['copies'] += bool(record.copy_of)
                rows['notes'] += bool(record.notes)
            if name == RECORDINGS and not record.copy_of:
                totals = {key: total + getattr(record, key) for key, total in totals.items()}
            for (table, _), writer in writers.items():
                if table == name:
                    writer.write(label, record)
    braking = totals['braking_s']
    return rows, {**totals, 'risk_known_share': totals['risk_known_s'] / braking if braking
                  else math.nan}, failed


def _labelled(member: Member) -> tuple[FleetLabel, list[tuple[str, Any]]]:
    """Return the label of a recording, and the table and the record of each of its rows."""
    label = FleetLabel(member.name, member.vehicle.vehicle, '', member.vehicle.mileage_km)
    error = member.error
    if member.result is not None:
        try:
            result = ReplayResult.load(member.result)
            start = float(result.summary['recording']['start_s'])
            return label._replace(date=clock_time(start)[:10]), [*_records(member, result)]
        except (ResultError, KeyError, TypeError, ValueError) as wrong:
            error = f'{wrong}; remove {member.result} and run this again'
    return label, [('failures', FleetFailure(str(member.path), error, member.reached))]


def _records(member: Member, result: ReplayResult) -> Iterator[tuple[str, Any]]:
    assert member.result is not None
    report, about = result.summary['report'], result.summary['recording']
    brakes = [_brake(result, name, own) for name, own in report['brakes'].items()]
    yield RECORDINGS, FleetRecording(
        path=str(member.path), sha256=member.digest,
        result=f'{RECORDINGS}/{member.result.name}', result_sha256=member.result_digest,
        kind=str(about['kind']), start_s=float(about['start_s']), end_s=float(about['end_s']),
        braking_s=report['braking_s'], assessed_s=report['assessed_s'],
        risk_known_s=report['risk_known_s'],
        **{key: sum(getattr(one, key) for one in brakes) for key in (
            'applications', 'applications_known', 'applications_with_alarm', 'events')},
        peak_risk=_largest([one.peak_risk for one in brakes]),
        never_known=' '.join(report['never_known']), why_not_known=_why(report),
        notes=in_one_line('; '.join(report['notes']), _MOST_NOTES), copy_of=member.copy_of)
    if member.copy_of:
        return
    yield from (('brakes', one) for one in brakes)
    yield from (('events', one) for one in result.events)
    yield from (('applications', one) for one in result.applications)


def _brake(result: ReplayResult, name: str, report: Mapping[str, Any]) -> FleetBrake:
    own: list[ApplicationRecord] = [one for one in result.applications if one.brake == name]
    share = report['risk_known_share']
    peak = report['peak_risk']
    return FleetBrake(
        name, report['braking_s'], report['assessed_s'],
        0.0 if share is None else share * report['braking_s'], len(own),
        sum(one.alarm is not None for one in own), sum(bool(one.alarm) for one in own),
        sum(one.brake == name for one in result.events), math.nan if peak is None else peak)


def _largest(values: Sequence[float]) -> float:
    return max((value for value in values if not math.isnan(value)), default=math.nan)


def _why(report: Mapping[str, Any]) -> str:
    reason = report['top_reason']
    if reason:
        return f'{reason["brake"]}: {reason["text"]}; {reason["remedy"]}'
    if report['risk_known_s'] < report['braking_s'] and report['findings']:
        first = report['findings'][0]
        return f'{first["what"]}; {first["remedy"]}'
    return ''

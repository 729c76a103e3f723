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


"""
The folder of results of a fleet: tables over all its recordings, a manifest, a result of each.

`fleet.json` is the manifest; `recordings.csv`, `brakes.csv`, `events.csv`, `applications.csv` and
`failures.csv` are the tables, and `recordings/KEY/` is the result of a recording, as
`squeal replay` writes it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
import json
import math
from pathlib import Path
from typing import Any, NamedTuple

from squeal_core.common.bounded_reader import read_text_bounded
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.history import MAX_BYTES
from squeal_core.monitor.results.record_tables import read_joined, ResultError
from squeal_core.monitor.results.squeal_events import SquealEvent

MANIFEST, RECORDINGS, FORMAT = 'fleet.json', 'recordings', 2
_MAX_MANIFEST = 500_000_000  # bytes
_REMEDY = 'give a folder that `squeal fleet` wrote, or write it again'


class FleetLabel(NamedTuple):
    """
    Origin of a row of any table of a fleet; empty and NaN: not known.

    Attributes
    ----------
    recording : str
        A name that no other recording of the fleet has.
    vehicle : str
    date : str
        Of the start of the recording, ISO 8601, UTC.
    mileage_km : float

    """

    recording: str
    vehicle: str = ''
    date: str = ''
    mileage_km: float = math.nan


class FleetRecording(NamedTuple):
    """
    One recording: a row of `recordings.csv`.

    Attributes
    ----------
    path : str
    sha256 : str
        Of its bytes.
    result, result_sha256 : str
        Folder of its result within that of the fleet, and SHA-256 of the files in it.
    kind : str
        Format of the recording.
    start_s, end_s : float
        On its clock.
    braking_s, assessed_s, risk_known_s : float
        Braking time of all brakes, and how much of it was assessed, and has a squeal risk.
    applications, applications_known, applications_with_alarm, events : int
        Brake applications, those of which squeal or silence is known, those with predicted squeal.
    peak_risk : float
    never_known : str
        Brakes that braked without a squeal risk that is known.
    why_not_known : str
        Why most of the unknown braking time is so, and the remedy.
    notes : str
        What was lost or supposed as it was read; empty: nothing.
    copy_of : str
        Recording with the same content, which alone counts and has rows in the other tables.

    """

    path: str
    sha256: str
    result: str
    result_sha256: str
    kind: str
    start_s: float
    end_s: float
    braking_s: float
    assessed_s: float
    risk_known_s: float
    applications: int
    applications_known: int
    applications_with_alarm: int
    events: int
    peak_risk: float
    never_known: str
    why_not_known: str
    notes: str
    copy_of: str

    @property
    def duration_s(self) -> float:
        """Time between the first and the last message."""
        return self.end_s - self.start_s


class FleetBrake(NamedTuple):
    """One brake of one recording: a row of `brakes.csv`; fields as of `FleetRecording`."""

    brake: str
    braking_s: float
    assessed_s: float
    risk_known_s: float
    applications: int
    applications_known: int
    applications_with_alarm: int
    events: int
    peak_risk: float


class FleetFailure(NamedTuple):
    """A recording without a result, why, and whether it failed or the run did not come to it."""

    path: str
    error: str
    reached: bool


TABLES: Mapping[str, Any] = {
    RECORDINGS: FleetRecording, 'brakes': FleetBrake, 'events': SquealEvent,
    'applications': ApplicationRecord, 'failures': FleetFailure}
"""Kind of the records of each table; a `FleetLabel` comes before each record."""


@dataclass(frozen=True, eq=False)
class FleetFolder:
    """
    A folder of results of a fleet.

    Parameters
    ----------
    path : Path
    manifest : dict
        docs/howto/fleet.md names the keys.

    """

    path: Path
    manifest: dict[str, Any]

    @classmethod
    def load(cls, path: str | Path) -> 'FleetFolder':
        """
        Read the manifest of a folder, given itself or by it.

        Raises
        ------
        ResultError
            With file, what is wrong and the remedy.

        """
        folder = Path(path) if Path(path).is_dir() else Path(path).parent
        file = folder / MANIFEST
        try:
            manifest = json.loads(read_text_bounded(file, _MAX_MANIFEST, ResultError))
        except (ValueError, RecursionError) as error:
            raise ResultError(file, f'is no JSON ({error})', _REMEDY) from None
        if not isinstance(manifest, dict) or manifest.get('format') != FORMAT or not all(
                isinstance(manifest.get(key), kind) for key, kind in _KEYS.items()):
            raise ResultError(file, f'is no manifest of a fleet, of format {FORMAT}', _REMEDY)
        return cls(folder, manifest)

    def rows(self, table: str) -> Iterator[tuple[FleetLabel, Any]]:
        """
        Return the rows of a table, one by one.

        Raises
        ------
        ResultError
            Naming file, line and what is wrong.

        """
        return read_joined(self.path / f'{table}.csv', (FleetLabel, TABLES[table]),
                           most_bytes=MAX_BYTES)


_KEYS = {'recordings_found': int, 'recordings_evaluated': int, 'recordings_failed': int,
         'recordings_not_reached': int, 'recordings_with_notes': int, 'recordings_copied': int,
         'tables': dict, 'sources': dict}


def is_fleet(path: str | Path) -> bool:
    """Return whether a path is a folder of results of a fleet, or its manifest."""
    at = Path(path)
    return (at / MANIFEST).is_file() or at.name == MANIFEST

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


"""Vehicle and mileage of a recording: by a table, else by the folder it is in."""

from collections.abc import Mapping, Sequence
import csv
from fnmatch import fnmatchcase
import math
import os
from pathlib import Path
from typing import NamedTuple

from squeal_core.common.bounded_reader import bounded_lines, open_bounded
from squeal_core.common.errors import did_you_mean
from squeal_ros.recordings.bags.split_bags import folder_of
from squeal_ros.recordings.fleet.fleet_task import FleetError

_COLUMNS = ('recording', 'vehicle', 'mileage_km')
_MAX_BYTES, _MAX_LINE = 100_000_000, 10_000


class VehicleRow(NamedTuple):
    """Vehicle and mileage [km] of the recordings that a pattern fits; '' and NaN: not known."""

    recording: str
    vehicle: str = ''
    mileage_km: float = math.nan


def read_vehicles(path: str | Path) -> list[VehicleRow]:
    """
    Return the rows of a table of vehicles: CSV with the columns recording, vehicle, mileage_km.

    Raises
    ------
    FleetError
        Naming file, line and what is wrong.

    """
    try:
        with open_bounded(path, _MAX_BYTES, FleetError) as file:
            reader = csv.DictReader(bounded_lines(file, _MAX_LINE, lambda line: FleetError(
                f'{path}, line {line}', f'has more than {_MAX_LINE} characters', 'shorten it')))
            names = [str(name).strip() for name in reader.fieldnames or ()]
            _check_columns(path, names)
            reader.fieldnames = names
            return [_row(f'{path}, line {reader.line_num}', row) for row in reader]
    except (UnicodeDecodeError, csv.Error) as error:
        raise FleetError(path, f'is no CSV in UTF-8 ({error})', 'save it as such') from None


def _check_columns(path: str | Path, names: Sequence[str]) -> None:
    wrong = [name for name in names if name not in _COLUMNS]
    if wrong or 'recording' not in names or len(set(names)) < len(names):
        raise FleetError(f'{path}, line 1', f'has the columns {", ".join(names) or "none"}',
                         f'give {", ".join(_COLUMNS)}; the first is needed'
                         f'{did_you_mean(wrong[0], _COLUMNS) if wrong else ""}')


def _row(where: str, row: Mapping[str | None, str | None]) -> VehicleRow:
    pattern, vehicle, text = ((row.get(name) or '').strip() for name in _COLUMNS)
    try:
        mileage = float(text or math.nan)
    except ValueError:
        mileage = -1.0
    if None in row or not pattern or mileage < 0.0 or math.isinf(mileage):
        raise FleetError(where, f'is {",".join(str(one) for one in row.values())[:80]}',
                         'give the name of a recording or a pattern, a vehicle, and a mileage of '
                         '0 km or more or nothing')
    return VehicleRow(pattern, vehicle, mileage)


def vehicles_of(recordings: Mapping[str, Path], rows: Sequence[VehicleRow],
                given: Sequence[Path] = ()) -> dict[str, VehicleRow]:
    """
    Return the vehicle of each recording by its name.

    A row counts whose `recording` is, or as a pattern fits, the name, the name of the file or
    the whole path; the first one. Without one, the vehicle is the folder within the one that all
    recordings have in common, if there is one; where they are all in one folder, it is that one,
    unless it was given itself.

    Parameters
    ----------
    recordings : mapping
        Absolute paths by name.
    rows : sequence of VehicleRow
        Of the table; none: without one.
    given : sequence of Path
        Absolute paths of the files and folders that were given.

    """
    places = {name: folder_of(path) for name, path in recordings.items()}
    common = Path(os.path.commonpath(places.values()))
    if common in places.values() and set(given) & {*common.parents}:
        common = common.parent
    result = {}
    for name, path in recordings.items():
        folders = places[name].relative_to(common).parts
        plain = VehicleRow(name, folders[0] if folders else '')
        row = next((row for row in rows if any(
            text == row.recording or fnmatchcase(text, row.recording)
            for text in (name, path.name, str(path)))), plain)
        result[name] = row if row.vehicle else row._replace(vehicle=plain.vehicle)
    return result

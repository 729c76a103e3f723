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


"""Data of a fleet's page from its tables: read once, kept by vehicle, brake, condition."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from datetime import date
from itertools import groupby
import math
from operator import itemgetter
from typing import NamedTuple, TypeAlias

import numpy as np
from squeal_core.calibration.scores import braking_numbers
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.fleet_files import (
    FleetBrake,
    FleetFolder,
    FleetLabel,
    FleetRecording,
)
from squeal_core.view.report.application_shares import Alarms

PRESSURE_STEP, SPEED_STEP = 5e5, 10.0  # Pa, rad/s: of operating regions
_MOST_CLASSES = 20  # of mileage or date
_DAYS = (1, 7, 28, 91, 364)

Row: TypeAlias = tuple[FleetLabel, FleetRecording]


@dataclass
class Group:
    """
    Brake applications that have something in common.

    Parameters
    ----------
    recordings : int
    braking_s, risk_known_s : float
        Braking time, and how much of it has a squeal risk.
    applications, known, alarms : int
        Brake applications, those of which squeal or silence is known, those with predicted squeal.
    brakings : int
        Brakings of the vehicles that known applications are of: brakes applied at once are one.
    peak_risk : float

    """

    recordings: int = 0
    braking_s: float = 0.0
    risk_known_s: float = 0.0
    applications: int = 0
    known: int = 0
    alarms: int = 0
    brakings: int = 0
    peak_risk: float = math.nan

    def add(self, one: FleetRecording | FleetBrake, brakings: int) -> None:
        """Take a recording, or a brake of one, and its brakings of which squeal is known."""
        self.recordings += 1
        self.braking_s += one.braking_s
        self.risk_known_s += one.risk_known_s
        self.applications += one.applications
        self.known += one.applications_known
        self.alarms += one.applications_with_alarm
        self.brakings += brakings
        self.raise_to(one.peak_risk)

    def apply(self, one: ApplicationRecord) -> None:
        """Take a single brake application; its braking is not counted."""
        self.applications += 1
        self.known += one.alarm is not None
        self.alarms += bool(one.alarm)
        self.raise_to(one.peak_risk)

    def raise_to(self, risk: float) -> None:
        """Take a risk that may be the largest; one that is not known is none."""
        self.peak_risk = float(np.fmax(self.peak_risk, risk))

    @property
    def unknown_share(self) -> float:
        """Part of the braking time without a squeal risk; NaN where there was no braking."""
        return 1.0 - self.risk_known_s / self.braking_s if self.braking_s else math.nan

    @property
    def known_alarms(self) -> Alarms:
        """Known applications, and those with predicted squeal."""
        return Alarms(self.alarms, self.known, self.brakings)

    @property
    def rank(self) -> tuple[float, float, float]:
        """Key of the worst first: by the low end of the interval, which few do not raise."""
        share, low, _ = self.known_alarms.share
        return tuple(-math.inf if math.isnan(one) else one  # type: ignore[return-value]
                     for one in (low, share, self.peak_risk))


class Region(NamedTuple):
    """Cell of mean pressure and of rotor speed at the start of an application."""

    pressure: int
    speed: int


@dataclass(frozen=True, eq=False)
class FleetData:
    """
    All that the page shows.

    Parameters
    ----------
    folder : FleetFolder
    recordings : list of rows
        Without copies of others.
    brakings : dict of int
        Brakings of which squeal is known, by recording; 0 of others.
    total : Group
    vehicles, brakes, mileage, dates : dict of Group
        By name; vehicles worst first, the empty name where none is known.
    regions : dict of Group
        By `Region`; those without a pressure or a speed are left out.

    """

    folder: FleetFolder
    recordings: list[Row]
    brakings: Counter[str]
    total: Group
    vehicles: dict[str, Group]
    brakes: dict[str, Group]
    mileage: dict[str, Group]
    dates: dict[str, Group]
    regions: dict[Region, Group] = field(default_factory=dict)


def read_fleet(folder: FleetFolder) -> FleetData:
    """
    Read the tables of a fleet, row by row.

    Raises
    ------
    ResultError
        For tables that cannot be read.

    """
    rows: list[Row] = [row for row in folder.rows('recordings') if not row[1].copy_of]
    regions, brakings = _applied(folder.rows('applications'))
    result = [_Counted(label, one, brakings[label.recording]) for label, one in rows]
    total = Group()
    for _, record, count in result:
        total.add(record, count)
    vehicles = _grouped((one.label.vehicle, one) for one in result)
    return FleetData(
        folder, rows, brakings, total,
        dict(sorted(vehicles.items(), key=lambda item: item[1].rank, reverse=True)),
        _grouped((one.brake, _Counted(label, one, one.applications_known))  # never two at once
                 for label, one in folder.rows('brakes')),
        _classes(result, lambda label: label.mileage_km, _mileage_step, _mileage_name),
        _classes(result, _day, _day_step, _day_name), regions)


class _Counted(NamedTuple):
    """A recording, or a brake of one, and its brakings of which squeal is known."""

    label: FleetLabel
    record: FleetRecording | FleetBrake
    brakings: int


def _grouped(rows: Iterable[tuple[str, _Counted]]) -> dict[str, Group]:
    groups: dict[str, Group] = defaultdict(Group)
    for name, (_, record, brakings) in rows:
        groups[name].add(record, brakings)
    return dict(groups)


def _classes(rows: Sequence[_Counted], value: Callable[[FleetLabel], float],
             step_of: Callable[[float], float],
             name: Callable[[float, float], str]) -> dict[str, Group]:
    """Return recordings by classes of a value, in its order; empty where it is never known."""
    known = sorted(((at, one) for one in rows if not math.isnan(at := value(one.label))),
                   key=itemgetter(0))
    if not known:
        return {}
    step = step_of(known[-1][0] - known[0][0])
    return _grouped((name(math.floor(at / step) * step, step), one) for at, one in known)


def _mileage_step(span: float) -> float:
    """Return the width of classes [km], 1, 2 or 5 times a power of ten."""
    least = max(span / _MOST_CLASSES, 1.0)
    power = 10.0 ** math.floor(math.log10(least))
    return power * next(one for one in (1.0, 2.0, 5.0, 10.0) if one * power >= least)


def _mileage_name(low: float, step: float) -> str:
    return f'{low:,.0f} to {low + step:,.0f}'


def _day(label: FleetLabel) -> float:
    try:
        return float(date.fromisoformat(label.date).toordinal())
    except ValueError:
        return math.nan


def _day_step(span: float) -> float:
    return next((days for days in _DAYS if span / days <= _MOST_CLASSES), _DAYS[-1])


def _day_name(low: float, step: float) -> str:
    first = date.fromordinal(max(round(low), 1))
    return f'{first}' if step == 1.0 else f'from {first}, {step:.0f} days'


def _applied(rows: Iterable[tuple[FleetLabel, ApplicationRecord]]
             ) -> tuple[dict[Region, Group], Counter[str]]:
    """Return operating regions, and brakings of which squeal is known by recording."""
    groups: dict[Region, Group] = defaultdict(Group)
    brakings: Counter[str] = Counter()
    for name, own in groupby(rows, key=lambda row: row[0].recording):
        applications = [one for _, one in own]
        known = [one for one in applications if one.alarm is not None]
        numbers = braking_numbers([(name, one.start_s, one.end_s) for one in known]).tolist()
        brakings[name] += len(set(numbers))
        for one in applications:
            if region := _region(one):
                groups[region].apply(one)
        for region, _ in {(_region(one), number)
                          for one, number in zip(known, numbers, strict=True)}:
            if region:
                groups[region].brakings += 1
    return dict(groups), brakings


def _region(one: ApplicationRecord) -> Region | None:
    """Return the region of an application; None: its pressure or speed is not known."""
    if not math.isfinite(one.pressure_pa + one.rotor_speed_rad_s):
        return None
    return Region(math.floor(one.pressure_pa / PRESSURE_STEP),
                  math.floor(abs(one.rotor_speed_rad_s) / SPEED_STEP))

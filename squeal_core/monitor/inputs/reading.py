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

"""Samples of an input, and readings of it at a tick; the ranges that a model was validated in."""

from collections.abc import Mapping
from dataclasses import dataclass
import math
from typing import Literal, NamedTuple, TypeAlias

from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.setting_specs import UNITS
from squeal_core.monitor.settings import MonitorSettings

Status: TypeAlias = Literal[
    'good', 'never received', 'stale', 'stuck', 'contradicted', 'implausible', 'invalid',
    'outside validated range', 'time went backwards']

BELIEVED: tuple[Status, ...] = ('good', 'outside validated range')
_TABLE_MARGIN = 1.0  # K by which a temperature sensor may err at the ends of a friction table


class Sample(NamedTuple):
    """
    A value in SI units and the time it holds for [ns].

    Parameters
    ----------
    stamp : int
    value : float
    number : int
        That its publisher gave the message; 0: not known.
    connection : int
        Of a recording, one a publisher; 0: not known.

    """

    stamp: int
    value: float
    number: int = 0
    connection: int = 0


@dataclass(frozen=True)
class MissingValue:
    """
    Placeholder for a sample where a message holds no value.

    Parameters
    ----------
    reason : str
        Why it does not.
    is_other : bool
        It is about something else, as of another publisher, and nothing is wrong with it.

    """

    reason: str
    is_other: bool = False


class Reading(NamedTuple):
    """
    Reading of an input in an assessment: the newest sample up to the tick.

    Parameters
    ----------
    status : str
    value, age : float
        In SI units, and in s.
    detail : str
        What is wrong with it, in words that follow the value.

    """

    status: Status
    value: float = math.nan
    age: float = math.nan
    detail: str = ''

    @property
    def is_believed(self) -> bool:
        """Return whether the value is that of the brake, though the model may not hold there."""
        return self.status in BELIEVED

    def described(self, name: str) -> str:
        """Return the reading in words: the input, its value and its age."""
        if math.isnan(self.age) and math.isnan(self.value):
            return f'{name} {self.detail or self.status}'
        value = f'{self.value:.6g} {UNITS.get(name, "-")}'.removesuffix(' -')
        detail = f', {self.detail}' if self.detail else ''
        if self.status in ('stale', 'time went backwards'):
            return f'{name} is {self.age:.2f} s old: {value}{detail}'
        old = f' ({self.age:.2f} s old)' if self.age >= 0.0 else ''
        return f'{name} is {value}{detail}{old}'


@dataclass(frozen=True)
class ValidatedRange:
    """A range in which the model was validated; below it some signals are merely at rest."""

    low: float = -math.inf
    high: float = math.inf
    may_rest: bool = False
    margin: float = 0.0

    def admits(self, value: float) -> bool:
        """Return whether the model was validated for a value."""
        if self.may_rest:
            return abs(value) <= self.high
        return self.low - self.margin <= value <= self.high + self.margin

    def __str__(self) -> str:
        return f"outside the model's validated range {self.low:.6g} to {self.high:.6g}"


def validated_ranges(model: BrakeModel, settings: MonitorSettings) -> Mapping[str, ValidatedRange]:
    """Return the validated range of each input, in its own unit."""
    assert model.caliper is not None
    preload, table = model.caliper.preload(1.0), model.friction_table
    return {
        'rotor_speed': ValidatedRange(settings.validated_rotor_speed_low,
                                      settings.validated_rotor_speed_high, may_rest=True),
        'pressure': ValidatedRange(settings.validated_preload_low / preload,
                                   settings.validated_preload_high / preload, may_rest=True),
        'friction': ValidatedRange(settings.validated_friction_low,
                                   settings.validated_friction_high),
        'temperature': ValidatedRange() if table is None else ValidatedRange(
            float(table.temperature[0]), float(table.temperature[-1]), margin=_TABLE_MARGIN)}

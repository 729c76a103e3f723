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
The file of `--signals`: columns or topic fields for the inputs of brakes.

docs/howto/recordings.md is its manual; `squeal signals` writes one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from pathlib import Path
from typing import Any, Literal, TypeAlias

from squeal_core.common.errors import LocatedError, short_repr
from squeal_core.common.measured_units import find_unit, Unit, unit_remedy
from squeal_core.common.yaml_sections import YamlSection
from squeal_core.monitor.results.result_summary import file_hash
from squeal_core.monitor.setting_specs import LARGEST_FRICTION, Signal, SIGNALS
from squeal_core.monitor.settings import check_names
from squeal_ros.recordings.signals.table_spec import ClockSpec, read_clock, read_table, TableSpec

QUANTITIES: Mapping[Signal, tuple[str, ...]] = {
    'rotor_speed': ('angular speed', 'speed'), 'pressure': ('pressure',), 'friction': ('ratio',),
    'temperature': ('temperature',)}
# settings of an input that the file may give, as config/monitor.yaml does
PASSED_ON = ('max_age', 'minimum', 'maximum', 'stuck_after', 'movement', 'reference')
_RADIUS = 'wheel_radius_m'
_LARGEST_RADIUS = 2.0  # m
_MOST_GROUPS = 1_000_000
_DEGREES = {'deg': 1.0, 'min': 1.0 / 60.0, 'rad': 180.0 / math.pi}  # of latitude and longitude

Kind: TypeAlias = Literal['column', 'topic']
KINDS: tuple[Kind, ...] = ('column', 'topic')


class SignalsError(LocatedError):
    """A file of signals that cannot be used."""


@dataclass(frozen=True, kw_only=True)
class SignalSource:
    """
    One input of one brake, and its source.

    Parameters
    ----------
    brake, signal : str
    where : str
        File, line and key, for errors.
    kind : str
        'column' of a table or channel of a measurement, or 'topic'.
    name : str
        Of the column or topic; of a column without a name its number, from 1.
    group : int, optional
        Of channels, where several have the name.
    type, field : str
        Of a topic; empty: those of the settings.
    stamp : str
        Of a topic, as in the settings.
    unit : Unit
    scale, offset : float
        Value in SI units = scale * number + offset.
    passed_on : mapping
        Other settings of the input.

    """

    brake: str
    signal: Signal
    where: str
    kind: Kind
    name: str
    group: int | None = None
    type: str = ''  # noqa: A003
    field: str = ''
    stamp: str = ''
    unit: Unit
    scale: float
    offset: float
    passed_on: Mapping[str, Any]


@dataclass(frozen=True)
class CoordinateSource:
    """Column or channel of latitude or longitude, and its conversion to degrees."""

    where: str
    name: str
    group: int | None
    scale: float


@dataclass(frozen=True)
class Signals:
    """
    Contents of a file of signals.

    Parameters
    ----------
    path : path
    sources : tuple of SignalSource
    clock : ClockSpec
    table : TableSpec
    position : tuple of CoordinateSource
        Latitude and longitude, or nothing.
    frictions : mapping
        Constant friction coefficient of each brake that has one.
    sha256 : str
        Of the file.

    """

    path: Path
    sources: tuple[SignalSource, ...]
    clock: ClockSpec
    table: TableSpec
    position: tuple[CoordinateSource, ...] = ()
    frictions: Mapping[str, float] = field(default_factory=dict)
    sha256: str = ''

    def of(self, kind: Kind) -> 'Signals | None':
        """Return the signals for recordings with columns, or with topics; None without any."""
        own = tuple(source for source in self.sources if source.kind == kind)
        of_tables = kind == 'topic' and len(own) < len(self.sources)
        return replace(self, sources=own, clock=ClockSpec() if of_tables else self.clock,
                       position=() if kind == 'topic' else self.position) if own else None


def read_signals(path: str | Path) -> Signals:
    """
    Read a file of signals.

    Raises
    ------
    SignalsError
        With file, line, key, value and remedy.

    """
    path = Path(path)
    top = YamlSection.of_file(path, SignalsError)
    radius = top.number(_RADIUS, 0.0, 0.0, _LARGEST_RADIUS)
    brakes, clock = top.section('brakes'), top.section('clock')
    sources: list[SignalSource] = []
    frictions: dict[str, float] = {}
    if not brakes.content:
        raise top.error('brakes', 'names no brake', 'see docs/howto/recordings.md, or let `squeal '
                        'signals RECORDING -o SIGNALS.yaml` propose a file')
    try:
        check_names(tuple(brakes.content))
    except LocatedError as error:
        raise brakes.error('', error.what, error.remedy) from None
    stamp = clock.text('stamp', choices=('header', 'receipt'))
    for brake in brakes.content:
        section = brakes.section(brake)
        if constant := _constant_friction(section):
            frictions[brake] = constant
        sources += _inputs(section, brake, radius, stamp, constant > 0.0)
    result = Signals(path, tuple(sources), read_clock(clock), read_table(top.section('table')),
                     _position(top.section('position')), frictions, file_hash(path)[0])
    top.finish()
    return result


def _constant_friction(brake: YamlSection) -> float:
    """Return mu where the entry of friction is a constant; else 0."""
    entry = brake.content.get('friction')
    if not isinstance(entry, Mapping) or 'constant' not in entry:
        return 0.0
    section = brake.section('friction')
    result = section.number('constant', 0.0, 0.0, LARGEST_FRICTION)
    section.finish()
    return result


def _inputs(brake: YamlSection, name: str, radius: float, stamp: str,
            is_constant: bool) -> list[SignalSource]:
    radius = brake.number(_RADIUS, radius, 0.0, _LARGEST_RADIUS)
    result = [_source(entry, name, signal, radius, stamp)
              for signal in SIGNALS if signal in brake.content
              and not (is_constant and signal == 'friction') for entry in brake.sections(signal)]
    brake.finish(SIGNALS)
    kinds = {source.kind for source in result} or {'column'}
    for kind in sorted(kinds):
        signals = [source.signal for source in result if source.kind == kind]
        _check_inputs(brake, signals, is_constant, f' as {kind}' if len(kinds) > 1 else '')
    return result


def _check_inputs(brake: YamlSection, signals: Sequence[Signal], is_constant: bool,
                  kind: str) -> None:
    """Refuse a brake that lacks an input in recordings of a kind, or has one twice."""
    for signal in ('rotor_speed', 'pressure'):
        if signal not in signals:
            raise brake.error(signal, f'is missing{kind}', 'say where it is')
    if not is_constant and not {'friction', 'temperature'} & set(signals):
        raise brake.error('friction', f'is missing{kind}, and so is temperature',
                          "give one of them (by the temperature, friction is the model's), or "
                          'friction: {constant: NUMBER}: docs/howto/missing_sensors.md')
    if doubled := [signal for signal in signals if signals.count(signal) > 1]:
        raise brake.error(doubled[0], f'is named {signals.count(doubled[0])} times{kind}',
                          'give one column for tables, and one topic for bags')


def _source(entry: YamlSection, brake: str, signal: Signal, radius: float,
            stamp: str) -> SignalSource:
    key, name = _named(entry, 'topic')
    unit, factor = _unit(entry, signal, entry.number(_RADIUS, radius, 0.0, _LARGEST_RADIUS))
    scale, offset = entry.number('scale', 1.0), entry.number('offset', 0.0)
    if not scale:
        raise entry.error('scale', 'is 0', 'give another number')
    allowed = [one for one in PASSED_ON if one != 'reference' or signal == 'pressure']
    passed_on = {one: entry.content[one] for one in allowed if one in entry.content}
    if unit.reference and passed_on.setdefault('reference', unit.reference) != unit.reference:
        raise entry.error('reference', f'is {short_repr(passed_on["reference"])}',
                          f'the unit {unit.name} is {unit.reference}; correct one of them')
    about: dict[str, Any] = {'kind': 'column', 'group': entry.count('group', _MOST_GROUPS)}
    if key == 'topic':
        about = {'kind': 'topic', 'type': entry.text('type'), 'field': entry.text('field'),
                 'stamp': entry.text('stamp', stamp, ('header', 'receipt'))}
    result = SignalSource(
        brake=brake, signal=signal, where=entry.where(), name=name, unit=unit, **about,
        scale=factor * unit.scale * scale, offset=factor * (unit.scale * offset + unit.offset),
        passed_on=passed_on)
    entry.finish((*allowed, _RADIUS))
    return result


def _named(entry: YamlSection, *others: str) -> tuple[str, str]:
    """Return the key that names a column or something else, and its value."""
    keys = ('column', 'channel', *others)
    named = [key for key in keys if key in entry.content]
    if len(named) != 1:
        none = 'no column or topic' if others else 'no column'
        raise entry.error('', f'has {" and ".join(named) or none}',
                          f'give one of {", ".join(keys)}')
    (key,) = named
    name = entry.text(key)
    if not name.strip():
        raise entry.error(key, 'is empty', 'name it')
    return key, name


def _position(section: YamlSection) -> tuple[CoordinateSource, ...]:
    if not section.content:
        return ()
    result = tuple(_coordinate(section.section(key)) for key in ('latitude', 'longitude'))
    section.finish()
    return result


def _coordinate(entry: YamlSection) -> CoordinateSource:
    _, name = _named(entry)
    unit = entry.text('unit', 'deg', tuple(_DEGREES))
    result = CoordinateSource(entry.where(), name, entry.count('group', _MOST_GROUPS),
                              _DEGREES[unit] * entry.number('scale', 1.0))
    entry.finish()
    return result


def _unit(entry: YamlSection, signal: Signal, radius: float) -> tuple[Unit, float]:
    """Return the unit of an input, and the factor from its SI unit to that of the input."""
    quantities = QUANTITIES[signal]
    text = entry.text('unit', None)
    unit = find_unit(text)
    if unit is None or unit.quantity not in quantities:
        what = f'is {short_repr(text)}' + (
            f', a unit of {unit.quantity}' if unit else ', which is no known unit')
        raise entry.error('unit', what, unit_remedy(text, quantities))
    if unit.quantity != 'speed':
        return unit, 1.0
    if not radius:
        raise entry.error('unit', f'is {unit.name}, a speed of the vehicle or the wheel rim',
                          f'give {_RADIUS}, the rolling radius, to have the speed of the rotor')
    return unit, 1.0 / radius

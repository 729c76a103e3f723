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

"""Units in which logs state pressures, speeds, temperatures, friction and times."""

from collections.abc import Iterable
from dataclasses import dataclass
import math
import re
from typing import Any

from squeal_core.common.errors import nearest_word


@dataclass(frozen=True)
class Unit:
    """
    A unit and its conversion to SI units: value in SI = scale * number + offset.

    Parameters
    ----------
    name : str
    quantity : str
        'pressure', 'angular speed', 'speed', 'temperature', 'ratio' or 'time'.
    scale, offset : float
    reference : str
        Of a pressure whose unit says it, 'gauge' or 'absolute'.

    """

    name: str
    quantity: str
    scale: float
    offset: float = 0.0
    reference: str = ''

    def converts_like(self, other: 'Unit') -> bool:
        """Return whether numbers of both units are the same values."""
        return self.quantity == other.quantity and math.isclose(
            self.scale, other.scale, rel_tol=1e-6) and self.offset == other.offset and not (
            self.reference and other.reference and self.reference != other.reference)


_TURN, _BAR, _PSI = 2.0 * math.pi, 1e5, 6894.757293168
_ZERO_CELSIUS, _ZERO_FAHRENHEIT = 273.15, 459.67 * 5.0 / 9.0
# names as they are written, the first of each being ours; their `Unit`
_TABLE: tuple[tuple[Any, ...], ...] = (
    ('Pa pascal N/m2', 'pressure', 1.0),
    ('hPa mbar millibar', 'pressure', 100.0),
    ('kPa', 'pressure', 1e3),
    ('MPa N/mm2', 'pressure', 1e6),
    ('bar', 'pressure', _BAR),
    ('barg bar(g) bar_g barü', 'pressure', _BAR, 0.0, 'gauge'),
    ('bara bar(a) bar_a barabs', 'pressure', _BAR, 0.0, 'absolute'),
    ('psi lbf/in2 lb/in2', 'pressure', _PSI),
    ('psig', 'pressure', _PSI, 0.0, 'gauge'),
    ('psia', 'pressure', _PSI, 0.0, 'absolute'),
    ('kgf/cm2 kg/cm2', 'pressure', 98066.5),
    ('atm', 'pressure', 101325.0),
    ('rad/s rad/sec rads rad_s', 'angular speed', 1.0),
    ('deg/s deg/sec °/s deg_s grad/s', 'angular speed', _TURN / 360.0),
    ('1/min rpm r/min rev/min u/min min-1 /min tr/min tours/min giri/min g/min umdr/min t/min '
     'min^-1', 'angular speed', _TURN / 60.0),
    ('rev/s rps r/s u/s tr/s giri/s hz', 'angular speed', _TURN),
    ('m/s mps m/sec', 'speed', 1.0),
    ('km/h kph kmh km/hr kmph', 'speed', 1.0 / 3.6),
    ('mph mi/h', 'speed', 0.44704),
    ('kn knot kt', 'speed', 1852.0 / 3600.0),
    ('ft/s fps', 'speed', 0.3048),
    ('mm/s', 'speed', 1e-3),
    ('K kelvin degk °k', 'temperature', 1.0),
    ('degC °c celsius c grad_c gradc deg_c', 'temperature', 1.0, _ZERO_CELSIUS),
    ('degF °f fahrenheit f deg_f', 'temperature', 5.0 / 9.0, _ZERO_FAHRENHEIT),
    ('- 1 none unitless [-] mu µ dimensionless m/m', 'ratio', 1.0),
    ('% percent prozent', 'ratio', 1e-2),
    ('s sec second seconds sek sekunden', 'time', 1.0),
    ('ms msec millisecond milliseconds', 'time', 1e-3),
    ('us µs usec microsecond microseconds', 'time', 1e-6),
    ('ns nsec nanosecond nanoseconds', 'time', 1e-9),
    ('min minute minutes minuten', 'time', 60.0),
    ('h hour hours std stunden', 'time', 3600.0),
)
_NAMES = [(names, Unit(names.split()[0], *about)) for names, *about in _TABLE]
UNITS = {unit.name: unit for _, unit in _NAMES}
_EXACT = {name: unit for names, unit in _NAMES for name in names.split()}
_FOLDED = {name.casefold(): unit for name, unit in _EXACT.items()}
# of both meanings of 1/s neither is the safer one
_AMBIGUOUS = {'1/s': 'rev/s or rad/s', 's-1': 'rev/s or rad/s', 's^-1': 'rev/s or rad/s',
              'at': 'kgf/cm2'}
_SIMPLER = str.maketrans({'²': '2', '³': '3', '⁻': '-', '¹': '1', '−': '-', 'μ': 'µ', 'º': '°',
                          '˚': '°', '℃': '°C', '·': '', '*': '', '^': ''})


def find_unit(text: str) -> Unit | None:
    """Return the unit that a text names, as `bar`, `[1/min]` or `°C`; None for no known one."""
    bare = text.strip()
    while bare[:1] + bare[-1:] in ('[]', '()', '{}', '<>') and bare != '[]':
        bare = bare[1:-1].strip()
    bare = re.sub(r'\s*([/()])\s*', r'\1', bare.translate(_SIMPLER))
    for name in (bare, bare.replace(' ', ''), bare.replace(' ', '_')):
        result = _EXACT.get(name) or _FOLDED.get(name.casefold())
        if result:
            return result
    return None


def unit_remedy(text: str, quantities: Iterable[str]) -> str:
    """Return the remedy for a unit that is not known: units to write, the nearest first."""
    if text.strip().casefold() in _AMBIGUOUS:
        return f'write {_AMBIGUOUS[text.strip().casefold()]}'
    own = [unit.name for unit in UNITS.values() if unit.quantity in quantities]
    names = [name for names, unit in _NAMES if unit.quantity in quantities
             for name in names.split()]
    near = find_unit(nearest_word(text, names))
    first = f' (did you mean {near.name}?)' if near else ''
    return f'write one of {", ".join(own)}{first}'

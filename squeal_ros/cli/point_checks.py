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

"""Checks that numbers of an operating point are possible and usual, in their option's unit."""

import argparse
from collections.abc import Collection, Iterable
from dataclasses import dataclass
import math
from typing import Any

from squeal_core.brake.design_parameters import unit_suffix
from squeal_core.common.errors import short_repr, SquealError
from squeal_core.common.ranges import Ends, hint, span, SYMBOLS, UNITS
from squeal_core.monitor.setting_specs import MONITOR_KEYS
from squeal_ros.cli.console import warn

_DEFAULTS: dict[str, Any] = {key.name: key.default for key in MONITOR_KEYS}


def _validated(name: str) -> Ends:
    return _DEFAULTS[f'validated_{name}_low'], _DEFAULTS[f'validated_{name}_high']


@dataclass(frozen=True)
class _Range:
    """Unit, and ends of what is possible and of what is usual; of magnitudes where signed."""

    unit: str
    dimension: str
    possible: Ends
    usual: Ends
    signed: bool = False
    source: str = 'usual is'


_RANGES = {
    'rotor_speed': _Range('rad/s', 'speed', (0.0, 1e4), _validated('rotor_speed'), True,
                          'models were validated at'),
    'friction': _Range('', 'number', (0.0, 2.0), _validated('friction'),
                       source='models were validated at'),
    'friction_slope': _Range('s/m', 'inverse_speed', (0.0, 100.0), (1e-4, 2.0), True),
    'preload': _Range('N', 'force', (0.0, 1e7), _validated('preload'),
                      source='models were validated at'),
    'pressure': _Range('Pa', 'pressure', (0.0, 1e9), (1e4, 3e7)),
    'contact_pressure': _Range('Pa', 'pressure', (0.0, 1e9), (1e3, 5e7)),
    'contact_stiffness': _Range('N/m^3', 'stiffness', (0.0, 1e17), (1e8, 1e13)),
    'damping_scale': _Range('', 'number', (0.0, 1e3), (0.1, 10.0)),
}


def check_point(options: argparse.Namespace) -> None:
    """Refuse options of an operating point that nothing can follow, warn of unusual ones."""
    for name in _RANGES:
        value = getattr(options, name, None)
        for number in value if isinstance(value, list) else [value]:
            check_value(f'--{name.replace("_", "-")}', name, number)


def check_values(where: str, name: str, values: Iterable[float], *, signed: bool = True) -> None:
    """Check the ends of an axis or of bounds, where friction may have the sign of the speed."""
    for value in values:
        check_value(where, name, abs(value) if signed and name == 'friction' else value)


def check_value(where: str, name: str, value: float | None) -> None:
    """Refuse or doubt one number, which may not be given; zero is no doubtful number."""
    if value is None:
        return
    about = _RANGES[name]
    if not math.isfinite(value):
        raise SquealError(f'{where}: is {value}; give a finite number')
    if value == 0.0:
        if name == 'rotor_speed':
            raise SquealError(f'{where}: is 0 rad/s; steady sliding needs another speed')
        return
    size = abs(value) if about.signed else value
    near = hint(size, about.dimension, 1.0, about.unit, about.usual)
    if not about.possible[0] <= size <= about.possible[1]:
        negative = value < 0.0 and name == 'friction'
        sign = ' (its sign follows that of the speed)' if negative else ''
        raise SquealError(f'{where}: is {value:g} {about.unit}'.rstrip() + f'; give '
                          f'{span(about.possible, 1.0, about.unit)}{near}{sign}')
    if not about.usual[0] <= size <= about.usual[1]:
        warn(f'{where}: is {value:g} {about.unit}'.rstrip() + f'; {about.source} '
             f'{span(about.usual, 1.0, about.unit)}: check it{near}')


def check_numbers(numbers: Collection[int], size: int) -> None:
    """Refuse numbers of modes that a model of this size has not."""
    if not set(numbers) <= set(range(1, size + 1)):
        raise SquealError(f'--modes: {short_repr(numbers)}; give numbers of modes, 1 to {size}')


def check_design_bounds(path: str, start: float, bounds: Ends | None) -> None:
    """Refuse bounds of a number of the description that do not hold what it is now."""
    if bounds and bounds[0] <= start <= bounds[1]:
        return
    suffix = unit_suffix(path)
    unit = SYMBOLS.get(suffix, suffix)
    dimension = next((name for name, units in UNITS.items() if suffix in units), '')
    scale = UNITS[dimension][suffix] if dimension else 1.0
    near = hint(bounds[0], dimension, scale, unit, (0.5 * start * scale, 2.0 * start * scale)
                ) if bounds else ''
    raise SquealError(f'--bounds: give the lowest and the highest {path}, on either side of '
                      f'{start:g} {unit}'.rstrip() + near)


def check_band(band: Iterable[float]) -> None:
    """Refuse a band without a width, and warn of one that looks like kHz."""
    low, high = band
    if not (math.isfinite(low) and math.isfinite(high) and 0.0 <= low < high):
        raise SquealError(f'--band: is {low:g} to {high:g} Hz; give two frequencies that rise')
    if high < 100.0:
        warn(f'--band: is {low:g} to {high:g} Hz; check it ({low:g} to {high:g} kHz would be '
             f'{1e3 * low:g} {1e3 * high:g})')

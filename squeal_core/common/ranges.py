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

"""Possible and plausible ranges of quantities, and the units that were probably meant."""

from collections.abc import Callable
import math
from typing import TypeAlias
import warnings

Warn: TypeAlias = Callable[[str], None]
Ends: TypeAlias = tuple[float, float]

UNITS: dict[str, dict[str, float]] = {  # suffixes of keys, in SI units
    'length': {'m': 1.0, 'mm': 1e-3},
    'angle': {'rad': 1.0, 'deg': math.pi / 180.0},
    'pressure': {'pa': 1.0, 'bar': 1e5, 'mpa': 1e6},
    'modulus': {'pa': 1.0, 'mpa': 1e6, 'gpa': 1e9},
    'density': {'kg_m3': 1.0},
    'stiffness': {'n_m3': 1.0},
    'damping': {'ns_m3': 1.0},
    'inverse_speed': {'s_m': 1.0},
    'frequency': {'hz': 1.0, 'khz': 1e3},
    'road_speed': {'km_h': 1.0 / 3.6, 'm_s': 1.0},
    'acceleration': {'m_s2': 1.0, 'g': 9.80665},
    'time': {'s': 1.0, 'min': 60.0},
    'celsius': {'degc': 1.0},
    'number': {'': 1.0},
}
SYMBOLS = {'pa': 'Pa', 'mpa': 'MPa', 'gpa': 'GPa', 'kg_m3': 'kg/m^3', 'n_m3': 'N/m^3',
           'ns_m3': 'N s/m^3', 's_m': 's/m', 'hz': 'Hz', 'khz': 'kHz',
           'km_h': 'km/h', 'm_s': 'm/s', 'm_s2': 'm/s^2', 'degc': 'degC'}
# units in which numbers are given by mistake, in SI units
_MISTAKES: dict[str, dict[str, float]] = {
    'length': {'m': 1.0, 'mm': 1e-3, 'cm': 1e-2, 'inch': 0.0254, 'um': 1e-6},
    'angle': {'rad': 1.0, 'deg': math.pi / 180.0},
    'pressure': {'bar': 1e5, 'MPa': 1e6, 'Pa': 1.0, 'kPa': 1e3, 'psi': 6894.757},
    'modulus': {'GPa': 1e9, 'MPa': 1e6, 'Pa': 1.0, 'ksi': 6.894757e6},
    'density': {'g/cm^3': 1e3, 't/mm^3': 1e12, 'kg/mm^3': 1e9, 'lb/in^3': 27679.9},
    'stiffness': {'N/mm^3': 1e9},
    'damping': {'N s/mm^3': 1e9},
    'inverse_speed': {'s/mm': 1e3, 'h/km': 3.6},
    'frequency': {'kHz': 1e3, 'Hz': 1.0},
    'road_speed': {'km/h': 1.0 / 3.6, 'm/s': 1.0, 'mph': 0.44704},
    'acceleration': {'m/s^2': 1.0, 'g': 9.80665},
    'time': {'s': 1.0, 'ms': 1e-3, 'min': 60.0},
    'celsius': {},
    'number': {'%': 1e-2},
    'speed': {'rpm': math.pi / 30.0, 'rev/s': 2.0 * math.pi},
    'force': {'kN': 1e3, 'daN': 10.0},
    'mass': {'t': 1e3, 'g': 1e-3},
    'temperature': {},
}


class ImplausibleWarning(UserWarning):
    """A value that can be used, but is probably not the intended one."""


def warn_implausible(text: str) -> None:
    """Emit an ImplausibleWarning: the default of readers for an unusual value."""
    warnings.warn(text, ImplausibleWarning, stacklevel=3)


def hint(value: float, dimension: str, scale: float, unit: str, range_si: Ends,
         name: str = '') -> str:
    """
    Return ' (0.014 m would be 14 mm)': the mistake that explains a value; '' without one.

    Parameters
    ----------
    value : float
        As written, in `unit`.
    dimension : str
        Of the quantity.
    scale : float
        SI value of the unit.
    unit : str
        As the key says it.
    range_si : (2,) floats
        What is plausible.
    name : str
        Of the quantity: a radius may be a diameter and the other way round.

    """
    for meant, factor in _MISTAKES.get(dimension, {}).items():
        if factor != scale and _within(value * factor, range_si):
            return f' ({value:g} {meant} would be {value * factor / scale:.6g} {unit})'.replace(
                ' )', ')')
    for word, other, factor in (('radius', 'diameter', 0.5), ('diameter', 'radius', 2.0)):
        if word in name and _within(value * factor * scale, range_si):
            return f' (if it is the {other}, the {word} is {value * factor:g} {unit})'
    return ''


def span(ends: Ends, scale: float, unit: str) -> str:
    """Return '1 to 200 mm', or 'more than 0 mm' of a range without an end."""
    low, high = (f'{end / scale:.6g}' for end in ends)
    text = f'{low} to {high}' if math.isfinite(ends[1]) else f'more than {low}'
    return f'{text} {unit}'.strip()


def check_ratio(where: str, what: str, value: float, *, possible: Ends, plausible: Ends,
                remedy: str, refuse: Callable[[str, str, str], Exception], warn: Warn) -> None:
    """Refuse a proportion that no computation can follow, and warn of one that is unusual."""
    text = f'{what} ({value:.3g}; usual {span(plausible, 1.0, "")})'
    if not _within(value, possible):
        raise refuse(where, text, remedy)
    if not _within(value, plausible):
        warn(f'{where}: {text}; {remedy} unless it is meant')


def _within(value: float, ends: Ends) -> bool:
    return ends[0] <= value * (1.0 + 1e-9) and value * (1.0 - 1e-9) <= ends[1]

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
Strict reading of descriptions: mappings whose keys carry their unit as a suffix.

A value is a number, or `{value: number, source: text}` where it came from somewhere worth naming.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
import math
from typing import Any

from squeal_core.common.errors import BrakeDescriptionError, did_you_mean, short_repr
from squeal_core.common.ranges import Ends, hint, span, SYMBOLS, UNITS, Warn, warn_implausible


@dataclass(frozen=True)
class Quantity:
    """
    Dimension, range and default of the value of one key of a description.

    Parameters
    ----------
    dimension : str
    above, below : float
        Ends of what is possible, open or closed [SI units].
    closed : bool
    default : float, optional
    plausible : (2,) floats, optional
        Ends of what is usual [SI units]; a value beyond is doubted, not refused.
    zero : bool
        Whether zero is as usual: nothing there.

    """

    dimension: str
    above: float = -math.inf
    below: float = math.inf
    closed: bool = False
    default: float | None = None
    plausible: Ends | None = None
    zero: bool = False

    def admits(self, value: float) -> bool:
        """Return whether a value is within the limits."""
        if self.closed:
            return self.above <= value <= self.below
        return self.above < value < self.below

    def usual(self, value: float) -> bool:
        """Return whether a value is plausible; if not, its unit may be wrong."""
        if self.plausible is None or (self.zero and value == 0.0):
            return True
        low, high = self.plausible
        return low * (1.0 - 1e-9) <= value <= high * (1.0 + 1e-9)


@dataclass
class QuantityReader:
    """One mapping of a description, read key by key; `finish` refuses keys that were not read."""

    where: str
    content: Mapping[str, Any]
    sources: dict[str, str] = field(default_factory=dict)
    warn: Warn = warn_implausible
    _used: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        if not isinstance(self.content, Mapping):
            raise BrakeDescriptionError(
                self.where, f'is {short_repr(self.content)}', 'write a mapping of keys and values')

    def path(self, key: str) -> str:
        """Return the path of a key, for messages."""
        return f'{self.where}.{key}'

    def section(self, key: str, *, required: bool = True) -> 'QuantityReader | None':
        """Return the mapping under `key`, or None where it is absent and not required."""
        self._used.add(key)
        if key in self.content:
            return QuantityReader(self.path(key), self.content[key], self.sources, self.warn)
        if required:
            raise BrakeDescriptionError(self.path(key), 'is missing', 'add this section')
        return None

    def required_section(self, key: str) -> 'QuantityReader':
        """Return the reader of a section; raises if it is missing."""
        result = self.section(key)
        assert result is not None
        return result

    def sections(self, key: str) -> list['QuantityReader']:
        """Return the mappings of the list under `key`, one at least."""
        self._used.add(key)
        result = self.content.get(key)
        if not isinstance(result, list) or not result:
            raise BrakeDescriptionError(
                self.path(key), 'is missing' if result is None else f'is {short_repr(result)}',
                'write a list of mappings')
        return [QuantityReader(self.path(f'{key}[{i}]'), one, self.sources, self.warn)
                for i, one in enumerate(result)]

    def choice(self, key: str, options: Sequence[str], default: str | None = None) -> str:
        """Return one of some texts."""
        value = self.text(key, default)
        if value not in options:
            raise BrakeDescriptionError(
                self.path(key), f'is {short_repr(value)}',
                f'give one of: {", ".join(options)}{did_you_mean(value, options)}')
        return value

    def text(self, key: str, default: str | None = None) -> str:
        self._used.add(key)
        value = self.content.get(key, default)
        if value is None:
            raise BrakeDescriptionError(self.path(key), 'is missing', 'add it')
        if not isinstance(value, str):
            raise BrakeDescriptionError(self.path(key), f'is {short_repr(value)}', 'write a text')
        return value

    def count(self, key: str, *, least: int = 1, most: int = 500) -> int:
        value = self.number(key, Quantity('number', above=least, below=most, closed=True))
        if value != int(value):
            raise BrakeDescriptionError(self.path(key), f'is {value!r}', 'write a whole number')
        return int(value)

    def number(self, name: str, quantity: Quantity) -> float:
        """Return the quantity `name` in SI units, whichever of its units the key names."""
        key, factor = self._find(name, quantity)
        if key is None:
            assert quantity.default is not None
            return quantity.default
        value = self._scalar(key)
        self._check(key, name, value, quantity, factor)
        return value * factor

    def _check(self, key: str, name: str, value: float, quantity: Quantity,
               factor: float, unit: str = '') -> None:
        """Refuse an impossible value and warn of an unusual one, in the unit as written."""
        suffix = key.partition('[')[0].removeprefix(name).lstrip('_')
        unit = unit or SYMBOLS.get(suffix, suffix)
        possible = (quantity.above, quantity.below)
        why = hint(value, quantity.dimension, factor, unit, quantity.plausible or possible, name)
        shown = f'is {value!r} {unit}'.rstrip()
        if not quantity.admits(value * factor):
            within = '' if quantity.closed else ', both ends excluded'
            raise BrakeDescriptionError(
                self.path(key), shown, f'give {span(possible, factor, unit)}{within}{why}')
        if not quantity.usual(value * factor) and quantity.plausible:
            self.warn(f'{self.path(key)}: {shown}; usual is '
                      f'{span(quantity.plausible, factor, unit)}: check it{why}')

    def numbers(self, key: str) -> tuple[float, ...]:
        """Return a list of finite numbers."""
        self._used.add(key)
        values = self.content.get(key)
        if not isinstance(values, list) or not values:
            raise BrakeDescriptionError(
                self.path(key), f'is {short_repr(values)}', 'write a list of numbers')
        return tuple(_finite(self.path(f'{key}[{i}]'), v) for i, v in enumerate(values))

    def quantities(self, name: str, quantity: Quantity) -> tuple[float, ...]:
        """Return a list of quantities in SI units, whichever of its units the key names."""
        key, factor = self._find(name, quantity)
        values = self.numbers(key or name)
        for i, value in enumerate(values):
            self._check(f'{key}[{i}]', name, value, quantity, factor)
        return tuple(value * factor for value in values)

    def checked_numbers(self, key: str, quantity: Quantity, unit: str = '') -> tuple[float, ...]:
        """Return a list of numbers in the unit that the key names, each in its range."""
        values = self.numbers(key)
        for i, value in enumerate(values):
            self._check(f'{key}[{i}]', key, value, quantity, 1.0, unit)
        return values

    def finish(self) -> None:
        """Refuse keys that were not asked for: a misspelt key must not pass for a default."""
        for key in self.content:
            if key not in self._used:
                raise BrakeDescriptionError(
                    self.path(str(key)[:60]),
                    f'unknown key (value {short_repr(self.content[key])})',
                    f'remove it, or use one of: {", ".join(sorted(self._used))}'
                    f'{did_you_mean(key, self._used)}')

    def _find(self, name: str, quantity: Quantity) -> tuple[str | None, float]:
        allowed = {f'{name}_{u}' if u else name: f for u, f in UNITS[quantity.dimension].items()}
        self._used.update(allowed)
        result = [key for key in allowed if key in self.content]
        if len(result) > 1:
            raise BrakeDescriptionError(
                self.path(result[1]), f'says again what {result[0]} says', 'keep one of them')
        if result:
            return result[0], allowed[result[0]]
        self._refuse_other_unit(name, allowed)
        if quantity.default is None:
            raise BrakeDescriptionError(
                self.path(next(iter(allowed))), 'is missing', f'add {_either(allowed)}')
        return None, 1.0

    def _refuse_other_unit(self, name: str, allowed: Iterable[str]) -> None:
        for key in self.content:
            if key not in self._used and (key == name or str(key).startswith(f'{name}_')):
                raise BrakeDescriptionError(
                    self.path(key),
                    f'has a wrong unit suffix (value {short_repr(self.content[key])})',
                    f'use {_either(allowed)}')

    def _scalar(self, key: str) -> float:
        value = self.content[key]
        if isinstance(value, Mapping):
            inner = QuantityReader(self.path(key), value)
            inner._used.update(('value', 'source'))
            inner.finish()
            if 'value' not in value:
                raise BrakeDescriptionError(self.path(f'{key}.value'), 'is missing', 'add it')
            self.sources[self.path(key)] = inner.text('source')
            value = value['value']
        return _finite(self.path(key), value)


def _finite(where: str, value: Any) -> float:
    try:
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise ValueError
        number = float(value)  # one in quotes, too
    except (ValueError, OverflowError):
        raise BrakeDescriptionError(where, f'is {short_repr(value)}', 'write a number') from None
    if not math.isfinite(number):
        raise BrakeDescriptionError(where, f'is {short_repr(value)}', 'write a finite number')
    return number


def _either(keys: Iterable[str]) -> str:
    return ' or '.join(keys)

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

"""The numbers of a brake description, by their path in the YAML: found, read and changed."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from squeal_core.common.ranges import SYMBOLS, UNITS

# not of the brake's design: how many modes are kept, the file of a part's modes and what it is
# in, friction over temperature, the axes of tables
_LEFT_OUT = ('modes', 'modes_from', 'temperature_table', 'contact_pressure', 'frequency',
             'reference_frequency')
_SUFFIXES = sorted({suffix for units in UNITS.values() for suffix in units if suffix},
                   key=len, reverse=True)


@dataclass(frozen=True)
class DesignParameter:
    """
    A number of a brake description, or a list of them that is varied as a whole.

    Parameters
    ----------
    path : str
        Its keys, joined by dots, with the unit: 'disc.rotor_thickness_mm'.
    value : float
        As written; of a list its first.
    unit : str
        Symbol of the unit; empty: a plain number.

    """

    path: str
    value: float
    unit: str


def design_parameters(content: Mapping[str, Any]) -> tuple[DesignParameter, ...]:
    """Return the numbers of a description that a study may vary and are not 0, in its order."""
    result = []
    for path, item in leaves(content, _is_design):
        value = _number(item[0] if isinstance(item, list) and item else item)
        if value:
            suffix = unit_suffix(path)
            result.append(DesignParameter(path, value, SYMBOLS.get(suffix, suffix)))
    return tuple(result)


def number_paths(content: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the paths of all single numbers of a description."""
    return tuple(path for path, item in leaves(content) if _number(item) is not None)


def leaves(content: Mapping[str, Any],
           wanted: Callable[[Mapping[str, Any], str], bool] = lambda *_: True,
           before: str = '') -> Iterator[tuple[str, Any]]:
    """Yield all values that are no sections, by path; of a mapping with a 'value' that one."""
    for key, item in content.items() if isinstance(content, Mapping) else ():
        if not wanted(content, key):
            continue
        if isinstance(item, Mapping) and 'value' not in item:
            yield from leaves(item, wanted, f'{before}{key}.')
        else:
            yield f'{before}{key}', item['value'] if isinstance(item, Mapping) else item


def _is_design(section: Mapping[str, Any], key: str) -> bool:
    name = key.removesuffix(f'_{unit_suffix(key)}')
    # modes from a file do not change with a component's density or thickness
    return name not in _LEFT_OUT and ('modes_from' not in section or name in ('support', 'shim'))


def _number(value: Any) -> float | None:
    try:  # a text in quotes is a number, too, as it is where brakes are read
        return None if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        return None


def unit_suffix(path: str) -> str:
    """Return the suffix with the unit of a number, as 'mm'; '' of a plain number."""
    return next((suffix for suffix in _SUFFIXES if path.endswith(f'_{suffix}')), '')


def with_number(content: Mapping[str, Any], path: str, value: float) -> dict[str, Any]:
    """Return a copy of a description with another number at a path."""
    return _changed(content, path, lambda _: value)


def scaled(content: Mapping[str, Any], path: str, factor: float) -> dict[str, Any]:
    """Return a copy of a description with the number, or the list, at a path multiplied."""
    return _changed(content, path, lambda result: [factor * float(one) for one in result]
                    if isinstance(result, list) else factor * float(result))


def _changed(content: Mapping[str, Any], path: str,
             change: Callable[[Any], Any]) -> dict[str, Any]:
    place = copy = _copied(content)
    *sections, last = path.split('.')
    for section in sections:
        place = place[section]
    if isinstance(place[last], Mapping):
        place, last = place[last], 'value'
    place[last] = change(place[last])
    return copy


def _copied(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy with sections of its own, also where two of them are one object."""
    return {key: _copied(item) if isinstance(item, Mapping) else item
            for key, item in content.items()}

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

"""The numbers of a brake description that a study may vary, by their path in the YAML."""

from collections.abc import Iterator, Mapping
from copy import deepcopy
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
    """Return the numbers of a description that are not zero, in its order."""
    return tuple(_numbers(content, ''))


def _numbers(content: Mapping[str, Any], before: str) -> Iterator[DesignParameter]:
    from_file = 'modes_from' in content
    for key, item in content.items():
        suffix = unit_suffix(key)
        name, unit = key.removesuffix(f'_{suffix}'), SYMBOLS.get(suffix, suffix)
        # what a file holds of a part does not change with its density or thickness
        if name in _LEFT_OUT or (from_file and name not in ('support', 'shim')):
            continue
        if isinstance(item, Mapping) and 'value' in item:
            item = item['value']
        if isinstance(item, Mapping):
            yield from _numbers(item, f'{before}{key}.')
            continue
        first = item[0] if isinstance(item, list) and item else item
        try:  # YAML 1.1 reads 1e9 as a text
            value = 0.0 if isinstance(first, bool) else float(first)
        except (TypeError, ValueError):
            continue
        if value:
            yield DesignParameter(f'{before}{key}', value, unit)


def unit_suffix(path: str) -> str:
    """Return the suffix that says in which unit a number is, as 'mm'; '' of a plain number."""
    return next((suffix for suffix in _SUFFIXES if path.endswith(f'_{suffix}')), '')


def scaled(content: Mapping[str, Any], path: str, factor: float) -> dict[str, Any]:
    """Return a copy of a description with the number, or the list, at a path multiplied."""
    copy: dict[str, Any] = deepcopy(dict(content))
    keys, place = path.split('.'), copy
    for key in keys[:-1]:
        place = place[key]
    found = place[keys[-1]]
    if isinstance(found, Mapping):
        place, keys, found = place[keys[-1]], ['value'], found['value']
    place[keys[-1]] = ([factor * float(one) for one in found] if isinstance(found, list)
                       else factor * float(found))
    return copy

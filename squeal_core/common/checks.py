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

"""Checks of numbers and of the columns of tables: finite, in range, rising."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelError, short_repr, SquealError


def check_number(name: str, value: Any, *, above: float = -math.inf, least: float = -math.inf,
                 most: float = math.inf) -> None:
    """Raise SquealError unless a value is a finite number in its range."""
    try:
        finite = not isinstance(value, bool) and math.isfinite(value)
    except (TypeError, OverflowError):
        finite = False
    if not finite:
        raise SquealError(f'{name} is {short_repr(value)}; give a finite number')
    if not (value > above and least <= value <= most):
        raise SquealError(f'{name} is {value:g}; give a number above {max(above, least):g}, '
                          f'at most {most:g}')


def finite_array(name: str, values: ArrayLike) -> FloatArray:
    """Return values as an array; raise ModelError where one is no finite number."""
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise ModelError(f'{name}: not an array of numbers ({error}); mend it') from None
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        raise ModelError(f'{name}: {bad.size} values are not finite, the first at flat index '
                         f'{bad[0]} ({array.flat[bad[0]]}); mend the array')
    return array


def column(table: str, name: str, values: Any, *, above: float = 0.0,
           least: float = -math.inf) -> tuple[float, ...]:
    """Return the column of a table as plain numbers, checked one by one."""
    try:
        numbers = tuple(value.item() if isinstance(value, np.generic) else value
                        for value in values)
    except TypeError:
        raise SquealError(
            f'{table}: {name} is {short_repr(values)}; give a list of numbers') from None
    for i, value in enumerate(numbers):
        check_number(f'{table}: {name}[{i}]', value, above=above, least=least)
    return numbers


def check_rising(table: str, names: tuple[str, str], places: tuple[float, ...],
                 values: tuple[float, ...]) -> None:
    """Raise SquealError unless a table has a value for each place and its places rise."""
    if len(places) != len(values):
        raise SquealError(f'{table}: {len(places)} {names[0]} and {len(values)} {names[1]}; give '
                          'as many of one as of the other')
    if not places or np.any(np.diff(places) <= 0):
        raise SquealError(f'{table}: {names[0]} {short_repr(list(places))} do not rise; sort them')

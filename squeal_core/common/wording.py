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

"""Numbers and lists as text for messages."""

from collections.abc import Iterable
import math

_NEARLY_CERTAIN = 0.995  # from which two digits would say 1.00


def counted(number: int, what: str) -> str:
    """Return a number of things in words, as '1 tick' or '2 ticks'."""
    return f'{number} {what}{"s" * (number != 1)}'


def listed(names: Iterable[str], most: int) -> str:
    """Return names in a line, the first of them where there are more than so many."""
    every = list(names)
    more = f' and {len(every) - most} more' if len(every) > most else ''
    return ', '.join(every[:most]) + more


def risk_in_words(risk: float) -> str:
    """Return a probability of two digits, never rounded up to certainty."""
    return '>0.99' if risk > _NEARLY_CERTAIN else f'{risk:.2f}'


def percent_down(share: float) -> str:
    """Return a share in %, never rounded up to all."""
    return f'{math.floor(1000.0 * share) / 10.0:g} %'

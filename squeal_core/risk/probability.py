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

"""Probability that squeal occurs at an operating point, of all modes and of each."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal


@dataclass(frozen=True)
class ModeRisk:
    """
    Probability that one mode of the band is unstable, to first order.

    Parameters
    ----------
    index : int
        Number of the mode at the operating point, by frequency.
    frequency_hz, growth_rate : float
        Of the mode there [Hz], [1/s].
    probability : float
        [-].

    """

    index: int
    frequency_hz: float
    growth_rate: float
    probability: float


@dataclass(frozen=True, eq=False, repr=False)
class Risk:
    """
    Probability of squeal at an operating point.

    Parameters
    ----------
    probability : float
        Probability that at least one mode in the band is unstable [-].
    error : float
        Largest error of the operating map at its check points [-]; NaN to first order.
    basis : str
        'precomputed': from the operating map; 'first order': by the tangent at the point;
        'certain': no input is uncertain.
    named : callable
        Returns `modes`; they cost more than all the rest and are computed when asked for.

    """

    probability: float
    error: float
    basis: Literal['precomputed', 'first order', 'certain']
    named: Callable[[], tuple[ModeRisk, ...]] = tuple

    @cached_property
    def modes(self) -> tuple[ModeRisk, ...]:
        """Modes that may be unstable, the most probable first, each to first order."""
        return self.named()

    def _values(self) -> tuple[object, ...]:
        return self.probability, self.error, self.basis, self.modes

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Risk) and self._values() == other._values()

    def __hash__(self) -> int:
        return hash(self._values())

    def __repr__(self) -> str:
        return f'Risk{self._values()!r}'

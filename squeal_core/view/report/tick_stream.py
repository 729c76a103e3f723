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

"""The ticks of a table, brake by brake, as the page's accumulators take them."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray
from squeal_core.monitor.results.history_columns import HistoryBlock
from squeal_core.monitor.results.result_files import ReplayResult

COLUMNS = ('rotor_speed_rad_s', 'pressure_pa', 'friction', 'temperature_k', 'squeal_risk',
           'growth_rate_1_s', 'worst_frequency_hz', 'friction_margin')
BoolArray: TypeAlias = NDArray[np.bool_]

_AT_REST = ('released', 'not sliding')


class Ticks(NamedTuple):
    """
    Successive ticks of one brake.

    Parameters
    ----------
    brake : str
    numbers : dict
        Array of each of `COLUMNS`, and `time_s`.
    sliding : boolean array
        Where the brake is known to slide under load.
    unknown : boolean array
        Where the squeal risk is not known, though the brake is not known to be released or at
        rest.
    frequencies_hz, growth_rates : sequence of str
        Of the unstable modes, as written.

    """

    brake: str
    numbers: dict[str, FloatArray]
    sliding: BoolArray
    unknown: BoolArray
    frequencies_hz: Sequence[str]
    growth_rates: Sequence[str]


class Accumulator(Protocol):
    """Takes ticks and keeps data of a size that does not grow with them."""

    def add(self, ticks: Ticks) -> None:
        """Take further ticks of a brake."""


def accumulate(result: ReplayResult, into: Iterable[Accumulator]) -> None:
    """
    Read the table of a result once.

    Raises
    ------
    HistoryError
        For a table that cannot be read.

    """
    accumulators = list(into)
    for block in result.blocks(COLUMNS):
        for ticks in _by_brake(block):
            for one in accumulators:
                one.add(ticks)


def _by_brake(block: HistoryBlock) -> Iterator[Ticks]:
    states = np.array(block.states)
    brakes = np.array(block.brakes)
    sliding = states == 'steady'
    unknown = ~np.isin(states, _AT_REST) & np.isnan(block.numbers['squeal_risk'])
    for brake in dict.fromkeys(block.brakes):
        at = np.flatnonzero(brakes == brake)
        yield Ticks(brake, {name: values[at] for name, values in block.numbers.items()},
                    sliding[at], unknown[at], [block.frequencies_hz[i] for i in at.tolist()],
                    [block.growth_rates[i] for i in at.tolist()])

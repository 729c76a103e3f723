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

"""One input that a column of a table, or a channel of a measurement, gives."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
import math

from squeal_core.common.errors import short_repr
from squeal_core.monitor.inputs.reading import MissingValue, Sample
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.recordings.findings import Finding
from squeal_ros.recordings.signals.signals_file import SignalSource

_LONGEST_CELL = 30  # characters in a note


@dataclass
class InputColumn:
    """
    One input, and counts of its cells.

    Parameters
    ----------
    source : SignalSource
    read : callable
        Returns a number in the unit of the input.

    """

    source: SignalSource
    read: Callable[[float], float]
    values: int = 0
    empty: int = 0
    texts: int = 0
    first_text: str = ''  # in words, with its place

    @classmethod
    def of(cls, source: SignalSource, settings: MonitorSettings) -> 'InputColumn':
        """Return the input that settings with these signals have."""
        own = next(brake.inputs[source.signal] for brake in settings.brakes
                   if brake.name == source.brake)
        zero = settings.ambient_pressure if own.reference == 'absolute' else 0.0
        return cls(source, lambda value: own.scale * value + own.offset - zero)

    @property
    def name(self) -> str:
        """Return the input as findings name it."""
        return f'{self.source.brake}.{self.source.signal}'

    def sample(self, number: float | None, time: int, text: str, where: str
               ) -> tuple[str, Signal, Sample | MissingValue] | None:
        """
        Return the sample of a cell; None for a missing value.

        Parameters
        ----------
        number : float, optional
            That the cell holds; NaN: a missing value; None: it is a text.
        time : int
            [ns].
        text : str
            The cell.
        where : str
            It is, for notes.

        """
        brake, signal = self.source.brake, self.source.signal
        if number is None:
            self.texts += 1
            shown = short_repr(text.strip()[:_LONGEST_CELL])
            self.first_text = self.first_text or f'{shown} {where}'
            return brake, signal, MissingValue(f'{shown} is no number')
        if math.isnan(number):
            self.empty += 1
            return None
        self.values += 1
        return brake, signal, Sample(time, self.read(number))

    def notes(self) -> Iterator[str]:
        """Yield notes on missing values."""
        name = short_repr(self.source.name)
        if self.texts:
            yield (f'{self.name}: {self.texts} cells of {name} are no number, the first '
                   f'{self.first_text}: taken as missing')
        if self.empty and self.values:
            yield (f'{self.name}: {self.empty} of {self.values + self.empty + self.texts} '
                   f'cells of {name} are empty: taken as missing')


def without_values(columns: Iterable[InputColumn], remedy: str) -> list[Finding]:
    """Return a finding for each input that has no value."""
    return [Finding(
        (column.name,), f'{short_repr(column.source.name)} has no number in {column.texts} texts '
        f'and {column.empty} empty cells' + (
            f' (the first text is {column.first_text})' if column.texts else ''), remedy)
        for column in columns if not column.values]

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

"""Two columns of a table of times and speeds, in the locales and units that tables come in."""

from collections.abc import Callable, Iterable, Iterator
import csv
from dataclasses import dataclass
import re

from squeal_core.common.errors import SquealError

TIME, SPEED = 'time_s', 'speed_m_s'  # how errors and docs name the columns
_TIMES = {'s': 1.0, 'ms': 1e-3, 'min': 60.0}
_SPEEDS = {'m_s': 1.0, 'km_h': 1.0 / 3.6, 'kmh': 1.0 / 3.6, 'kph': 1.0 / 3.6, 'mph': 0.44704}
_TIME_NAMES = ('time', 't', 'zeit')
_SPEED_NAMES = ('speed', 'v', 'velocity', 'vehicle_speed', 'geschwindigkeit')
_COMMENTS = ('#', '//', '%')
_DELIMITERS = ';\t,'

Refuse = Callable[[int, str, str], SquealError]


@dataclass(frozen=True)
class Column:
    """Column of a quantity: its number, its name in the file, and its unit in SI units."""

    number: int
    name: str
    factor: float

    def own(self, value: float) -> float:
        """Return a number in SI units as the file has it."""
        return float(f'{value / self.factor:.12g}')

    def said(self, value: float) -> str:
        """Return name and value of a number in SI units, as the file has them."""
        return f'{self.name} = {self.own(value)}'


class CycleTable:
    """
    The rows of a table of times and speeds.

    The first line that is no comment names the columns, `time_s` and `speed_m_s`, `speed_km_h` or
    `speed_mph` (also as "Speed [km/h]"), in any order and among others; semicolons, tabs or commas
    are between them. Where it is no comma, numbers may have decimal commas.

    Parameters
    ----------
    lines : iterable of str
    refuse : callable
        Given line, what is wrong and the remedy, returns the error.

    """

    def __init__(self, lines: Iterable[str], refuse: Refuse) -> None:
        self._refuse = refuse
        self._lines = iter(lines)
        self._before, header = self._header()
        self._delimiter = next((one for one in _DELIMITERS if one in header), ',')
        names = [cell.strip().strip('"') for cell in header.split(self._delimiter)]
        self.time = self._column(names, TIME, _TIME_NAMES, _TIMES)
        self.speed = self._column(names, SPEED, _SPEED_NAMES, _SPEEDS)

    def rows(self) -> Iterator[tuple[int, float, float]]:
        """Yield line, time [s] and speed [m/s] of each row."""
        reader = csv.reader(('' if _is_comment(line) else line for line in self._lines),
                            delimiter=self._delimiter)
        for cells in reader:
            if any(cell.strip() for cell in cells):
                line = self._before + reader.line_num
                yield (line, self._number(line, cells, self.time),
                       self._number(line, cells, self.speed))

    def _header(self) -> tuple[int, str]:
        """Return the line number and the text of the header; '' without one."""
        number = 0
        for number, line in enumerate(self._lines, 1):
            if line.strip() and not _is_comment(line):
                return number, line
        return max(number, 1), ''

    def _column(self, names: list[str], usual: str, quantities: tuple[str, ...],
                units: dict[str, float]) -> Column:
        known = {f'{quantity}_{unit}': factor for quantity in quantities
                 for unit, factor in units.items()}
        plain = [re.sub('[^a-z0-9]+', '_', name.casefold()).strip('_') for name in names]
        result = [i for i, name in enumerate(plain) if name in known]
        if not result:
            others = ', '.join(name for name in known if name.startswith(quantities[0]))
            raise self._refuse(self._before, f'no column {usual!r} in {names}',
                               'the first line must name the columns, such as '
                               f'{TIME},{SPEED}; known are {others}')
        if len(result) > 1:
            raise self._refuse(self._before, f'{names[result[1]]!r} says again what '
                               f'{names[result[0]]!r} says', 'keep one of the columns')
        return Column(result[0], names[result[0]], known[plain[result[0]]])

    def _number(self, line: int, cells: list[str], column: Column) -> float:
        text = cells[column.number].strip() if column.number < len(cells) else ''
        try:
            return column.factor * float(
                text if self._delimiter == ',' else text.replace(',', '.'))
        except ValueError:
            raise self._refuse(line, f'{column.name} = {text!r} is no number',
                               'write a decimal number or remove the line') from None


def _is_comment(line: str) -> bool:
    return line.lstrip('\ufeff \t"').startswith(_COMMENTS)

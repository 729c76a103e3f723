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

"""Assessments over time as a table: rows to and from CSV."""

from collections.abc import Callable, Iterator, Sequence
import csv
import math
from pathlib import Path
from typing import Any, IO, NamedTuple

from squeal_core.common.bounded_reader import bounded_lines, open_bounded
from squeal_core.common.errors import SquealError
from squeal_core.monitor.assessment import Assessment, VALID

MAX_BYTES = 50_000_000_000  # rows are read one by one
MAX_LINE = 100_000  # characters


class HistoryError(SquealError):
    """A table of assessments that cannot be read."""


class AssessmentRecord(NamedTuple):
    """
    One assessment of one brake; the fields are the CSV's columns, NaN where not known.

    Mode numbers are of the modes of `unstable_frequencies_hz`, and of that at `worst_frequency_hz`
    (0: not known). `incomplete`: a part of the brake application is not known.
    """

    time_s: float
    brake: str
    state: str
    rotor_speed_rad_s: float
    pressure_pa: float
    friction: float
    squeal_risk: float
    instability_probability: float
    build_up_nepers: float
    time_to_squeal_s: float
    growth_rate_1_s: float
    damping_ratio: float
    worst_frequency_hz: float
    friction_margin: float
    unstable_frequencies_hz: tuple[float, ...]
    unstable_growth_rates_1_s: tuple[float, ...]
    reason: str
    temperature_k: float = math.nan
    risk_error: float = math.nan
    incomplete: bool = False
    worst_mode_number: int = 0
    mode_numbers: tuple[int, ...] = ()

    @property
    def is_valid(self) -> bool:
        """Return whether the brake was assessed, as of `Assessment`."""
        return self.state in VALID


_COLUMNS = AssessmentRecord._fields
_PARSERS: dict[str, Callable[[str], Any]] = {
    **dict.fromkeys(('brake', 'state', 'reason'), str),
    **dict.fromkeys(('unstable_frequencies_hz', 'unstable_growth_rates_1_s'),
                    lambda text: tuple(map(float, text.split()))),
    'incomplete': lambda text: bool(int(text)), 'worst_mode_number': int,
    'mode_numbers': lambda text: tuple(map(int, text.split()))}


def row_of(assessment: Assessment) -> AssessmentRecord:
    """Return an assessment as a row."""
    temperature, risk = assessment.inputs.get('temperature'), assessment.risk_result
    return AssessmentRecord(  # without names, which take longer than the record
        assessment.time * 1e-9, assessment.brake, assessment.state,
        assessment.inputs['rotor_speed'].value, assessment.inputs['pressure'].value,
        assessment.friction, assessment.risk, assessment.instability_probability,
        assessment.build_up, assessment.time_to_squeal, assessment.growth_rate,
        assessment.damping_ratio, assessment.worst_frequency_hz, assessment.friction_margin,
        assessment.unstable_frequencies_hz, assessment.unstable_growth_rates, assessment.reason,
        temperature.value if temperature and temperature.is_believed else math.nan,
        risk.result.error if risk else math.nan, bool(risk and risk.result.incomplete),
        assessment.worst_mode_number, assessment.mode_numbers)


class CsvWriter:
    """Writes rows as they come."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file
        self._writer = csv.writer(file, lineterminator='\n')
        self._writer.writerow(_COLUMNS)

    def write(self, row: AssessmentRecord) -> None:
        """Write the row of a brake at a tick."""
        (time, brake, state, *numbers, frequencies, growth_rates, reason, temperature, error,
         incomplete, worst, modes) = row
        texts = f'{brake}{state}{reason}'
        # csv looks at each character for what it quotes and takes ten times as long
        quick = not ('"' in texts or '\r' in texts or '\n' in texts or ',' in brake)
        fields = (repr(time), brake, state, *map(repr, numbers), ' '.join(map(repr, frequencies)),
                  ' '.join(map(repr, growth_rates)),
                  f'"{reason}"' if quick and ',' in reason else reason, repr(temperature),
                  repr(error), '1' if incomplete else '0', repr(worst), ' '.join(map(repr, modes)))
        if quick:
            self._file.write(f'{",".join(fields)}\n')
        else:
            self._writer.writerow(fields)


def read_rows(path: str | Path) -> Iterator[AssessmentRecord]:
    """
    Yield the rows of a CSV file.

    Raises
    ------
    HistoryError
        Naming file, line and what is wrong.

    """
    try:
        with open_bounded(path, MAX_BYTES, _file_error) as file:
            reader = csv.reader(bounded_lines(file, MAX_LINE, lambda line: HistoryError(
                f'{path}: line {line}: has more than {MAX_LINE} characters; give a table that '
                '`squeal replay` wrote'), encoding='utf-8'))
            if tuple(columns := next(reader, [])) != _COLUMNS:
                raise HistoryError(f'{path}: its columns are {columns}; '
                                   f'give a table that `squeal replay` wrote')
            for values in reader:
                if values:
                    yield _parse(path, reader.line_num, values)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise HistoryError(f'{path}: cannot be read ({error}); check the path') from None


def _file_error(where: object, what: str, remedy: str) -> HistoryError:
    return HistoryError(f'{where}: {what}; {remedy}')


def _parse(path: str | Path, line: int, values: Sequence[str]) -> AssessmentRecord:
    try:
        return AssessmentRecord(*[
            _PARSERS.get(name, float)(text) for name, text in zip(_COLUMNS, values, strict=True)])
    except ValueError as error:
        raise HistoryError(f'{path}: line {line}: {error}; mend or leave out the line') from None

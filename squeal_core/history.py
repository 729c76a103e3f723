"""Assessments over time as a table: rows to and from CSV, and the squeal events in them."""

from collections.abc import Iterable, Iterator, Sequence
import csv
from dataclasses import dataclass
import math
from pathlib import Path
from typing import IO

from squeal_core.errors import SquealError
from squeal_core.monitor import Assessment


class HistoryError(SquealError):
    """A table of assessments that cannot be read."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One assessment of one brake; the fields are the CSV's columns, NaN where not known."""

    time_s: float
    brake: str
    state: str
    rotor_speed_rad_s: float
    pressure_pa: float
    friction: float
    squeal_risk: float
    growth_rate_1_s: float
    worst_frequency_hz: float
    friction_margin: float
    unstable_frequencies_hz: tuple[float, ...]
    unstable_growth_rates_1_s: tuple[float, ...]
    reason: str


_TEXTS = ('brake', 'state', 'reason')
_LISTS = ('unstable_frequencies_hz', 'unstable_growth_rates_1_s')
_COLUMNS = tuple(Row.__dataclass_fields__)


def row_of(assessment: Assessment) -> Row:
    """Return an assessment as a row."""
    return Row(
        time_s=assessment.time * 1e-9, brake=assessment.brake, state=assessment.state,
        rotor_speed_rad_s=assessment.inputs['rotor_speed'].value,
        pressure_pa=assessment.inputs['pressure'].value, friction=assessment.friction,
        squeal_risk=assessment.risk, growth_rate_1_s=assessment.growth_rate,
        worst_frequency_hz=assessment.worst_frequency_hz,
        friction_margin=assessment.friction_margin,
        unstable_frequencies_hz=tuple(m.frequency_hz for m in assessment.flutter),
        unstable_growth_rates_1_s=tuple(m.growth_rate for m in assessment.flutter),
        reason=assessment.reason)


class CsvWriter:
    """Writes rows as they come."""

    def __init__(self, file: IO[str]) -> None:
        self._writer = csv.writer(file, lineterminator='\n')
        self._writer.writerow(_COLUMNS)

    def write(self, row: Row) -> None:
        values = dict(row.__dict__)
        values.update((name, ' '.join(map(repr, values[name]))) for name in _LISTS)
        self._writer.writerow(values[name] for name in _COLUMNS)


def read_rows(path: str | Path) -> Iterator[Row]:
    """Yield the rows of a CSV file.

    Raises
    ------
    HistoryError
        Naming file, line and what is wrong.
    """
    try:
        with open(path, encoding='utf-8', newline='') as file:
            reader = csv.DictReader(file)
            if tuple(reader.fieldnames or ()) != _COLUMNS:
                raise HistoryError(f'{path}: its columns are {reader.fieldnames}; '
                                   f'give a table that `squeal replay` wrote')
            for values in reader:
                yield _parse(path, reader.line_num, values)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise HistoryError(f'{path}: cannot be read ({error}); check the path') from None


def _parse(path: str | Path, line: int, values: dict[str, str]) -> Row:
    try:
        lists = {name: tuple(map(float, values.pop(name).split())) for name in _LISTS}
        parsed = {name: value if name in _TEXTS else float(value)
                  for name, value in values.items()}
    except (TypeError, ValueError, AttributeError) as error:
        raise HistoryError(f'{path}: line {line}: {error}; mend or leave out the line') from None
    return Row(**parsed, **lists)  # type: ignore[arg-type]


@dataclass(frozen=True)
class SquealEvent:
    """An unbroken stretch in which a brake's squeal was probable.

    Parameters
    ----------
    brake : str
    start, end : float
        First and last such assessment [s].
    peak_risk : float
    growth_rate : float
        Largest in the event [1/s].
    frequency_hz : float
        Of the mode with that growth rate.
    """

    brake: str
    start: float
    end: float
    peak_risk: float
    growth_rate: float
    frequency_hz: float


def squeal_events(rows: Iterable[Row], *, risk: float = 0.5) -> list[SquealEvent]:
    """Return the events in which the risk stays at or above a level, by time of start."""
    events: list[SquealEvent] = []
    open_rows: dict[str, list[Row]] = {}
    for row in rows:
        if row.squeal_risk >= risk:
            open_rows.setdefault(row.brake, []).append(row)
        elif row.brake in open_rows:
            events.append(_event(open_rows.pop(row.brake)))
    events.extend(_event(rest) for rest in open_rows.values())
    return sorted(events, key=lambda event: (event.start, event.brake))


def _event(rows: Sequence[Row]) -> SquealEvent:
    def growth(row: Row) -> float:
        return -math.inf if math.isnan(row.growth_rate_1_s) else row.growth_rate_1_s

    worst = max(rows, key=growth)
    return SquealEvent(rows[0].brake, rows[0].time_s, rows[-1].time_s,
                       max(row.squeal_risk for row in rows), worst.growth_rate_1_s,
                       worst.worst_frequency_hz)

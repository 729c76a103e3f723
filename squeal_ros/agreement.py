"""Live against replayed assessments of the same drive."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

from squeal_core.history import Row


@dataclass(frozen=True)
class Agreement:
    """How far two records of one drive are the same.

    The tables of the engine are laid down by the samples seen, so numbers are equal bit for bit
    until an assessment saw another sample or was made in one record only; from there on they
    differ within their error.

    Parameters
    ----------
    compared, same_inputs, equal : int
        Assessments in both records; those that saw the same samples; those of them with equal
        risk, growth rates, frequencies and margin.
    parted_at : float
        Time from which the records saw different samples while sliding [s]; infinite if never.
    before, equal_before : int
        As `same_inputs` and `equal`, before that time.
    largest_difference : float
        Of the risk, over all compared [-].
    """

    compared: int
    same_inputs: int
    equal: int
    parted_at: float
    before: int
    equal_before: int
    largest_difference: float

    @property
    def in_words(self) -> str:
        late = self.compared - self.same_inputs
        parted = '' if math.isinf(self.parted_at) else (
            f'; until {self.parted_at:g} s, where a sample came late or a tick was lost, '
            f'{self.equal_before} of {self.before}')
        return (f'replay of the recorded inputs: {self.compared} assessments, {self.equal} of '
                f'{self.same_inputs} with the same samples equal bit for bit{parted}; {late} saw '
                f'a neighbouring sample; largest difference of risk {self.largest_difference:.2g}')


def agreement(live: Sequence[Row], replayed: Sequence[Row]) -> Agreement:
    """Compare row by row. Inputs may differ by one sample where a message came late."""
    first, second = ({(round(row.time_s, 6), row.brake): row for row in rows}
                     for rows in (live, replayed))
    pairs = [(first[key], second[key]) for key in first if key in second]
    same = [(a, b) for a, b in pairs if _inputs(a) == _inputs(b)]
    equal = [a for a, b in same if _numbers(a) == _numbers(b)]
    parted_at = min((time for time, brake in first.keys() | second.keys()
                     if _parted(first.get((time, brake)), second.get((time, brake)))),
                    default=math.inf)
    return Agreement(
        len(pairs), len(same), len(equal), parted_at,
        sum(a.time_s < parted_at for a, _ in same), sum(a.time_s < parted_at for a in equal),
        max((abs(a.squeal_risk - b.squeal_risk) for a, b in pairs
             if a.state == b.state and not math.isnan(a.squeal_risk)), default=0.0))


def _parted(a: Row | None, b: Row | None) -> bool:
    """Whether one brake's engine was asked for something else, or nothing, in one record."""
    sliding = 'steady' in {row.state for row in (a, b) if row is not None}
    return sliding and (a is None or b is None or _inputs(a) != _inputs(b))


def _inputs(row: Row) -> str:
    return repr((row.state, row.rotor_speed_rad_s, row.pressure_pa, row.friction))


def _numbers(row: Row) -> str:
    return repr(replace(row, time_s=0.0, reason=''))

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

"""The live table of a drive, and the summary of its squeal events."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
import math
import sys
from typing import Any

try:
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.live import Live
    from rich.table import Table
    from rich.text import Text
except ImportError as error:
    raise ImportError("tables need rich: pip install -e '.[view]' in the checkout") from error

from squeal_core.common.wording import risk_in_words
from squeal_core.monitor.results.history import AssessmentRecord
from squeal_core.monitor.results.squeal_events import SquealEvent

_UNKNOWN = '-'


def drive_console() -> Console:
    """Return a console as wide as the terminal, or 99 columns where there is none."""
    return Console(width=None if sys.stdout.isatty() else 99, highlight=False)


class DriveDisplay:
    """
    Shows the present rows: redrawn in place on a terminal, else a block now and then.

    Parameters
    ----------
    console : rich.console.Console
    title : str
    warning : float
        Risk from which a row is red [-].
    block_period : float
        Time of the drive between two blocks where there is no terminal [s].

    """

    def __init__(self, console: Console, title: str, *, warning: float = 0.5,
                 block_period: float = 30.0) -> None:
        self._console = console
        self._title = title
        self._warning = warning
        self._block_period = block_period
        self._next_block = -math.inf
        self._live: Live | None = None

    def update(self, time: float, vehicle_speed: float, rows: Sequence[AssessmentRecord],
               ticks_done: int, ticks_lost: int) -> None:
        """Show one tick; time in s, vehicle speed in m/s."""
        caption = f'ticks done {ticks_done}, lost {ticks_lost}'
        if self._live is not None:
            self._live.update(self._table(time, vehicle_speed, rows, caption))
        elif time >= self._next_block:
            self._next_block = time + self._block_period
            self._console.print(self._table(time, vehicle_speed, rows, caption))

    @contextmanager
    def running(self) -> Iterator['DriveDisplay']:
        """Take the terminal for as long as the drive lasts."""
        if not self._console.is_terminal:
            yield self
            return
        with Live(console=self._console, refresh_per_second=8) as self._live:
            yield self
        self._live = None

    def _table(self, time: float, vehicle_speed: float, rows: Sequence[AssessmentRecord],
               caption: str) -> Table:
        table = Table(box=SIMPLE_HEAD, pad_edge=False, collapse_padding=True,
                      title=f'{self._title}   t = {time:6.1f} s   {vehicle_speed * 3.6:5.1f} km/h',
                      title_justify='left', caption=caption, caption_justify='left')
        table.add_column('brake', no_wrap=True)
        for name in ('pressure\nbar', 'mu', 'squeal\nrisk', 'build-up\nnepers', 'mode\nHz',
                     'growth\n1/s'):
            table.add_column(name, justify='right', no_wrap=True, min_width=5)
        table.add_column('state', min_width=11)
        table.add_column('reason', overflow='fold')
        for row in rows:
            table.add_row(*_cells(row), style=_style(row, self._warning))
        return table


def events_table(events: Sequence[SquealEvent], *, most: int = 12) -> Table:
    """Return the longest events as a table, in order of time."""
    shown = sorted(sorted(events, key=lambda e: e.start_s - e.end_s)[:most],
                   key=lambda e: (e.start_s, e.brake))
    table = Table(title=f'Squeal events: {len(events)}'
                  + (f', the {most} longest' if len(events) > most else ''),
                  title_justify='left')
    for name in ('from s', 'to s', 'brake', 'peak risk', 'mode Hz', 'growth 1/s'):
        table.add_column(name, justify='left' if name == 'brake' else 'right')
    for e in shown:
        table.add_row(f'{e.start_s:.1f}', f'{e.end_s:.1f}', e.brake, risk_in_words(e.peak_risk),
                      f'{e.frequency_hz:.0f}', f'{e.growth_rate_1_s:+.1f}')
    return table


def _cells(row: AssessmentRecord) -> tuple[str | Text, ...]:
    return (row.brake, _number(row.pressure_pa / 1e5, '.1f'), _number(row.friction, '.3f'),
            _UNKNOWN if math.isnan(row.squeal_risk) else risk_in_words(row.squeal_risk),
            _number(row.build_up_nepers, '.1f'),
            _number(row.worst_frequency_hz, '.0f'),
            _number(row.growth_rate_1_s, '+.1f'), row.state, Text(_reason(row)))


def _reason(row: AssessmentRecord) -> str:
    """Return the reason of a row, without what other columns show."""
    return row.reason.partition('; ')[2] if row.state == 'steady' else row.reason


def _number(value: float, form: str) -> str:
    return _UNKNOWN if math.isnan(value) else format(value, form)


def _style(row: AssessmentRecord, warning: float) -> Any:
    if row.state in ('stale', 'invalid', 'outside validated range'):
        return 'magenta'
    return 'bold red' if row.squeal_risk >= warning else ''

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

"""What a report reduces and counts, against plain loops, scipy and a published example."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import binomtest
from squeal_core.monitor.fleet_files import FleetBrake
from squeal_core.monitor.history import HistoryError, read_rows
from squeal_core.monitor.history_columns import read_blocks
from squeal_core.view.report.application_shares import difference, exceedance, shares, wilson
from squeal_core.view.report.envelope import CURVES, MOST_POINTS, StretchEnvelope
from squeal_core.view.report.fleet_groups import Group
from squeal_core.view.report.tick_stream import Ticks
from support.drive_results import SyntheticDrive
from support.rows import each

COLUMNS = ('pressure_pa', 'squeal_risk', 'temperature_k')


def ticks_of(time: Any, values: Any, unknown: Any) -> Ticks:
    numbers = {'time_s': time, **dict.fromkeys(CURVES, values)}
    modes = ['3000.0 1500.0' if place % 2 else '' for place in range(len(time))]
    return Ticks('left', numbers, ~unknown, unknown, modes,
                 ['2.0 1.0' if one else '' for one in modes])


def test_blocks_are_the_rows(tmp_path: Path) -> None:
    table = SyntheticDrive(200.0, brakes=('left', 'right')).write(tmp_path / 'a') / 'table.csv'
    rows = list(read_rows(table))
    blocks = list(read_blocks(table, COLUMNS, rows=300))
    assert len(blocks) == 14
    for name in ('time_s', *COLUMNS):
        found = np.concatenate([block.numbers[name] for block in blocks])
        np.testing.assert_array_equal(found, [getattr(row, name) for row in rows])
    assert [brake for block in blocks for brake in block.brakes] == [row.brake for row in rows]
    assert [tuple(map(float, text.split())) for block in blocks for text in block.frequencies_hz
            ] == [row.unstable_frequencies_hz for row in rows]


@each('line', ['1.0,"le,ft",steady,2.0,"a, b"', '1.0,"le,ft",steady,2.0,c', '',
               '1.0,"le,ft",steady,,"a ""b"""'])
def test_blocks_of_quoted_and_empty_cells(tmp_path: Path, line: str) -> None:
    table = tmp_path / 'table.csv'
    table.write_text(f'time_s,brake,state,pressure_pa,reason\n{line}\n')
    rows = [row for block in read_blocks(table, COLUMNS) for row in zip(
        block.brakes, block.numbers['pressure_pa'], block.numbers['temperature_k'], strict=True)]
    assert [row[0] for row in rows] == ['le,ft'] * bool(line)
    assert all(np.isnan(row[2]) for row in rows)


@each(('text', 'words'), [
    ('time_s,brake\n', 'no column state'), ('', 'no column time_s, brake, state'),
    ('time_s,brake,state\n1.0,left,steady\nabc,left,steady\n', 'lines 2 to 3: '),
    ('time_s,brake,state\n1.0\n', 'lines 2 to 2: ')])
def test_bad_tables(tmp_path: Path, text: str, words: str) -> None:
    table = tmp_path / 'table.csv'
    table.write_text(text)
    with pytest.raises(HistoryError, match=words):
        list(read_blocks(table, COLUMNS))


@each('count', [50, MOST_POINTS, MOST_POINTS + 1, 30_011])
def test_envelopes_keep_minima_and_maxima(count: int) -> None:
    rng = np.random.default_rng(count)
    time, values = 1.7e9 + np.arange(count) / 10.0, rng.normal(size=count)
    values[rng.random(count) < 0.2] = np.nan
    unknown = np.isnan(values)
    envelope = StretchEnvelope(time[0], time[-1], 10.0, time[0])
    for part in np.array_split(np.arange(count), 7):
        envelope.add(ticks_of(time[part], values[part], unknown[part]))
    curve = envelope.curve('left', 'squeal_risk')
    assert len(curve.value) <= MOST_POINTS
    assert (np.nanmin(curve.value), np.nanmax(curve.value)) == (
        np.nanmin(values), np.nanmax(values))
    step = envelope.width
    for place in np.flatnonzero(~unknown)[:: max(1, count // 500)]:
        near = np.abs(curve.start + curve.step * np.arange(len(curve.value))
                      - (time[place] - time[0])) <= 0.75 * step + 0.06
        assert np.nanmin(curve.value[near]) <= values[place] <= np.nanmax(curve.value[near])
    covered = envelope.stretches(envelope.brakes['left'].unknown)
    assert all(((covered[:, 0] <= t + 0.06) & (t <= covered[:, 1] + 0.06)).any()
               for t in (time - time[0])[unknown][:300])
    assert set(envelope.modes()[:, 1]) == {1500.0, 3000.0}
    assert len(envelope.modes()) <= MOST_POINTS


@each(('hits', 'trials'), [(0, 5), (5, 5), (3, 28), (71, 136)])
def test_intervals_are_those_of_scipy(hits: int, trials: int) -> None:
    expected = binomtest(hits, trials).proportion_ci(0.95, method='wilson')
    assert wilson(hits, trials)[1:] == pytest.approx((expected.low, expected.high), abs=1e-6)


def test_the_difference_of_shares_is_newcombes() -> None:
    # Stat. Med. 17 (1998), table II, example (a), method 10: 56/70 minus 48/80
    assert difference((48, 80), (56, 70)) == pytest.approx((0.2, 0.0524, 0.3339), abs=5e-5)


def test_shares_of_classes() -> None:
    found = shares([1.0, 4.0, 6.0, np.nan], [True, False, True, True], np.array([0.0, 5.0, 10.0]))
    assert found.counts.tolist() == [2, 1]
    assert found.share.tolist() == [0.5, 1.0]
    level, share = exceedance([3.0, np.nan, 1.0])
    assert (level.tolist(), share.tolist()) == ([1.0, 3.0], [1.0, 0.5])


def test_a_risk_that_is_not_known_hides_no_larger_one() -> None:
    """Whichever recording of a group comes first."""
    for risks in ((0.2, 0.5, np.nan), (np.nan, 0.5, 0.2)):
        group = Group()
        for risk in risks:
            group.add(FleetBrake('fl', 1.0, 1.0, 1.0, 1, 1, 0, 0, risk))
        assert group.peak_risk == 0.5

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
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.stats import binomtest
from squeal_core.monitor.results.fleet_files import FleetBrake, FleetLabel
from squeal_core.monitor.results.history import HistoryError, read_rows
from squeal_core.monitor.results.history_columns import read_blocks
from squeal_core.view.report.application_shares import (
    Alarms,
    difference,
    exceedance,
    share_of_brakings,
    shares,
    wilson,
)
from squeal_core.view.report.envelope import CURVES, MOST_POINTS, StretchEnvelope
from squeal_core.view.report.fleet_groups import Group, read_fleet
from squeal_core.view.report.runs import load_runs
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
    assert difference(Alarms(48, 80, 80), Alarms(56, 70, 70)) == pytest.approx(
        (0.2, 0.0524, 0.3339), abs=5e-5)


def test_intervals_cover_the_truth_where_the_brakes_of_a_vehicle_squeal_together() -> None:
    """Of 500 drives of 40 brakings; brakes taken as independent cover it in two of three."""
    squeals = np.random.default_rng(4).random((500, 40)) < 0.3
    hits = 4 * squeals.sum(axis=1)
    _, low, high = share_of_brakings(hits, 160, 40)
    assert 0.93 < np.mean((low <= 0.3) & (high >= 0.3)) < 0.98
    _, low, high = wilson(hits, 160)
    assert np.mean((low <= 0.3) & (high >= 0.3)) < 0.75
    assert np.isnan(share_of_brakings(0, 0, 0)).all()


def test_shares_of_classes() -> None:
    values, hits = [1.0, 4.0, 6.0, np.nan, 4.5], [True, False, True, True, True]
    edges = np.array([0.0, 5.0, 10.0])
    found = shares(values, hits, [0, 0, 1, 2, 3], edges)
    assert found.counts.tolist() == [3, 1]
    assert found.share.tolist() == [2 / 3, 1.0]
    assert found.low.tolist() == wilson([4 / 3, 1], [2, 1])[1].tolist()
    found = shares(values, hits, [0, 0, 1, 2, 3], edges, of_all=True)
    assert found.share.tolist() == [2 / 5, 1 / 5]
    assert found.high.tolist() == wilson([8 / 5, 4 / 5], 4)[2].tolist()
    level, share = exceedance([3.0, np.nan, 1.0])
    assert (level.tolist(), share.tolist()) == ([1.0, 3.0], [1.0, 0.5])


def test_a_risk_that_is_not_known_hides_no_larger_one() -> None:
    """Whichever recording of a group comes first."""
    for risks in ((0.2, 0.5, np.nan), (np.nan, 0.5, 0.2)):
        group = Group()
        for risk in risks:
            group.add(FleetBrake('fl', 1.0, 1.0, 1.0, 1, 1, 0, 0, risk), 1)
        assert group.peak_risk == 0.5


def test_brakes_that_are_applied_at_once_are_one_braking(tmp_path: Path) -> None:
    """In a drive's page and in a fleet's: by vehicle, over all, by brake and by region."""
    for seed, name in enumerate(('a', 'b')):
        SyntheticDrive(120.0, seed=seed, name=name).write(tmp_path / name)
    run = load_runs([tmp_path])[0]
    stops = len({one.start_s for one in run.known})
    assert len(run.known) == 8 * stops > 0  # at the same times in two recordings
    assert np.unique(run.known_brakings).size == 2 * stops
    tables: dict[str, Any] = {'recordings': [], 'brakes': [], 'applications': []}
    for result in run.results:
        label = FleetLabel(result.name, 'car')
        known = [one for one in result.applications if one.alarm is not None]
        hits = sum(bool(one.alarm) for one in known)
        tables['recordings'].append((label, SimpleNamespace(
            copy_of='', braking_s=1.0, risk_known_s=1.0, applications=len(known),
            applications_known=len(known), applications_with_alarm=hits, peak_risk=0.9)))
        tables['brakes'] += [(label, FleetBrake(
            brake, 1.0, 1.0, 1.0, stops, stops, 0, 0, 0.9)) for brake in run.brakes]
        tables['applications'] += [(label, one) for one in result.applications]
    fleet = read_fleet(cast(Any, SimpleNamespace(rows=tables.__getitem__)))
    assert fleet.total.known_alarms == fleet.vehicles['car'].known_alarms == Alarms(
        len(run.squealing), 8 * stops, 2 * stops)
    assert {one.known_alarms.brakings for one in fleet.brakes.values()} == {2 * stops}
    for one in fleet.regions.values():
        assert one.known / 4 <= one.brakings <= one.known
    assert min(one.brakings / one.known for one in fleet.regions.values() if one.known) == 0.5


def test_a_region_is_of_both_directions(tmp_path: Path) -> None:
    """As is the brake: from 75 rad/s forwards and backwards, at one pressure."""
    SyntheticDrive(15.0, brakes=('fl',), name='a').write(tmp_path / 'a')
    one, = load_runs([tmp_path])[0].known
    back = one._replace(rotor_speed_rad_s=-one.rotor_speed_rad_s, start_s=one.start_s + 60.0,
                        end_s=one.end_s + 60.0)
    rows: dict[str, Any] = {'applications': [(FleetLabel('a', 'car'), each) for each in (
        one, back)], 'recordings': [], 'brakes': []}
    (region, group), = read_fleet(cast(Any, SimpleNamespace(
        rows=rows.__getitem__))).regions.items()
    assert region.speed == 7
    assert (group.applications, group.brakings) == (2, 2)

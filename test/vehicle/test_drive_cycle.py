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

"""Drive cycles: interpolation against known shapes and published figures, and error texts."""

from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.integrate import trapezoid
from squeal_core.vehicle.drive_cycle import DriveCycle, DriveCycleError, read_drive_cycle

CYCLES = Path(__file__).parents[2] / 'config' / 'drive_cycles'


def _cycle(time: list[float], speed: list[float]) -> DriveCycle:
    return DriveCycle('x', np.array(time), np.array(speed))


@pytest.mark.parametrize(('name', 'duration', 'distance', 'top_speed_kmh'), [
    ('us06', 600.0, 12888.0, 129.2),      # EPA: 8.01 miles, 80.3 mph
    ('wltc_3b', 1800.0, 23266.0, 131.3),  # UN GTR 15: 23.27 km, 131.3 km/h
])
def test_shipped_cycle_has_the_published_figures(
        name: str, duration: float, distance: float, top_speed_kmh: float) -> None:
    cycle = read_drive_cycle(CYCLES / f'{name}.csv')
    time, speed, _ = cycle.sample(10.0)
    assert cycle.name == name
    assert cycle.duration == duration
    # 0.1 %: distances are published to four digits, from sums of 1 Hz samples.
    assert trapezoid(speed, time) == pytest.approx(distance, rel=1e-3)
    assert 3.6 * speed.max() == pytest.approx(top_speed_kmh, abs=0.1)  # printed to 0.1


def test_gap_of_the_recorded_trip_is_bridged_at_rest() -> None:
    cycle = read_drive_cycle(CYCLES / 'chicago_trip.csv')
    assert np.diff(cycle.time).max() == 32.0
    time, speed, acceleration = cycle.sample(100.0)
    gap = (time > 552.0) & (time < 584.0)
    assert np.all(speed[gap] == 0.0)
    assert np.all(acceleration[gap] == 0.0)


def test_samples_are_met_and_spacing_is_the_rate() -> None:
    cycle = read_drive_cycle(CYCLES / 'us06.csv')
    time, speed, _ = cycle.sample(100.0)
    assert time.shape == (60001,)
    assert time[-1] == 600.0
    # Rounding of values up to 36 m/s and times up to 600 s.
    np.testing.assert_allclose(speed[::100], cycle.speed, atol=1e-12)
    np.testing.assert_allclose(np.diff(time), 0.01, rtol=0.0, atol=1e-12)


def test_acceleration_is_the_slope_of_speed_and_continuous() -> None:
    cycle = read_drive_cycle(CYCLES / 'us06.csv')
    largest_jump = []
    for rate in (100.0, 200.0):
        _, speed, acceleration = cycle.sample(rate)
        # Trapezoid against exact slope: the error is step^2 / 12 * |d2a/dt2| * step per step, with
        # |d2a/dt2| at most 12 * 3.8 m/s over 1 s^3 for a cubic: 4e-6 m/s at 100 Hz.
        change = 0.5 * (acceleration[1:] + acceleration[:-1]) / rate
        np.testing.assert_allclose(np.diff(speed), change, rtol=0.0, atol=4e-6)
        largest_jump.append(np.abs(np.diff(acceleration)).max())
    # A continuous function's largest step halves with the sampling step; a jump would stay.
    assert largest_jump[1] == pytest.approx(0.5 * largest_jump[0], rel=0.05)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.floats(0.1, 30.0), st.integers(0, 60000).map(lambda mm: mm / 1e3)),
                min_size=2, max_size=20),
       st.floats(0.5, 50.0))
def test_speed_never_leaves_the_range_of_its_neighbours(
        rows: list[tuple[float, float]], rate: float) -> None:
    steps, speeds = zip(*rows, strict=True)
    cycle = DriveCycle('any', np.cumsum(steps), np.array(speeds))
    time, speed, _ = cycle.sample(rate)
    left = np.clip(np.searchsorted(cycle.time, time, side='right') - 1, 0, len(rows) - 2)
    low = np.minimum(cycle.speed[left], cycle.speed[left + 1])
    high = np.maximum(cycle.speed[left], cycle.speed[left + 1])
    assert np.all(speed >= 0.0)
    # Rounding of speeds up to 60 m/s; the cubic's coefficients grow with 1 / step^2 = 100.
    assert np.all((speed >= low - 1e-10) & (speed <= high + 1e-10))


def test_sampling_starts_at_the_first_time_and_stays_within_the_trace() -> None:
    time, speed, _ = _cycle([5.0, 6.0, 7.25], [1.0, 2.0, 3.0]).sample(2.0)
    np.testing.assert_array_equal(time, [5.0, 5.5, 6.0, 6.5, 7.0])
    assert speed[0] == 1.0


def test_arrays_are_read_only_copies() -> None:
    time = np.array([0.0, 1.0])
    cycle = DriveCycle('x', time, np.array([0.0, 1.0]))
    time[0] = 9.0
    assert cycle.time[0] == 0.0
    with pytest.raises(ValueError, match='read-only'):
        cycle.speed[0] = 1.0


@pytest.mark.parametrize('rate', [0.0, -1.0, float('nan'), float('inf')])
def test_rate_must_be_positive(rate: float) -> None:
    with pytest.raises(DriveCycleError, match=r'rate = .* positive number'):
        _cycle([0.0, 1.0], [0.0, 1.0]).sample(rate)


def test_columns_are_found_by_name_and_empty_lines_skipped(tmp_path: Path) -> None:
    path = tmp_path / 'trip.csv'
    path.write_text('\ufeffgear, speed_m_s ,time_s\r\n1,0.5,0\r\n\r\n2,1.5,1\r\n',
                    encoding='utf-8')
    cycle = read_drive_cycle(path)
    np.testing.assert_array_equal(cycle.time, [0.0, 1.0])
    np.testing.assert_array_equal(cycle.speed, [0.5, 1.5])
    assert (cycle.name, cycle.source) == ('trip', 'trip.csv')


@pytest.mark.parametrize(('header', 'rows'), [
    ('time_s;speed_km_h', '0,0;0\n0,5;3,6\n# a note, of two parts\n1,5;7,2'),
    ('Zeit [s]\tgear\tGeschwindigkeit [km/h]', '0\t1\t0\n0,5\t1\t3,6\n\n1.5\t2\t7,2'),
    ('"Speed (km/h)","Time (s)"', '0,0\n3.6,0.5\n"7.2","1.5"'),
    ('t_ms;v_m_s', '0;0\n500;1\n1500;2,0')])
def test_tables_of_other_locales_and_units(tmp_path: Path, header: str, rows: str) -> None:
    path = tmp_path / 'bench.csv'
    path.write_text(f'\ufeff# recorded; on a bench, 20 °C\n#\n{header}\n{rows}\n',
                    encoding='utf-8')
    cycle = read_drive_cycle(path)
    np.testing.assert_allclose(cycle.time, [0.0, 0.5, 1.5])
    np.testing.assert_allclose(cycle.speed, [0.0, 1.0, 2.0])


@pytest.mark.parametrize(('text', 'parts'), [
    ('', ['line 1', "no column 'time_s'", 'must name']),
    ('time_s,speed\n0,0\n1,1\n', ['line 1', "no column 'speed_m_s'", 'speed_km_h']),
    ('#a\ntime_s;speed_m_s;v_km_h\n0;0;0\n', ['line 2', "'v_km_h' says again what 'speed_m_s'"]),
    ('# a\n\ntime_s;speed_km_h\n0,0;0\n1;1.000,5\n', ['line 5', "speed_km_h = '1.000,5'"]),
    ('time_s,speed_km_h\n0,0\n"1,5",1\n', ['line 3', "time_s = '1,5' is no number"]),
    ('time_s,speed_m_s\n0,0\n1,fast\n', ['line 3', "speed_m_s = 'fast'", 'decimal number']),
    ('time_s,speed_m_s\n0,0\n1\n', ['line 3', "speed_m_s = ''", 'remove the line']),
    ('time_s,speed_m_s\n0,0\n\n1,nan\n', ['line 4', 'speed_m_s = nan', 'remove the line']),
    ('time_s;speed_km_h\n0;0\n1;nan\n', ['line 3', 'speed_km_h = nan is not finite']),
    ('time_s,v_kph\n0,0\n1,-10\n', ['line 3', 'v_kph = -10.0 is negative']),
    ('time_s,speed_m_s\n0,0\ninf,1\n', ['line 3', 'time_s = inf', 'remove the line']),
    ('time_s,speed_m_s\n0,0\n1,-0.5\n', ['line 3', 'speed_m_s = -0.5', 'magnitude']),
    ('time_s,speed_m_s\n0,0\n2,1\n2,1\n', ['line 4', 'time_s = 2.0', 'after 2.0', 'sort']),
    ('time_s,speed_m_s\n0,0\n', ['1 rows', 'at least two']),
    ('time_s,speed_m_s\n', ['0 rows', 'at least two']),
])
def test_error_names_file_line_value_and_remedy(
        tmp_path: Path, text: str, parts: list[str]) -> None:
    path = tmp_path / 'bad.csv'
    path.write_text(text, encoding='utf-8')
    with pytest.raises(DriveCycleError) as caught:
        read_drive_cycle(path)
    for part in ['bad.csv', *parts]:
        assert part in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_table_that_cannot_be_read(tmp_path: Path) -> None:
    for path in (tmp_path / 'none.csv', tmp_path):
        with pytest.raises(DriveCycleError, match='(cannot be|is a folder).*; give .* wltc_3b$'):
            read_drive_cycle(path)


def test_bytes_that_are_no_text_are_reported_with_their_line(tmp_path: Path) -> None:
    path = tmp_path / 'bad.csv'
    path.write_bytes(b'time_s,speed_m_s\n0,0\n1,\xff\xfe\n')
    with pytest.raises(DriveCycleError, match='line 3: speed_m_s'):
        read_drive_cycle(path)


@pytest.mark.parametrize(('time', 'speed', 'match'), [
    ([0.0, 1.0], [0.0], 'same length'),
    ([], [], 'at least two'),
    ([0.0], [0.0], 'at least two'),
    ([0.0, 1.0, 0.5], [0.0, 1.0, 1.0], r"'x', sample 2: time_s = 0.5"),
])
def test_arrays_are_checked_too(time: list[float], speed: list[float], match: str) -> None:
    with pytest.raises(DriveCycleError, match=match):
        _cycle(time, speed)


@pytest.mark.parametrize(('rows', 'words'), [
    ('0,0\n60,130', 'speed_m_s reaches 130 m/s; usual is up to 100 m/s: check it (130 km/h'),
    ('0,0\n1,20', 'changes by 20 m/s^2'), ('0,20\n1,0', 'changes by 20 m/s^2')])
def test_traces_in_other_units_are_doubted(tmp_path: Path, rows: str, words: str) -> None:
    path = tmp_path / 'c.csv'
    path.write_text(f'time_s,speed_m_s\n{rows}\n')
    said: list[str] = []
    read_drive_cycle(path, warn=said.append)
    assert len(said) == 1
    assert words in said[0]


@pytest.mark.parametrize('rows', ['0,0\n60,400', '0,0\n2000000,10'])
def test_traces_of_no_vehicle_are_refused(tmp_path: Path, rows: str) -> None:
    path = tmp_path / 'c.csv'
    path.write_text(f'time_s,speed_m_s\n{rows}\n')
    with pytest.raises(DriveCycleError, match=r'reaches .* m/s and lasts .* s; give speed_m_s'):
        read_drive_cycle(path)

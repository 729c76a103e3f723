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

"""Sweeps against solves at single points; their files; interrupts and workers; pictures."""

from dataclasses import replace
import json
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
from typing import Any

from matplotlib import rc_context
import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint, SquealError
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.output import OutputError
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.stability.mode_tracking import identities
from squeal_core.stability.parameter_paths import moved, PARAMETERS
from squeal_core.studies.sweep import sweep
from squeal_core.studies.sweep_file import load_sweep, RECORDS, save_sweep, SweepFileError
from squeal_core.studies.sweep_record import make_sweep, Sweep
from squeal_core.view.locus_plot import plot_growth_rates, plot_loci
from squeal_core.view.stability_map import conditions, plot_growth_map, plot_stability_map

SKEW = np.array([[0.0, 1e-3], [-1e-3, 0.0]])
# K = diag(w^2) + mu k_c SKEW: flutter from mu = 0.202 on at POINT
PAIR = BrakeModel(angular_frequencies=[1e4, 1.02e4], damping_ratios=[1e-4, 1e-4 / 1.02],
                  friction_couple=SKEW, nominal_contact_stiffness=1e10,
                  gyroscopic=1e-3 * SKEW, radial_dissipation=1e-4 * np.eye(2))
POINT = OperatingPoint(rotor_speed=5.0, friction=0.1, contact_pressure=1e5, contact_stiffness=1e10)
FRICTIONS = [0.0, 0.1, 0.3, 0.6]


def at(model: BrakeModel, speed: float = 5.0) -> OperatingPoint:
    return OperatingPoint(rotor_speed=speed, friction=0.42, contact_stiffness=0.35e11,
                          contact_pressure=2000.0 / model.contact_area)


def same(one: Sweep, other: Sweep) -> bool:
    return all(np.array_equal(getattr(one, name), getattr(other, name), equal_nan=name[0] != 'k'
                              and name != 'identities')
               for name in ('points', 'eigenvalues', 'kinds', 'identities')) and (
        one.about == other.about and list(one.axes) == list(other.axes)
        and all(np.array_equal(one.axes[k], other.axes[k]) for k in one.axes))


# ---------------------------------------------------------------- values

def test_one_parameter(kang: BrakeModel) -> None:
    """K09 fig. 10 in small: every mode at every stiffness, those that grow marked."""
    values = np.array([0.2, 1.0, 1.6]) * 0.35e11
    found = sweep(kang, at(kang), {'contact_stiffness': values})
    assert found.complete
    assert found.shape == (3,)
    for i, value in enumerate(values):
        modes = complex_modes(kang, replace(at(kang), contact_stiffness=value)).modes
        assert found.eigenvalues[i].tolist() == [m.eigenvalue for m in modes]
        assert found.kinds[i].tolist() == [m.kind for m in modes]
        assert found.frequencies_hz[i].tolist() == [m.frequency_hz for m in modes]
        assert found.unstable[i].tolist() == [m.unstable for m in modes]
        assert found.identities[i].tolist() == [str(m.index) for m in modes]
    assert np.flatnonzero(found.unstable[1]).tolist() == [12, 25]
    assert found.column('contact_stiffness').tolist() == values.tolist()
    assert found.column('friction').tolist() == [0.42] * 3


def test_two_parameters() -> None:
    """The last one runs fastest."""
    speeds = [2.0, 8.0]
    found = sweep(PAIR, POINT, {'rotor_speed': speeds, 'friction': FRICTIONS})
    assert found.shape == (2, 4)
    growth = found.largest_growth()
    for i, speed in enumerate(speeds):
        for j, friction in enumerate(FRICTIONS):
            there = replace(POINT, rotor_speed=speed, friction=friction)
            assert growth[i, j] == max(m.growth_rate for m in complex_modes(PAIR, there).modes)
            assert found.points[4 * i + j].tolist() == [
                getattr(there, name) for name in PARAMETERS]
    assert (growth > 0.0).tolist() == [[False, False, True, True]] * 2
    assert np.all(np.isneginf(found.largest_growth(1.0, 2.0)))


def test_fast_is_within_a_tenth(kang: BrakeModel) -> None:
    """Every mode, over a grid across which modes begin to grow; most answers from few anchors."""
    start = at(kang, 20.0)
    axes = {'rotor_speed': np.linspace(10.0, 14.0, 9),
            'contact_pressure': start.contact_pressure * np.linspace(0.8, 1.2, 9)}
    told: list[int] = []
    found = sweep(kang, start, axes, fast=True, progress=lambda done, _: told.append(done))
    whole = sweep(kang, start, axes)
    assert found.about['fast']
    assert not whole.about['fast']
    assert told == list(range(1, 82))
    allowed = np.maximum(0.1, -0.02 * whole.eigenvalues.real)
    oscillate = whole.eigenvalues.imag > 1.0
    assert np.all((np.abs(found.eigenvalues - whole.eigenvalues) <= allowed)[oscillate])
    assert np.array_equal(found.kinds, whole.kinds)
    assert np.array_equal(found.identities, whole.identities)
    assert np.mean(found.eigenvalues == whole.eigenvalues) < 0.5  # no full solves in disguise


@pytest.mark.parametrize('options', [{'tracked': True}, {'workers': 2}])
def test_fast_has_no_vectors_and_one_process(options: dict[str, Any]) -> None:
    with pytest.raises(SquealError, match=f'leave {next(iter(options))} off'):
        sweep(PAIR, POINT, {'friction': FRICTIONS}, fast=True, **options)


def test_fast_without_friction_or_rotation() -> None:
    """Few points, and coefficients that vanish: full solves, and the same numbers."""
    for options in ({}, {'rotation': False}):
        found, whole = (sweep(PAIR, POINT, {'friction': FRICTIONS}, fast=fast, **options)
                        for fast in (True, False))
        assert found.eigenvalues == pytest.approx(whole.eigenvalues, abs=1e-6)
        assert found.kinds.tolist() == whole.kinds.tolist()


def test_without_rotation(kang: BrakeModel) -> None:
    """G, R and S off; not so without the option."""
    still = replace(kang, gyroscopic=None, radial_dissipation=None, negative_slope=None)
    point = replace(at(kang), friction_slope=-0.05)
    values = {'friction': [0.3, 0.5]}
    found = sweep(kang, point, values, rotation=False)
    assert same(replace(found, about={}), replace(sweep(still, point, values), about={}))
    assert not np.array_equal(found.eigenvalues, sweep(kang, point, values).eigenvalues)
    assert found.about['rotation'] is False


def test_with_the_friction_law(kang: BrakeModel) -> None:
    """K09 fig. 15: speed sets friction and slope."""
    assert kang.caliper is not None
    found = sweep(kang, at(kang), {'rotor_speed': [2.0, 10.0]}, friction_law=True)
    for i, speed in enumerate((2.0, 10.0)):
        point = kang.operating_point(rotor_speed=speed,
                                     pressure=2000.0 / kang.caliper.piston_area)
        assert found.points[i] == pytest.approx([getattr(point, p) for p in PARAMETERS], rel=1e-12)
    torsion = found.eigenvalues.real[:, 11]
    assert torsion[0] > torsion[1] > 0.0
    assert (found.kinds[:, 0] == 'divergence').all()


def test_friction_takes_its_slope_along() -> None:
    point = replace(POINT, friction_slope=-0.1)
    found = sweep(PAIR, point, {'friction': FRICTIONS})
    assert found.column('friction_slope') == pytest.approx(-np.array(FRICTIONS), abs=1e-15)
    both = sweep(PAIR, point, {'friction_slope': [-0.3], 'friction': FRICTIONS})
    assert both.column('friction_slope').tolist() == [-0.3] * 4
    assert both.column('friction').tolist() == FRICTIONS


def test_tracked_identities(kang: BrakeModel) -> None:
    """K09 fig. 12: from no friction on, and merged without rotation."""
    values = np.linspace(0.0, 0.5, 6)
    found = sweep(kang, at(kang), {'friction': values}, tracked=True)
    assert found.identities[0].tolist() == [str(i) for i in range(1, 93)]
    assert found.identities[-1].tolist() == [
        str(i) for i in identities(kang, moved(kang, at(kang), 'friction', 0.5))]
    roots = found.of(13)
    assert np.abs(np.diff(roots)).max() < 40.0
    assert roots.real[0] < 0.0 < roots.real[-1]
    free = sweep(kang, at(kang), {'friction': values}, tracked=True, rotation=False)
    assert '13/14' in free.identities[-1]
    # of a merged pair the lower number is the one that grows
    assert free.of(13)[-1].real > 0.0 > free.of(14)[-1].real
    assert free.of(13)[-1].imag == pytest.approx(free.of(14)[-1].imag, rel=1e-4)
    assert np.isnan(free.of(93)).all()


def test_each_line_of_a_grid_is_tracked_by_itself() -> None:
    found = sweep(PAIR, POINT, {'contact_stiffness': [1e9, 1e10], 'friction': FRICTIONS},
                  tracked=True)
    assert found.identities.tolist() == [['1', '2']] * 6 + [['1/2', '1/2']] * 2


def test_slope_by_the_law_and_friction_as_given(kang: BrakeModel) -> None:
    """Expect mu' at each speed, scaled to the friction there; forwards and backwards alike."""
    assert isinstance(kang.friction_law, FrictionLaw)
    for way in (1.0, -1.0):
        found = sweep(kang, replace(at(kang), rotor_speed=way, friction=way * 0.42),
                      {'friction': way * np.array([0.2, 0.5]), 'rotor_speed': [way, 9.0 * way]},
                      friction_law='slope')
        assert found.column('friction').tolist() == [0.2 * way, 0.2 * way, 0.5 * way, 0.5 * way]
        for point, slope in zip(found.points, found.column('friction_slope'), strict=True):
            speed = abs(point[0]) * kang.contact_radius
            fall = 0.18 * np.exp(-speed)
            assert slope == pytest.approx(-fall / (0.32 + fall) * abs(point[1]), rel=1e-12)
    with pytest.raises(SquealError, match='it gives friction_slope'):
        sweep(kang, at(kang), {'friction_slope': [-0.1]}, friction_law='slope')


@pytest.mark.parametrize('first', [0.0, 0.3])
def test_a_merging_is_one_wherever_the_path_begins(first: float, kang: BrakeModel) -> None:
    """The third doublet without rotation: apart up to 0.348, one pair from there."""
    found = sweep(kang, at(kang), {'friction': [first, 0.33, 0.4, 0.5]}, tracked=True,
                  rotation=False)
    assert found.names(13).tolist() == ['13', '13', '13/14', '13/14']
    assert found.merged(14).tolist() == [False, False, True, True]
    assert found.names(93).tolist() == [''] * 4


@pytest.mark.parametrize(('axes', 'text'), [
    ({}, 'one or two'), ({'mu': [0.1]}, r"\['mu'\]"), ({'friction': []}, 'lists of values'),
    (dict.fromkeys(PARAMETERS[:3], [1.0]), 'one or two'), ({'friction': [[0.1]]}, 'shapes'),
    ({'rotor_speed': [0.0]}, 'rotor_speed is 0')])
def test_axes_that_cannot_be_meant(axes: dict[str, Any], text: str) -> None:
    with pytest.raises(SquealError, match=text):
        sweep(PAIR, POINT, axes)


def test_a_law_that_is_swept_over(kang: BrakeModel) -> None:
    with pytest.raises(SquealError, match='friction_law'):
        sweep(kang, at(kang), {'friction': [0.1]}, friction_law=True)
    with pytest.raises(SquealError, match='friction_law'):
        sweep(PAIR, POINT, {'rotor_speed': [1.0]}, friction_law=True)


# ---------------------------------------------------------------- progress, interrupts, workers

@pytest.mark.parametrize('tracked', [False, True])
def test_progress(tracked: bool) -> None:
    told: list[tuple[int, int]] = []
    sweep(PAIR, POINT, {'friction': FRICTIONS}, tracked=tracked,
          progress=lambda *counts: told.append(counts))
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]


def interrupted(count: int, **options: Any) -> Sweep:
    def progress(done: int, _: int) -> None:
        if done == count:
            raise KeyboardInterrupt

    values = {'friction': np.linspace(0.0, 0.9, 20)}
    return sweep(PAIR, POINT, values, progress=progress, **options)


@pytest.mark.parametrize('tracked', [False, True])
def test_an_interrupt_keeps_what_is_done(tracked: bool) -> None:
    found = interrupted(7, tracked=tracked)
    whole = sweep(PAIR, POINT, {'friction': np.linspace(0.0, 0.9, 20)}, tracked=tracked)
    assert not found.complete
    assert found.done.tolist() == [True] * 7 + [False] * 13
    assert np.array_equal(found.eigenvalues[:7], whole.eigenvalues[:7])
    assert np.array_equal(found.identities[:7], whole.identities[:7])
    assert np.isnan(found.eigenvalues[7:]).all()
    assert (found.kinds[7:] == '').all()
    assert np.isnan(found.largest_growth()).tolist() == (~found.done).tolist()
    assert np.isnan(found.of(1)).tolist() == (~found.done).tolist()


def test_an_interrupt_keeps_a_part_of_a_line_that_is_tracked() -> None:
    """A line is not divided among workers, so they would keep all of it or nothing."""
    found = interrupted(7, tracked=True, workers=2)
    assert found.done.tolist() == [True] * 7 + [False] * 13


def test_an_interrupt_ends_workers() -> None:
    found = interrupted(3, workers=2)
    assert 3 <= found.done.sum() < 20
    whole = sweep(PAIR, POINT, {'friction': np.linspace(0.0, 0.9, 20)})
    assert found.eigenvalues[found.done] == pytest.approx(whole.eigenvalues[found.done], rel=1e-12)


SCRIPT = """
import os
import numpy as np
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.studies.sweep import sweep
if __name__ == '__main__':
    kang = BrakeModel.load('kang2009')
    point = OperatingPoint(rotor_speed=5.0, friction=0.42, contact_stiffness=0.35e11,
                           contact_pressure=2000.0 / kang.contact_area)
    axes = {'rotor_speed': [5.0, 20.0], 'friction': np.linspace(0.0, 0.5, 3)}
    before = dict(os.environ)
    for tracked in (False, True):
        one, two = (sweep(kang, point, axes, tracked=tracked, workers=n) for n in (0, 2))
        assert two.complete
        print(one.eigenvalues.tobytes() == two.eigenvalues.tobytes(),
              one.identities.tobytes() == two.identities.tobytes())
    print(before == dict(os.environ))
"""


def test_workers_equal_one_process_bit_for_bit(tmp_path: Path) -> None:
    script = tmp_path / 'script.py'
    script.write_text(SCRIPT)
    pinned = {**os.environ, 'OPENBLAS_NUM_THREADS': '1', 'OMP_NUM_THREADS': '1',
              'PYTHONPATH': str(Path(__file__).parents[2])}
    run = subprocess.run([sys.executable, script], env=pinned, capture_output=True, text=True,
                         timeout=600)
    assert run.stderr == ''
    assert run.stdout.split() == ['True'] * 5


LONG = """
import numpy as np
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.studies.sweep import sweep
if __name__ == '__main__':
    kang = BrakeModel.load('kang2009')
    point = OperatingPoint(rotor_speed=5.0, friction=0.42, contact_stiffness=0.35e11,
                           contact_pressure=2000.0 / kang.contact_area)
    found = sweep(kang, point, {'friction': np.linspace(0.0, 0.8, 20000)}, workers=2,
                  progress=lambda done, count: print(done, flush=True))
    print('kept', found.done.sum(), found.complete, flush=True)
"""


def test_ctrl_c_with_workers(tmp_path: Path) -> None:
    """It goes to all processes of the terminal; the parent returns its part, nobody complains."""
    script = tmp_path / 'script.py'
    script.write_text(LONG)
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True,
                          env={**os.environ, 'PYTHONPATH': str(Path(__file__).parents[2])},
                          stderr=subprocess.PIPE, start_new_session=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == '1\n'
        os.killpg(process.pid, signal.SIGINT)
        output, complaints = process.communicate(timeout=600)
    last = output.splitlines()[-1].split()
    assert (last[0], last[2]) == ('kept', 'False')
    assert 1 <= int(last[1]) < 20000
    assert complaints == ''


# ---------------------------------------------------------------- files

@pytest.fixture(scope='module', params=['whole', 'partial', 'grid'])
def record(request: pytest.FixtureRequest) -> Sweep:
    if request.param == 'grid':
        return sweep(PAIR, POINT, {'rotor_speed': [2.0, 8.0], 'friction': FRICTIONS})
    return interrupted(20 if request.param == 'whole' else 5, tracked=True)


@pytest.mark.parametrize('suffix', ['.npz', '.json', '.csv'])
def test_a_file_holds_the_record(suffix: str, record: Sweep, tmp_path: Path) -> None:
    path = tmp_path / f'sweep{suffix}'
    save_sweep(record, path)
    again = load_sweep(path)
    assert same(again, record)
    assert again.complete == record.complete
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    with pytest.raises(ValueError, match='read-only'):
        again.eigenvalues[0, 0] = 0.0


def test_files_are_plain(tmp_path: Path) -> None:
    record = interrupted(5)
    for suffix in ('.npz', '.json', '.csv'):
        save_sweep(record, tmp_path / f'a{suffix}')
    with np.load(tmp_path / 'a.npz', allow_pickle=False) as archive:
        assert archive['points'].shape == (20, 5)
    whole = json.loads((tmp_path / 'a.json').read_text(), parse_constant=pytest.fail)
    assert whole['schema'] == 1
    assert whole['growth_rates'][19] == [None, None]
    lines = (tmp_path / 'a.csv').read_text().splitlines()
    assert lines[0].startswith('# {"format": "squeal_ros sweep"')
    assert lines[1].split(',')[:2] == ['rotor_speed', 'friction']
    assert len(lines) == 2 + 20 * 2
    assert float(lines[2].split(',')[8]) == record.eigenvalues[0, 0].real


@pytest.mark.parametrize('suffix', ['.npz', '.json', '.csv'])
def test_damaged_files_are_refused_in_one_line(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f'sweep{suffix}'
    save_sweep(interrupted(20), path)
    whole = path.read_bytes()
    for content in (whole[:len(whole) // 2], b'', b'\x00\xff' * 40, b'[]', b'{}'):
        path.write_bytes(content)
        with pytest.raises(SweepFileError, match='is damaged or no sweep') as caught:
            load_sweep(path)
        assert str(path) in str(caught.value)
        assert '\n' not in str(caught.value)


@pytest.mark.parametrize(('changes', 'text'), [
    ({'schema': 2}, 'has schema 2; this version reads up to 1'), ({'schema': True}, 'schema True'),
    ({'format': 'other'}, 'no record of a sweep'), ({'kinds': [['odd', 'odd']] * 4}, 'kinds are'),
    ({'points': [[1.0] * 5] * 3}, '4 points by the axes'), ({'axes': {'mu': [1.0]}}, 'axes are'),
    ({'identities': [['1'] * 3] * 4}, '4 points by the axes'), ({'axes': None}, 'damaged')])
def test_contents_that_do_not_fit(changes: dict[str, Any], text: str, tmp_path: Path) -> None:
    path = tmp_path / 'sweep.json'
    save_sweep(sweep(PAIR, POINT, {'friction': FRICTIONS}), path)
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))
    with pytest.raises(SweepFileError, match=text):
        load_sweep(path)


def test_no_pickle_is_read(tmp_path: Path) -> None:
    path = tmp_path / 'sweep.npz'
    save_sweep(sweep(PAIR, POINT, {'friction': FRICTIONS}), path)
    with np.load(path) as archive:
        arrays = dict(archive)
    arrays['kinds'] = arrays['kinds'].astype(object)
    np.savez(path, **arrays)
    with pytest.raises(SweepFileError, match='array .* of object'):
        load_sweep(path)


def test_paths_that_cannot_be_meant(tmp_path: Path) -> None:
    record = sweep(PAIR, POINT, {'friction': FRICTIONS})
    with pytest.raises(SweepFileError, match='end it in .npz, .json or .csv'):
        save_sweep(record, tmp_path / 'sweep.pkl')
    with pytest.raises(SweepFileError, match=r'give a \.npz'):
        load_sweep(tmp_path / 'sweep')
    for suffix in RECORDS:
        with pytest.raises(OutputError, match='in a folder that does not exist'):
            save_sweep(record, tmp_path / 'no' / f'sweep{suffix}')
        save_sweep(record, tmp_path / f'sweep{suffix}', overwrite=False)
        with pytest.raises(OutputError, match='exists; give --force'):
            save_sweep(record, tmp_path / f'sweep{suffix}', overwrite=False)
        with pytest.raises(SweepFileError, match='does not exist|cannot be read'):
            load_sweep(tmp_path / f'none{suffix}')


def test_records_are_frozen() -> None:
    record = sweep(PAIR, POINT, {'friction': FRICTIONS})
    for array in (record.points, record.eigenvalues, record.kinds, record.axes['friction']):
        assert not array.flags.writeable
    with pytest.raises(ValueError, match='points by the axes'):
        make_sweep(axes=record.axes, points=record.points[:3], about={},
                   growth_rates=record.eigenvalues.real, kinds=record.kinds,
                   angular_frequencies=record.eigenvalues.imag, identities=record.identities)


# ---------------------------------------------------------------- pictures

def marks(svg: str) -> int:
    """Return the number of circles of a scatter plot."""
    groups = re.findall(r'<g id="PathCollection_1">(.*?)</g>\s*</g>', svg, re.DOTALL)
    return len(re.findall('<use', groups[0])) if groups else 0


def drawn(path: Path, plot: Any, *args: Any, **options: Any) -> str:
    with rc_context({'svg.fonttype': 'none'}):
        plot(*args, path, **options)
    return path.read_text(encoding='utf-8')


def test_map_of_stability(kang: BrakeModel, tmp_path: Path) -> None:
    """A circle for each mode that flutters below the frequency shown."""
    record = sweep(kang, at(kang), {'contact_stiffness': np.linspace(0.5, 1.5, 5) * 0.35e11})
    svg = drawn(tmp_path / 'map.svg', plot_stability_map, record, title='Fig. 10')
    expected = (record.kinds == 'flutter') & (record.frequencies_hz <= 8000.0)
    assert marks(svg) == expected.sum() > 8
    for text in ('contact stiffness  % of nominal', 'frequency  kHz', 'Fig. 10', 'Ω = 5 rad/s',
                 'µ = 0.42', 'growth rate of unstable modes  1/s'):
        assert text in svg
    low = drawn(tmp_path / 'low.svg', plot_stability_map, record, highest_hz=2000.0)
    assert marks(low) == ((record.kinds == 'flutter') & (record.frequencies_hz <= 2000.0)).sum()
    stable = drawn(tmp_path / 'none.svg', plot_stability_map, sweep(
        PAIR, POINT, {'friction': [0.0, 0.1]}))
    assert marks(stable) == 0


def test_a_map_hides_no_flutter_and_no_divergence(tmp_path: Path) -> None:
    high = replace(PAIR, angular_frequencies=[9e4, 9.002e4])
    record = sweep(high, POINT, {'friction': [0.0, 0.9, 1.0]})
    assert (record.kinds == 'flutter').sum() == 2
    assert record.frequencies_hz.min() > 14000.0
    svg = drawn(tmp_path / 'high.svg', plot_stability_map, record)
    assert marks(svg) == 2
    assert 'divergence' not in svg
    sliding = BrakeModel(angular_frequencies=[0.0, 1e4], negative_slope=np.diag([1e-3, 0.0]))
    svg = drawn(tmp_path / 'slide.svg', plot_stability_map, sweep(
        sliding, POINT, {'friction_slope': [-0.1, 0.0]}))
    assert 'divergence' in svg


def test_pictures_say_what_was_held(tmp_path: Path) -> None:
    """And nothing that goes without saying."""
    plain = conditions(sweep(PAIR, POINT, {'rotor_speed': [1.0, 2.0]}))
    assert plain == 'µ = 0.1, p₀ = 1 bar'
    point = replace(POINT, friction_slope=-0.05, contact_stiffness=0.7e10)
    assert conditions(sweep(PAIR, point, {'rotor_speed': [1.0, 2.0]})) == (
        'µ = 0.1, slope = -0.05 s/m, p₀ = 1 bar, stiffness 70%')
    assert 'slope in proportion to µ' in conditions(sweep(PAIR, point, {'friction': [0.1, 0.2]}))


def test_map_of_growth(tmp_path: Path) -> None:
    values = {'rotor_speed': [2.0, 5.0, 8.0], 'friction': FRICTIONS}
    svg = drawn(tmp_path / 'a.svg', plot_growth_map, sweep(PAIR, POINT, values))
    assert 'ContourSet' in svg or 'PathCollection' in svg  # the line of zero growth
    for text in ('rotor speed  rad/s', 'friction coefficient', 'largest growth rate'):
        assert text in svg
    values['friction'] = [0.4, 0.6]  # all grow
    svg = drawn(tmp_path / 'b.svg', plot_growth_map, sweep(PAIR, POINT, values))
    assert 'ContourSet' not in svg
    assert 'PathCollection' not in svg


def test_loci(tmp_path: Path) -> None:
    values = {'friction': np.linspace(0.0, 0.5, 6)}
    one, other = (sweep(PAIR, POINT, values, tracked=True, rotation=r) for r in (True, False))
    svg = drawn(tmp_path / 'a.svg', lambda path, **k: plot_loci(one, (1, 2), path, **k),
                without=other, title='Fig. 12')
    for text in ('mode 1', 'mode 2, without rotation', 'Re λ  1/s', 'Fig. 12', 'stroke-dasharray'):
        assert text in svg
    # of a merged pair no picture says which is which, and the legend says so once
    assert len(re.findall('>merged 1/2<', svg)) == 1
    alone = drawn(tmp_path / 'b.svg', lambda path: plot_loci(one, (1,), path))
    assert 'without rotation' not in alone
    assert 'mode 2' not in alone


def test_growth_rates_over_speed(kang: BrakeModel, tmp_path: Path) -> None:
    """Modes that flutter somewhere, and divergence in a panel of its own."""
    record = sweep(kang, at(kang), {'rotor_speed': [3.0, 5.0, 10.0]}, friction_law=True,
                   tracked=True)
    svg = drawn(tmp_path / 'a.svg', plot_growth_rates, record)
    legend = re.findall(r'>(\d+): (\d+) Hz<', svg)
    assert [number for number, _ in legend] == ['12', '13', '18', '26']
    assert float(legend[0][1]) == pytest.approx(1363.0, abs=3.0)
    assert 'divergence  1/s' in svg
    assert 'friction by its law of speed' in svg
    plain = drawn(tmp_path / 'b.svg', plot_growth_rates, sweep(
        PAIR, POINT, {'friction': FRICTIONS}, tracked=True))
    assert 'divergence' not in plain
    assert re.findall(r'>(\S+): \d+ Hz<', plain) == ['1/2']  # a merged pair is one


def test_a_part_can_be_drawn(tmp_path: Path) -> None:
    record = interrupted(5, tracked=True)
    for name, plot in (('map', plot_stability_map), ('rates', plot_growth_rates)):
        assert '5 of 20 points' in drawn(tmp_path / f'{name}.svg', plot, record)
    plot_growth_map(sweep(PAIR, POINT, {'rotor_speed': [2.0, 5.0], 'friction': [0.1]}),
                    tmp_path / 'line.png')
    assert (tmp_path / 'line.png').read_bytes().startswith(b'\x89PNG')

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

"""Studies over operation and design: against brakes built by hand; resumed; impossible ones."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.assembly.build import build_model
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.common.errors import BrakeDescriptionError, SquealError
from squeal_core.common.worker_processes import run_jobs
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.studies.design import BrakeDesign
from squeal_core.studies.point_options import PointOptions
from squeal_core.studies.study import Run, run_study
from squeal_core.studies.study_checkpoint import StudyCheckpoint
from squeal_core.studies.study_file import load_study, save_study
from squeal_core.studies.study_jobs import _models
from squeal_core.studies.study_record import Study
from squeal_core.studies.study_spec import StudySpec
from squeal_core.studies.study_tasks import CriticalTask, LocusTask, MapTask
from squeal_ros.cli.study_commands import study_lines
from support.brake_descriptions import edited
from support.sweeps import PAIR

SMALL: dict[str, Any] = {'disc_order': 2, 'pad_elements': (2, 4, 1), 'contact_points': 4}
OWN = {  # another brake than the shipped one
    'name': 'own', 'disc.rotor_thickness_mm': 12.0, 'disc.rotor_outer_radius_mm': 130.0,
    'disc.hat_wall_outer_radius_mm': 76.0, 'contact.inner_radius_mm': 84.0,
    'contact.outer_radius_mm': 124.0, 'contact.angle_deg': 50.0, 'disc.clamp_radius_mm': 34.0,
    'pads.young_modulus_gpa': 12.0, 'pads.density_kg_m3': 2800.0, 'modes.disc': 8, 'modes.pad': 8}
DESIGN = BrakeDesign(edited(OWN), 'own.yaml', settings=SMALL)
POINT = PointOptions(rotor_speed=6.0, friction=0.5, preload=1500.0)
HERE: Run = partial(run_jobs, workers=0)


def study_of(axes: dict[str, list[float]], task: Any = None, source: Any = DESIGN,
             point: PointOptions = POINT, **options: Any) -> StudySpec:
    return StudySpec(source=source, options=point, task=task or MapTask(), **options,
                     axes={name: np.array(values) for name, values in axes.items()})


@cache
def by_hand(angle: float, modulus: float) -> BrakeModel:
    """Build the brake with another contact angle [deg] and modulus [GPa] of the top pad."""
    content = edited({**OWN, 'contact.angle_deg': angle})
    pad = content['pads']
    content['pads'] = {'top': {**pad, 'young_modulus_gpa': modulus}, 'bottom': pad}
    return build_model(parse_brake(content), **SMALL)


def same(one: Study, other: Study) -> bool:
    return list(one.columns) == list(other.columns) and all(
        np.array_equal(values, other.columns[name], equal_nan=True)
        for name, values in one.columns.items())


def test_a_design_study_is_that_of_brakes_built_by_hand() -> None:
    """Whatever the order of the axes; one pad of a description of both; a brake that cannot be."""
    axes = {'friction': [0.3, 0.6], 'disc.hat_wall_thickness_mm': [7.5, 60.0],
            'contact.angle_deg': [45.0, 55.0], 'pads.top.young_modulus_gpa': [9.0, 14.0]}
    found = run_study(study_of(axes), HERE)
    assert found.shape == (2, 2, 2, 2)
    places = [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
    for i, place in enumerate(places):
        figures = {name: values[i] for name, values in found.columns.items()}
        if place['disc.hat_wall_thickness_mm'] == 60.0:
            assert figures['source'] == 3.0
            assert np.isnan(figures['growth_rate'])
            continue
        angle, modulus = place['contact.angle_deg'], place['pads.top.young_modulus_gpa']
        model = by_hand(angle, modulus)
        modes = complex_modes(model, replace(POINT, friction=place['friction']).at(model))
        worst = modes.least_stable(1250.0, 16000.0)[0]
        assert (figures['growth_rate'], figures['frequency_hz'], figures['mode']) == (
            pytest.approx(worst.growth_rate, rel=1e-9, abs=1e-9),
            pytest.approx(worst.frequency_hz, rel=1e-12), worst.index)
        assert figures['flutter_modes'] == sum(m.kind == 'flutter' for m in modes.unstable)
    told = found.about['impossible']
    assert {one['values']['disc.hat_wall_thickness_mm'] for one in told} == {60.0}
    assert sum(one['points'] for one in told) == 8
    assert 'hat_wall_thickness' in told[0]['reason']


def test_parts_that_no_parameter_touches_are_computed_once(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Discs and pads by themselves, on disk, too; the bits are those without a cache."""
    from squeal_core.modes.fe import axisymmetric, mode_cache
    solved: list[str] = []
    plain = mode_cache.remembered

    def counted(folder: Any, key: str, shape: Any, compute: Callable[[], Any]) -> Any:
        def solve() -> Any:
            solved.append(key)
            return compute()
        return plain(folder, key, shape, solve)

    monkeypatch.setattr(axisymmetric, 'remembered', counted)
    axes = {'disc.rotor_thickness_mm': [11.0, 12.0, 13.0], 'pads.young_modulus_gpa': [9.0, 14.0]}
    found = run_study(study_of(axes, cache=str(tmp_path)), HERE)
    assert len(solved) == len(set(solved)) == 3
    again = run_study(study_of({**axes, 'friction': [0.5]}, cache=str(tmp_path)), HERE)
    assert len(solved) == 3
    assert same(found, again)
    assert same(found, run_study(study_of(axes), HERE))


@pytest.mark.parametrize(('path', 'words'), [
    ('disc.rotor_thicknes_mm', 'did you mean disc.rotor_thickness_mm'),
    ('disc.rotor_thickness_m', 'did you mean disc.rotor_thickness_mm'),
    ('pads.left.thickness_mm', 'did you mean pads.thickness_mm'), ('disc', 'no number'),
    ('friction.temperature_table.friction', 'no number')])
def test_a_path_that_there_is_not(path: str, words: str) -> None:
    with pytest.raises(BrakeDescriptionError, match=words):
        DESIGN.check(path)


def test_no_brake_that_can_be() -> None:
    with pytest.raises(SquealError, match='0.012 m would be 12 mm'):
        run_study(study_of({'disc.rotor_thickness_mm': [0.012, 0.013]}), HERE)


def test_local_expansions_against_full_solutions(kang: BrakeModel) -> None:
    """Growth within the error that is stated; what they leave open is solved in full."""
    axes = {'friction': np.linspace(0.38, 0.42, 4), 'rotor_speed': np.linspace(9.0, 10.0, 4),
            'preload': [1900.0, 2100.0], 'contact_stiffness': np.linspace(3.3e10, 3.5e10, 3),
            'damping_scale': [1.0, 1.5]}
    spec = partial(study_of, {name: list(values) for name, values in axes.items()}, source=kang,
                   point=PointOptions(rotor_speed=5.0, friction=0.4))
    found, exact = (run_study(spec(task), HERE) for task in (MapTask(), MapTask(exact=True)))
    by_expansion = found.columns['source'] == 2.0
    assert by_expansion.mean() > 0.7
    assert (exact.columns['source'] == 1.0).all()
    off = np.abs(found.columns['growth_rate'] - exact.columns['growth_rate'])
    assert off.max() <= 0.1  # the tolerance of kang2009
    for name in ('mode', 'squeal_modes', 'flutter_modes', 'divergent_modes'):
        assert np.array_equal(found.columns[name], exact.columns[name])
    assert found.columns['frequency_hz'] == pytest.approx(exact.columns['frequency_hz'], rel=2e-5)
    assert found.about['counts']['full'] < 0.5 * found.size


def cut(jobs: int) -> Run:
    """Run so many jobs of points, then interrupt."""
    def run(function: Callable[..., Any], work: Any) -> Iterator[tuple[int, Any]]:
        for i, (key, job) in enumerate(work.items()):
            if i == jobs:
                raise KeyboardInterrupt
            yield key, function(*job)
    return run


def test_an_interrupted_study_goes_on_and_has_the_same_bits(tmp_path: Path) -> None:
    spec = study_of({'friction': list(np.linspace(0.1, 0.6, 60)), 'rotor_speed': list(
        np.linspace(1.0, 9.0, 60))}, MapTask(exact=True), PAIR)
    said: list[str] = []
    checkpoint = StudyCheckpoint(tmp_path / 'a.csv', spec.key, say=said.append)
    whole = run_study(spec, HERE)
    part = run_study(spec, cut(3), checkpoint=checkpoint)
    assert 0 < part.done.sum() < part.size
    damaged, *_ = sorted(checkpoint.folder.iterdir())
    damaged.write_bytes(damaged.read_bytes()[:100])
    again = run_study(spec, HERE, checkpoint=checkpoint)
    assert same(whole, again)
    assert ['computed again' in text for text in said] == [True, False]
    assert 'an earlier run: 2 of' in said[1]
    assert spec.key != replace(spec, law=True).key
    checkpoint.remove()
    assert list(tmp_path.iterdir()) == []


def test_loci_and_critical_values_at_every_point() -> None:
    axes = {'friction': [0.0, 0.1, 0.3], 'contact_stiffness': [0.8e10, 1.2e10]}
    loci = run_study(study_of(axes, LocusTask(numbers=(2,)), PAIR), HERE)
    for i, (friction, stiffness) in enumerate(product(*axes.values())):
        point = replace(POINT, friction=friction, contact_stiffness=stiffness).at(PAIR)
        modes = complex_modes(PAIR, point).modes
        assert loci.columns['growth_rate_2'][i] in [m.growth_rate for m in modes]
    assert loci.grid('merged_with_2')[:, 1].tolist() == [
        pytest.approx(np.nan, nan_ok=True), pytest.approx(np.nan, nan_ok=True), 1.0]
    found = run_study(study_of({'contact_stiffness': axes['contact_stiffness']}, CriticalTask(
        parameter='friction'), PAIR, replace(POINT, friction=0.1)), HERE)
    for i, stiffness in enumerate(axes['contact_stiffness']):
        point = replace(POINT, friction=0.1, contact_stiffness=stiffness).at(PAIR)
        assert found.columns['above'][i] == critical_value(
            PAIR, point, 'friction', (0.0, 1.0)).above.value


def test_a_critical_dimension_lies_between_brakes_of_opposite_verdict() -> None:
    path = 'pads.thickness_mm'
    found = run_study(study_of({'friction': [0.1]}, CriticalTask(parameter=path, bounds=(
        8.0, 12.0))), HERE)
    value = float(found.columns['below'][0])
    assert np.isnan(found.columns['above'][0])
    beside = study_of({path: [value - 0.01, value + 0.01]}, point=replace(POINT, friction=0.1))
    assert (run_study(beside, HERE).columns['growth_rate'] > 0.0).tolist() == [True, False]


def test_a_worker_reads_a_file_of_modes_again_that_has_changed(tmp_path: Path) -> None:
    """A worker of a cluster outlives one study, and the files of the brake."""
    design = BrakeDesign({'pads': {'modes_from': {'file': 'pad.unv'}}}, folder=tmp_path)
    found = []
    for text in ('one', 'one', 'two'):
        (tmp_path / 'pad.unv').write_text(text)
        found.append(_models(study_of({'friction': [0.1]}, source=design)))
    assert found[0] is found[1] is not found[2]


def test_a_parameter_with_the_name_of_a_figure(tmp_path: Path) -> None:
    """Both are in rows, files and the table."""
    axes = {'damping_ratio': [0.001, 0.01], 'friction': [0.5]}
    found = run_study(study_of(axes), HERE)
    save_study(found, tmp_path / 'a.csv')
    _, names, *rows = (tmp_path / 'a.csv').read_text().splitlines()
    cells = [dict(zip(names.split(','), row.split(','), strict=True)) for row in rows]
    assert [cell['brake.damping_ratio'] for cell in cells] == ['0.001', '0.01']
    assert [float(cell['damping_ratio']) for cell in cells] == found.columns[
        'damping_ratio'].tolist()
    assert len([*study_lines(found)]) == 3


def test_files(tmp_path: Path) -> None:
    found = run_study(study_of({'friction': [0.1, 0.5], 'rotor_speed': [2.0, 4.0]}, source=PAIR),
                      HERE)
    for suffix in ('.npz', '.csv', '.json'):
        save_study(found, tmp_path / f'a{suffix}')
    again = load_study(tmp_path / 'a.npz')
    assert same(found, again)
    assert list(again.axes) == ['friction', 'rotor_speed']
    _, names, *rows = (tmp_path / 'a.csv').read_text().splitlines()
    assert names.split(',')[:3] == ['friction', 'rotor_speed', 'growth_rate']
    assert [row.split(',')[:3] for row in rows] == [
        [repr(f), repr(s), repr(g)] for (f, s), g in zip(product(
            [0.1, 0.5], [2.0, 4.0]), found.columns['growth_rate'].tolist(), strict=True)]

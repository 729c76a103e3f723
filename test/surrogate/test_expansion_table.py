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

"""The table against full solutions: accuracy, tiling, arrays and single points, audit, file."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.errors import OperatingPointError, TableFileError
from squeal_core.stability.eigensolution import complex_modes, eigenvalues, Tolerances
from squeal_core.surrogate.cell_fit import samples
from squeal_core.surrogate.coverage_report import measure_coverage
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.full_solutions import FullSolutions
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_cell import TableTolerances
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_file import (
    cached_path,
    find_table,
    read_table,
    write_table,
)
from squeal_core.surrogate.tabulated_solver import TabulatedSolver
from squeal_ros.cli.main import main
from support.engine_models import random_model
from support.table_modes import modes_at

RANGES: dict[str, Any] = {'rotor_speed': (8.0, 20.0), 'preload': (1000.0, 2000.0),
                          'friction': (0.3, 0.45)}


@pytest.fixture(scope='module')
def model() -> BrakeModel:
    return random_model(10, 1, friction_law=FrictionLaw())


@pytest.fixture(scope='module')
def table(model: BrakeModel) -> ExpansionTable:
    return build_table(model, TableDomain.usual(model, **RANGES), tolerances=TableTolerances())


def places(table: ExpansionTable, count: int, seed: int = 5) -> Any:
    return table.domain.low + table.domain.width * np.random.default_rng(seed).random((count, 3))


def test_answers_are_within_their_bounds_of_full_solutions(
        model: BrakeModel, table: ExpansionTable) -> None:
    x = places(table, 200)
    points, limits = table.domain.points(model, x), Tolerances.of(model)
    found = table.evaluate(x, limits)
    assert found.answered.mean() > 0.99
    listed = found.listed()
    for place in np.flatnonzero(found.answered).tolist():
        ours, truth = listed[place], complex_modes(model, points[place], tolerances=limits)
        assert np.all(np.abs(ours.mode_eigenvalues - truth.mode_eigenvalues[
            ours.numbers - 1]) <= ours.errors + 1e-6)
        assert np.all(ours.errors <= table.tolerances.allowed(ours.mode_eigenvalues))
        omitted = np.setdiff1d(np.arange(model.size), ours.numbers - 1)
        oscillating = truth.mode_eigenvalues[omitted].imag > limits.oscillation
        assert np.all(truth.mode_eigenvalues[omitted].real[oscillating] < ours.omitted_below)
        assert [m.index for m in ours.unstable] == [m.index for m in truth.unstable]


def test_eigenvalues_alone_are_those_of_the_modes(
        model: BrakeModel, table: ExpansionTable) -> None:
    """Where a verdict hangs on an error, too."""
    x, limits = places(table, 50), Tolerances.of(model)
    modes = table.evaluate(x, limits)
    growth = float(modes.eigenvalues.real[0, :modes.counts[0]].max())
    found, answered = table.eigenvalues(x, limits)
    oscillating = np.where(found.imag > limits.oscillation, found, np.nan)
    listed = np.where(modes.eigenvalues.imag > limits.oscillation, modes.eigenvalues, np.nan)
    for ours, theirs in zip(oscillating[modes.answered], listed[modes.answered], strict=True):
        np.testing.assert_array_equal(np.sort(ours[~np.isnan(ours)]),
                                      np.sort(theirs[~np.isnan(theirs)]))
    level = replace(limits, growth=growth)
    assert answered[0]
    assert not table.evaluate(x, level).answered[0]
    np.testing.assert_array_equal(table.eigenvalues(x, level)[0], found)
    assert not table.eigenvalues(x + [np.log(5.0), 0.0, 0.0], limits)[1].any()


def test_modes_listed_together_are_those_of_each_point(
        model: BrakeModel, table: ExpansionTable) -> None:
    found = table.evaluate(places(table, 50), Tolerances.of(model, growth=-20.0))
    for ours, theirs in zip(found.listed(), (modes_at(found, i) for i in range(50)), strict=True):
        for name in ('nonoscillatory', 'oscillatory', 'mode_eigenvalues', 'errors', 'numbers'):
            np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))
        assert ours.unstable == theirs.unstable != ()


def test_cells_share_full_solutions(model: BrakeModel, table: ExpansionTable) -> None:
    solutions = FullSolutions(model, table.domain)
    x = places(table, 2)
    point = table.domain.points(model, x)[0]
    known = solutions.at(x[0], point)
    np.testing.assert_array_equal(known, eigenvalues(model, point))
    assert solutions.at(x[0] * (1.0 + 1e-15), point) is known
    assert solutions.at(x[1], point) is not known
    surface = [tuple(u) for u in samples().tolist() if max(map(abs, u)) == 1.0]
    assert {u for u in surface if u[2] == 1.0} == {
        (u, v, -w) for u, v, w in surface if w == -1.0}
    halved = {(u, v, 2.0 * w - 1.0) for u, v, w in surface if w >= 0.0}
    assert len(halved.intersection(surface)) > 20


def test_cells_tile_the_envelope(model: BrakeModel, table: ExpansionTable) -> None:
    assert len(table.cells) > 1
    report = measure_coverage(table, model, points=500, solved=0)
    assert report.gaps == 0.0
    assert report.overlap == 0.0
    x = places(table, 500)
    cells = table.locate(x)
    assert np.all(np.abs(x - table.centres[cells]) <= table.halves[cells] * (1.0 + 1e-9))
    corners = np.array([table.domain.low, table.domain.low + table.domain.width])
    assert np.all(table.locate(corners + [[1e-9], [-1e-9]]) >= 0)
    assert np.all(table.locate(corners + [[-1e-6], [1e-6]]) == -1)
    assert table.locate(np.full((1, 3), np.nan))[0] == -1


def test_points_have_the_same_bits_in_any_company(
        model: BrakeModel, table: ExpansionTable) -> None:
    x, limits = places(table, 60), Tolerances.of(model)
    found = table.evaluate(x, limits)
    for place in range(60):
        alone = table.evaluate(x[place:place + 1], limits)
        assert alone.cells[0] == found.cells[place]
        for name in ('eigenvalues', 'errors', 'numbers'):
            np.testing.assert_array_equal(getattr(alone, name)[0], getattr(found, name)[place])


def test_points_that_hang_on_the_error_are_solved_in_full(
        model: BrakeModel, table: ExpansionTable) -> None:
    point = table.domain.points(model, places(table, 1))[0]
    truth = complex_modes(model, point)
    worst = max(root.real for root in truth.mode_eigenvalues)
    limits = replace(Tolerances.of(model), growth=worst + 1e-9)
    solver = TabulatedSolver(model, table, limits=limits)
    np.testing.assert_array_equal(solver.solve(point).mode_eigenvalues,
                                  complex_modes(model, point, tolerances=limits).mode_eigenvalues)
    assert solver.statistics.full == 1


def test_points_that_leave_the_law_are_solved_in_full(
        model: BrakeModel, table: ExpansionTable) -> None:
    point = table.domain.points(model, places(table, 1))[0]
    backwards = replace(point, rotor_speed=-point.rotor_speed, friction=-point.friction)
    solver = TabulatedSolver(model, table)
    for off in (replace(point, friction_slope=0.9 * point.friction_slope),
                replace(point, contact_stiffness=1.01 * point.contact_stiffness),
                replace(point, rotor_speed=3.0), replace(point, friction=-point.friction),
                replace(point, damping_scale=1.01)):
        assert solver.solve(off).source == 'full'
    assert solver.solve(backwards).source == 'table'
    np.testing.assert_allclose(solver.solve(backwards).mode_eigenvalues,
                               solver.solve(point).mode_eigenvalues)


def test_the_audit_finds_a_wrong_cell_and_does_not_use_it_again(
        model: BrakeModel, table: ExpansionTable) -> None:
    series = [cell.series + 5.0 * np.eye(1, len(cell.series)).T for cell in table.cells]
    wrong = replace(table, cells=tuple(
        replace(cell, series=moved) for cell, moved in zip(table.cells, series, strict=True)))
    points = table.domain.points(model, places(table, 40))
    for solver in (alone := TabulatedSolver(model, wrong, audit_every=3),
                   TabulatedSolver(model, wrong, audit_every=3)):
        found = (solver.solve_all([points[i] for i in range(40)]) if solver is not alone
                 else [solver.solve(points[i]) for i in range(40)])
        first = [modes.source for modes in found].index('full', 2)
        cell = wrong.locate(places(table, 40))
        assert all(modes.source == 'full' for modes, there in zip(found, cell, strict=True)
                   if there == cell[first] and modes not in found[:first])
        assert solver.statistics.mismatches == solver.statistics.audits > 0
    good = TabulatedSolver(model, table, audit_every=3)
    good.solve_all([points[i] for i in range(40)])
    assert good.statistics.audits > 10
    assert good.statistics.mismatches == 0


def test_tables_of_points_have_only_their_cells(
        model: BrakeModel, table: ExpansionTable) -> None:
    points = table.domain.points(model, places(table, 40))
    some = build_table(model, table.domain, tolerances=table.tolerances, points=[points[0]])
    assert 0 < len(some.cells) < len(table.cells)
    assert TabulatedSolver(model, some).solve(points[0]).source == 'table'
    with pytest.raises(OperatingPointError, match='no point of 1'):
        build_table(model, table.domain, points=[replace(points[0], friction=0.9)])


def test_files_come_back_bit_for_bit_and_only_for_their_model(
        model: BrakeModel, table: ExpansionTable, tmp_path: Path) -> None:
    path = tmp_path / 'table.npz'
    write_table(table, model, path)
    read = read_table(path, model)
    assert (read.domain, read.tolerances, dict(read.about)) == (
        table.domain, table.tolerances, dict(table.about))
    x = places(table, 50)
    ours, theirs = (one.evaluate(x, Tolerances.of(model)) for one in (table, read))
    np.testing.assert_array_equal(ours.eigenvalues, theirs.eigenvalues)
    np.testing.assert_array_equal(ours.errors, theirs.errors)
    np.testing.assert_array_equal(ours.numbers, theirs.numbers)
    other = random_model(10, 1, friction_law=FrictionLaw(decay=2.0))
    with pytest.raises(TableFileError, match='another model.*squeal tabulate'):
        read_table(path, other)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(TableFileError, match='copy it again or build it'):
        read_table(path, model)


def test_a_stiffness_factor_is_that_of_a_stiffer_model(
        model: BrakeModel, table: ExpansionTable) -> None:
    domain = replace(table.domain, stiffness_factor=1.1, rotor_speed=(10.0, 12.0),
                     friction=(0.3, 0.34))
    stiff = build_table(model, domain, tolerances=table.tolerances)
    point = domain.points(model, places(stiff, 1))[0]
    assert point.contact_stiffness == pytest.approx(1.1 * model.nominal_contact_stiffness)
    found = TabulatedSolver(model, stiff).solve(point)
    assert found.source == 'table'
    truth = complex_modes(model, point)
    assert np.abs(found.mode_eigenvalues - truth.mode_eigenvalues[found.numbers - 1]).max() <= 0.1


def test_a_table_knows_contact_damping(model: BrakeModel, table: ExpansionTable) -> None:
    """Which moves eigenvalues by more than a table may be off."""
    viscous = replace(model, contact_retardation_time=8e-6)
    domain = replace(table.domain, rotor_speed=(10.0, 12.0), friction=(0.3, 0.34))
    found = TabulatedSolver(viscous, build_table(viscous, domain, tolerances=table.tolerances))
    assert found.table is not None
    for place in places(found.table, 5):
        point = domain.points(viscous, place[None])[0]
        ours, truth = found.solve(point), complex_modes(viscous, point)
        assert ours.source == 'table'
        own = truth.mode_eigenvalues[ours.numbers - 1]
        assert np.all(np.abs(ours.mode_eigenvalues - own) <= ours.errors + 1e-6)
        dry = complex_modes(model, point).mode_eigenvalues[ours.numbers - 1]
        assert np.abs(own - dry).max() > 10.0 * ours.errors.max()


@pytest.mark.parametrize(('option', 'values'), [('--friction', ['0.3', '0.4']),
                                                ('--stiffness-factor', ['1.1'])])
def test_the_cache_keeps_only_tables_of_the_usual_envelope(
        option: str, values: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['tabulate', 'kang2009', option, *values]) == 2
    assert f'{option}: give an --output too' in capsys.readouterr().err


def test_the_command_line_builds_a_table_and_shows_it(
        model: BrakeModel, tmp_path: Path, capsys: pytest.CaptureFixture[str],
        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    path, table = tmp_path / 'model.npz', tmp_path / 'table.npz'
    model.save(path)
    assert find_table(model) is None
    assert main(['tabulate', str(path), '-o', str(table), '--workers', '0', '--rotor-speed', '10',
                 '11', '--preload', '1000', '1100', '--friction', '0.3', '0.32',
                 '--tolerance', '0.1', '--no-growth']) == 0
    assert 'answers 100.00% of 20000 random points' in capsys.readouterr().out
    assert main(['info', str(table)]) == 0
    assert 'rotor speed      10 to 11 rad/s' in capsys.readouterr().out
    cached = cached_path(model)
    cached.parent.mkdir(parents=True)
    table.rename(cached)
    found = find_table(model)
    assert found is not None
    assert found[0] == cached
    again = find_table(model)
    assert again is not None
    assert again[1] is found[1]  # read once
    assert main(['info', str(path)]) == 0
    assert f'table            {cached}' in capsys.readouterr().out
    cached.write_bytes(cached.read_bytes()[:-1])
    assert find_table(model) is None


def test_no_cells_are_built_where_a_vehicle_creeps_under_full_brakes(
        model: BrakeModel, table: ExpansionTable) -> None:
    domain = replace(table.domain, steepest=1e4)
    least = domain.contact_pressure[0] * domain.friction[0] / domain.rotor_speed[1]
    assert least < domain.steepest < 20.0 * least
    empty = build_table(model, replace(domain, steepest=0.9 * least))
    assert measure_coverage(empty, model, points=10, solved=0).gaps == 1.0
    point = domain.points(model, places(table, 1))[0]
    assert TabulatedSolver(model, empty).solve(point).source == 'full'

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

"""The tables that are shipped: each belongs to its model, and answers as it promises."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.resources import config_folder
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND, Tolerances
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_file import find_table, read_table
from squeal_core.surrogate.tabulated_solver import deviation
from squeal_ros.cli.main import main

TABLES = config_folder() / 'tables'


@pytest.fixture(autouse=True)
def _as_shipped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv('SQUEAL_TABLES')


@pytest.fixture(scope='module', params=['kang2009', 'kang2009_damped'])
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope='module')
def model(name: str) -> BrakeModel:
    return BrakeModel.load(name)


@pytest.fixture(scope='module')
def table(name: str, model: BrakeModel) -> ExpansionTable:
    return read_table(TABLES / f'{name}.npz', model)


def test_it_is_found_for_its_model_and_small(
        name: str, model: BrakeModel, table: ExpansionTable,
        capsys: pytest.CaptureFixture[str]) -> None:
    path = TABLES / f'{name}.npz'
    found = find_table(model)
    assert found is not None
    assert found[0] == path
    assert path.stat().st_size < 10e6
    assert table.domain == TableDomain.usual(model)
    assert main(['info', name]) == 0
    shown = capsys.readouterr().out
    assert f'table            {path}' in shown
    assert 'preload x friction / rotor speed up to 1000 N s' in shown
    assert '6516 + 6661 Hz cross' in shown or '3204 + 3458 Hz cross' in shown


def test_random_points_are_answered_within_the_tolerance(
        model: BrakeModel, table: ExpansionTable) -> None:
    domain, limits = table.domain, Tolerances.of(model)
    x = domain.low + domain.width * np.random.default_rng(11).random((2000, 3))
    x = x[domain.covers(x)]
    found = table.evaluate(x, limits)
    assert found.answered.mean() > 0.99
    chosen = np.flatnonzero(found.answered)[:100]
    points, listed = domain.points(model, x[chosen]), found.listed()
    for i, place in enumerate(chosen.tolist()):
        ours, truth = listed[place], complex_modes(model, points[i], tolerances=limits)
        assert deviation(ours, truth, table.tolerances) <= 1.0
        assert len(ours.unstable) == len(truth.unstable)


def test_another_folder_of_tables_or_none(
        kang: BrakeModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ('', str(tmp_path)):
        monkeypatch.setenv('SQUEAL_TABLES', folder)
        assert find_table(kang) is None
    (tmp_path / 'one.npz').symlink_to(TABLES / 'kang2009.npz')
    found = find_table(kang)
    assert found is not None
    assert found[0] == tmp_path / 'one.npz'


def test_a_point_is_not_answered_where_an_omitted_mode_may_be_the_worst_of_the_band(
        model: BrakeModel, table: ExpansionTable) -> None:
    """As where all modes that are omitted may grow faster than any that is kept."""
    domain, limits = table.domain, Tolerances.of(model)
    x = domain.low + domain.width * np.random.default_rng(12).random((50, 3))
    unsure = replace(table, cells=[replace(cell, omitted_below=1e6) for cell in table.cells])
    assert table.evaluate(x, limits, SQUEAL_BAND).answered.any()
    assert unsure.evaluate(x, limits).answered.any()
    assert not unsure.evaluate(x, limits, SQUEAL_BAND).answered.any()

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

"""How short the way of a point through the table is, and cells in one layout."""

from collections.abc import Sequence
import sys
from types import FrameType
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.surrogate.cell_arrays import stack_cells
from squeal_core.surrogate.table_cell import (
    BlockInvariants,
    fit_terms,
    not_known,
    TableCell,
    TableTolerances,
)

CALLS, MODULES = 12, 4  # at most


def test_the_way_of_a_point(kang: BrakeModel, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the monitor's call for one brake to the polynomials and back to its modes."""
    monkeypatch.delenv('SQUEAL_TABLES')
    stability = VehicleStability(kang, read_settings({}))
    here = SlidingConditions(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    stability.evaluate([here], [False])
    solve_all = stability.solver.solve_all
    passed: list[tuple[str, str]] = []

    def note(frame: FrameType, event: str, _: Any) -> None:
        module = str(frame.f_globals.get('__name__'))
        if event == 'call' and module.startswith('squeal_core.'):
            passed.append((module, frame.f_code.co_name))

    def watched(*arguments: Any) -> Any:
        sys.setprofile(note)
        try:
            return solve_all(*arguments)
        finally:
            sys.setprofile(None)

    monkeypatch.setattr(stability.solver, 'solve_all', watched)
    found, = stability.evaluate([here], [False])
    assert not isinstance(found, np.linalg.LinAlgError)
    assert found.modes.source == 'table'
    assert 5 < len(passed) <= CALLS, passed
    assert len({module for module, _ in passed}) <= MODULES, passed


@pytest.mark.parametrize('sizes', [[1, 1, 2, 2], [2, 3], [1, 3, 3, 4], []])
def test_blocks_among_more_blocks(sizes: Sequence[int]) -> None:
    """Cells of other blocks, in one layout, have the eigenvalues that each has alone."""
    rng = np.random.default_rng(4)
    cells = []
    for some in (sizes, [1, 1, 1, 2, 2, 2, 4], [1, 3, 3]):
        layout = BlockInvariants(np.array(some, np.intp))
        roots = rng.normal(size=(1, layout.count)) + 1j * rng.uniform(1e3, 9e3, layout.count)
        series = np.zeros((fit_terms(4).count, layout.count), complex)
        series[0] = layout.of(roots)[0]
        cells.append(TableCell(
            layout.sizes, series.view(float), rng.uniform(0.1, 1.0, layout.count),
            rng.random(layout.count) < 0.5, np.zeros((10, 0)), -5.0))
    nowhere = np.zeros((len(cells), 3))
    stack = stack_cells(cells, nowhere, nowhere)
    together = stack.layout.eigenvalues(stack.series[:, 0].view(complex), stack.bounds)
    for place, cell in enumerate(cells):
        alone = cell.at(np.eye(1, fit_terms(4).count))
        eigenvalues, _ = cell.layout.places_in(stack.layout)
        for one, all_ in zip(alone, together, strict=True):
            np.testing.assert_allclose(all_[place, eigenvalues], one[0], rtol=1e-12)
            assert np.count_nonzero(~np.isnan(all_[place])) == eigenvalues.size
        np.testing.assert_array_equal(stack.mirrored[place, eigenvalues], cell.mirrored)
    assert np.isnan(together[0][-1]).all()  # of no cell


@pytest.mark.parametrize(('growth', 'error', 'is_known'), [
    (-6.0, 3.0, False),  # it may be at -3 1/s, above what omitted modes stay below
    (-9.0, 3.0, True), (-3.0, 0.09, True)])
def test_a_mode_has_to_be_known_where_it_may_matter(
        growth: float, error: float, is_known: bool) -> None:
    found = not_known(np.array([growth + 1e4j]), np.array([error]), np.array([False]), -5.0,
                      TableTolerances(growth=0.1, decay=0.02), Tolerances(
                          oscillation=1.0, growth=0.01))
    assert found.tolist() == [not is_known]

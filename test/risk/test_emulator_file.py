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

"""The file of a growth emulator: what comes back, what is refused, where it is found."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.errors import TableFileError
from squeal_core.common.resources import config_folder
from squeal_core.risk.emulator_builder import build_growth_emulator, scattered_inputs
from squeal_core.risk.emulator_file import (
    cached_emulator_path,
    emulator_path,
    find_emulator,
    is_emulator,
    read_emulator,
    write_emulator,
)
from squeal_core.risk.growth_emulator import GrowthEmulator
from squeal_core.surrogate.table_file import find_table
from support.archives import parts, rewrite
from support.engine_models import crossing_model


@pytest.fixture(scope='module')
def emulator() -> GrowthEmulator:
    return build_growth_emulator(crossing_model(), solutions=400, hold_out=8)


@pytest.fixture
def path(emulator: GrowthEmulator, tmp_path: Path) -> Path:
    path = tmp_path / 'brake.growth.npz'
    write_emulator(path, emulator, emulator.model)
    return path


def refusal(path: Path, model: BrakeModel) -> str:
    with pytest.raises(TableFileError) as caught:
        read_emulator(path, model)
    assert '\n' not in str(caught.value)
    return str(caught.value)


def test_an_emulator_comes_back(emulator: GrowthEmulator, path: Path) -> None:
    read = read_emulator(path, emulator.model)
    assert (read.families, read.error) == (emulator.families, emulator.error)
    rows = scattered_inputs(emulator.domain, 50, 3)
    for ours, theirs in zip(emulator.evaluate(rows), read.evaluate(rows), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-4, atol=0.02)  # weights are single
    assert is_emulator(path)
    assert not is_emulator(config_folder() / 'models' / 'kang2009.npz')


def test_emulators_of_other_models_and_damaged_ones_are_refused(
        emulator: GrowthEmulator, path: Path) -> None:
    model = emulator.model
    other = replace(model, damping_ratios=0.003)
    assert 'is the growth emulator of another model' in refusal(path, other)
    whole, (header, arrays) = path.read_bytes(), parts(path)
    for length in (0, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        refusal(path, model)
    path.write_bytes(whole)
    rewrite(path, arrays={'weights': 2.0 * arrays['weights']}, with_right_hash=False)
    assert 'was altered' in refusal(path, model)
    refused = {
        'families do not fit': ({'families': header['families'][1:]}, {}),
        'families [7] of 3 modes': (
            {'common': [{'piece': 0, 'families': [7], 'modes': 3}]}, {}),
        'common matrices do not fit': ({'common': []}, {}),
        'degrees': ({}, {'exponents': arrays['exponents'] - 1}),
        'not finite': ({}, {'weights': np.nan * arrays['weights']}),
        'scales that are not positive': ({}, {'scales': 0.0 * arrays['scales']}),
        'weights: shape': ({}, {'weights': arrays['weights'][1:]}),
        'another version': ({'schema': 9}, {})}
    for words, (changed, replaced) in refused.items():
        path.write_bytes(whole)
        rewrite(path, changed, replaced)
        assert words in refusal(path, model)
    assert 'does not exist' in refusal(path.with_name('none.growth.npz'), model)


def test_where_emulators_are_found(emulator: GrowthEmulator, path: Path,
                                   monkeypatch: pytest.MonkeyPatch) -> None:
    model, other = emulator.model, replace(emulator.model, damping_ratios=0.003)
    assert find_emulator(model) is None
    monkeypatch.setenv('SQUEAL_TABLES', str(path.parent))
    path.with_name('a.growth.npz').write_bytes(b'no archive')
    found = find_emulator(model)
    assert found is not None
    assert found[0] == path
    assert find_emulator(other) is None
    assert find_table(model) is None  # an emulator is no table
    cached = cached_emulator_path(other)
    cached.parent.mkdir(parents=True, exist_ok=True)
    write_emulator(cached, emulator, other)
    found = find_emulator(other)
    assert found is not None
    assert found[0] == cached
    cached.unlink()


def test_emulators_are_beside_tables() -> None:
    assert emulator_path('a/table.npz') == Path('a/table.growth.npz')
    assert emulator_path('a/table.growth.npz') == Path('a/table.growth.npz')

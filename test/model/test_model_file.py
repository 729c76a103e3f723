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

"""Model files: what is saved comes back bit for bit; saves that are interrupted or cannot be."""

from pathlib import Path
from typing import Any

from hypothesis import given, HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
import numpy as np
import pytest
from squeal_core.brake.dimensions import StiffnessTable
from squeal_core.common.npz_archive import content_hash
from squeal_core.common.output import OutputError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.matrix_names import OPERATORS
from squeal_core.model.model_file import read_model
from support.archives import parts
from support.model_files import content, SMALL, small_model

SHIPPED = Path(__file__).parents[2] / 'config' / 'models' / 'kang2009.npz'


@pytest.mark.parametrize('changes', [
    {}, dict.fromkeys(OPERATORS), dict.fromkeys(OPERATORS[1:], SMALL + SMALL.T),
    {'caliper': None}, {'friction_law': None}, {'friction_table': None}, {'names': ()},
    {'provenance': {}}, {'damping_ratios': 0.01},
    {'stiffness_table': StiffnessTable((0.0, 1e5 / 3), (1e10, 2e10 / 3))},
    {'contact_retardation_time': 1e-5 / 3}])
def test_round_trip_is_bit_exact(tmp_path: Path, changes: dict[str, Any]) -> None:
    model = small_model(**changes)
    model.save(tmp_path / 'model.npz')
    assert content(BrakeModel.load(tmp_path / 'model.npz')) == content(model)
    assert [file.name for file in tmp_path.iterdir()] == ['model.npz']


@settings(max_examples=60, deadline=None,
          suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(hnp.arrays(float, (2, 2), elements=st.floats(allow_nan=False, allow_infinity=False)))
def test_round_trip_of_any_finite_numbers(path: Path, array: Any) -> None:
    model = BrakeModel(angular_frequencies=np.abs(array[0]), damping_ratios=array[1],
                       friction_couple=array)
    model.save(path)
    assert content(BrakeModel.load(path)) == content(model)


def test_header(path: Path) -> None:
    header = read_model(path, BrakeModel)[0]
    assert header['provenance'] == {'made': 'here', 'n': [1, 2.5]}
    assert (header['schema'], header['hash']) == (1, content_hash(*parts(path)))
    assert BrakeModel.load(path).provenance == header['provenance']


def test_saving_again_keeps_the_hash(path: Path, tmp_path: Path) -> None:
    BrakeModel.load(path).save(tmp_path / 'again.npz')
    assert read_model(tmp_path / 'again.npz', BrakeModel)[0]['hash'] == read_model(
        path, BrakeModel)[0]['hash']


def test_shipped_model_by_name_and_by_path() -> None:
    assert content(BrakeModel.load('kang2009')) == content(BrakeModel.load(SHIPPED))


def test_only_files_with_a_stiffness_table_are_of_schema_2(path: Path) -> None:
    assert BrakeModel.load(path).stiffness_table is None
    assert 'stiffness_table' not in read_model(path, BrakeModel)[0]
    small_model(stiffness_table=StiffnessTable((1e5,), (1e10,))).save(path)
    assert read_model(path, BrakeModel)[0]['schema'] == 2


@pytest.mark.parametrize('error', [OSError(28, 'No space left'), KeyboardInterrupt()])
def test_an_interrupted_save_leaves_the_old_file(path: Path, monkeypatch: Any,
                                                 error: BaseException) -> None:
    def interrupted(file: Any, **_: Any) -> None:
        file.write(b'PK half a file')
        raise error

    before = path.read_bytes()
    monkeypatch.setattr(np, 'savez_compressed', interrupted)
    monkeypatch.setattr(np, 'savez', interrupted)
    with pytest.raises((OutputError, type(error))):
        small_model(names=()).save(path)
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_a_save_that_cannot_be(tmp_path: Path) -> None:
    for path, words in ((tmp_path / 'none' / 'model.npz', 'in a folder that does not exist'),
                        (tmp_path, 'is a folder'), (Path('/dev/full'), 'is a device')):
        with pytest.raises(OutputError, match=words):
            small_model().save(path)
    small_model().save(tmp_path / 'model.npz', overwrite=False)
    with pytest.raises(OutputError, match='exists; give --force'):
        small_model().save(tmp_path / 'model.npz', overwrite=False)

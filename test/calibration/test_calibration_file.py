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

"""The file of a calibration: read as written, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.calibration.calibration_file import (
    CalibrationFileError,
    read_calibration,
    write_calibration,
)
from squeal_core.common.errors import SquealError
from squeal_core.common.output import OutputError
from squeal_core.risk.ensemble import Ensemble, EnsemblePrior, MEMBERS, prior_ensemble
from support.rows import each


def calibrated() -> Ensemble:
    found = prior_ensemble(EnsemblePrior(count=8))
    return Ensemble(*(getattr(found, name) for name in (*MEMBERS, 'weights')), 0.02, 0.15,
                    'by 31 events: two drives')


@pytest.fixture
def path(tmp_path: Path, kang: BrakeModel) -> Path:
    path = tmp_path / 'brake.calibration.yaml'
    write_calibration(calibrated(), kang, path, {
        'events': 31, 'recordings': ['a: "b"', 'c'],
        'scores': {'calibrated': {'brier': 0.19, 'roc_area': float('nan')}}})
    return path


def test_what_is_written_is_read(path: Path, kang: BrakeModel) -> None:
    found, wanted = read_calibration(path, kang), calibrated()
    for name in (*MEMBERS, 'weights', 'friction_scatter', 'damping_scatter'):
        np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), rtol=1e-5)
    assert found.calibrated == wanted.calibrated
    assert path.stat().st_size < 2000
    with pytest.raises(OutputError, match='exists'):
        write_calibration(wanted, kang, path, overwrite=False)


def test_a_prior_is_no_calibration(tmp_path: Path, kang: BrakeModel) -> None:
    with pytest.raises(SquealError, match='calibrated: is empty'):
        write_calibration(prior_ensemble(EnsemblePrior()), kang, tmp_path / 'a.yaml')


def test_another_model_is_refused(path: Path) -> None:
    with pytest.raises(CalibrationFileError, match='of another model; calibrate this model'):
        read_calibration(path, BrakeModel.load('kang2009_damped'))


@each(('before', 'after', 'words'), [
    ('format: "squeal', 'format: "what', 'is no calibration file'),
    ('schema: 1', 'schema: 2', 'schema is 2, and this version reads 1'),
    ('calibrated: "by', 'calibrated: ["by', 'is not YAML'),
    ('calibrated: "by 31 events: two drives"', 'calibrated: 3', 'calibrated: is 3'),
    ('"ln_damping", ', '', 'columns: are'),
    ('members:\n', 'members:\n- [1.0, 2.0]\n', r'members\[0\]: is \[1.0, 2.0\]; write 6 numbers'),
    ('members:\n- [', 'members:\n- [9', r'members\[0\].ln_damping: is .*; write a number from'),
    ('members:\n- [', 'members:\n- [.nan, ', r'members\[0\]: is'),
    ('friction_scatter: 0.02', 'friction_scatter: x', "friction_scatter: is 'x'; write a number"),
    ('friction_scatter: 0.02\n', '', 'friction_scatter: is None')])
def test_what_is_refused(path: Path, kang: BrakeModel, before: str, after: str,
                         words: str) -> None:
    text = path.read_text(encoding='utf-8')
    assert before in text
    altered = path.with_name('altered.yaml')
    altered.write_text(text.replace(before, after, 1), encoding='utf-8')
    with pytest.raises(CalibrationFileError, match=words) as error:
        read_calibration(altered, kang)
    assert str(altered) in str(error.value)


def test_no_file(tmp_path: Path, kang: BrakeModel) -> None:
    with pytest.raises(CalibrationFileError, match='check the path'):
        read_calibration(tmp_path / 'none.yaml', kang)

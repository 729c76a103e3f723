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

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.calibration.calibration_file import (
    CalibrationFileError,
    check_domain,
    read_calibration,
    write_calibration,
)
from squeal_core.common.errors import SquealError
from squeal_core.common.output import OutputError
from squeal_core.risk.emulator_records import EmulatorDomain
from squeal_core.risk.ensemble import Ensemble, EnsemblePrior, MEMBERS, prior_ensemble
from squeal_core.risk.squeal_risk import SquealRisk
from support.linear_growth import LinearGrowth
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
    ('schema: 2', 'schema: 1', 'schema is 1, and this version reads 2'),
    ('calibrated: "by', 'calibrated: ["by', 'is not YAML'),
    ('calibrated: "by 31 events: two drives"', 'calibrated: 3', 'calibrated: is 3'),
    ('"ln_damping", ', '', 'columns: are'),
    ('members:\n', 'members:\n- [1.0, 2.0]\n', r'members\[0\]: is \[1.0, 2.0\]; write 6 numbers'),
    ('members:\n- [', 'members:\n- [9', r'members\[0\].ln_damping: is .*; write a number from'),
    ('members:\n- [', 'members:\n- [.nan, ', r'members\[0\]: is'),
    ('friction_scatter: 0.02', 'friction_scatter: x', "friction_scatter: is 'x'; write a number"),
    ('friction_scatter: 0.02\n', '', 'friction_scatter: is None'),
    ('0.125]', '1.0]', 'members: have weights of sum 1.875, and it should be 1'),
    ('member_count: 8', 'member_count: 9', 'members: are 8, and member_count is 9: the file was'),
    ('members:\n- [', 'members:\n- [5.0, 0, 0, 1, 5, 0.125]\n- [',
     r'members\[0\].ln_damping: is 5.0; write a number from -2 to 2'),
    ('damping_scatter: 0.15', 'damping_scatter: 0.16', "hash: is '.*: they were altered; write"),
    ('likelihood_power: 1.0', 'likelihood_power: 0.4', 'hash: is '),
    ('likelihood_power: 1.0', 'likelihood_power: 0', "is 'by 31 .* at likelihood_power 0; write")])
def test_what_is_refused(path: Path, kang: BrakeModel, before: str, after: str,
                         words: str) -> None:
    text = path.read_text(encoding='utf-8')
    assert before in text
    altered = path.with_name('altered.yaml')
    altered.write_text(text.replace(before, after, 1), encoding='utf-8')
    with pytest.raises(CalibrationFileError, match=words) as error:
        read_calibration(altered, kang)
    assert str(altered) in str(error.value)


def test_a_file_cut_at_a_row(path: Path, kang: BrakeModel) -> None:
    lines = path.read_text(encoding='utf-8').splitlines(keepends=True)
    path.write_text(''.join(lines[:-3]), encoding='utf-8')
    with pytest.raises(CalibrationFileError, match='members: are 5, and member_count is 8'):
        read_calibration(path, kang)


def test_how_much_was_measured_is_kept(tmp_path: Path, kang: BrakeModel) -> None:
    prior = 'the level of the risk is mostly the prior of damping'
    for words, power, basis in (('', 0.0, f'not calibrated: {prior}'),
                                ('by 3 events', 0.3, f'by 3 events: {prior}'),
                                ('by 9 events', 0.9, 'by 9 events')):
        write_calibration(replace(calibrated(), calibrated=words, likelihood_power=power), kang,
                          tmp_path / 'a.yaml')
        found = read_calibration(tmp_path / 'a.yaml', kang)
        assert (found.calibrated, found.likelihood_power) == (words, power)
        assert SquealRisk(LinearGrowth([1655.0], [45.0], [350.0]), found).basis == basis


def test_weights_that_are_no_short_decimals(tmp_path: Path, kang: BrakeModel) -> None:
    write_calibration(Ensemble(*np.zeros((3, 3)), np.ones(3), np.ones(3), np.ones(3), 0.02, 0.15,
                               'by 12 events'), kang, tmp_path / 'a.yaml')
    np.testing.assert_allclose(read_calibration(tmp_path / 'a.yaml', kang).weights, 1.0 / 3.0)


def test_members_outside_of_the_emulator(path: Path) -> None:
    ends = np.array([3.0, 12.0, 0.5, 0.3, 0.9, 2.0])
    domain = EmulatorDomain(np.array([0.0, 9.0, 0.02, -0.3, -0.9, 0.0]), ends, -0.05)
    check_domain(path, calibrated(), domain)
    outside = replace(calibrated(), ln_damping=np.full(8, 1.5))
    with pytest.raises(CalibrationFileError, match='have ln_damping from 1.5 to 1.5, and the '
                                                   'growth emulator knows -0.9 to 0.9'):
        check_domain(path, outside, domain)


def test_no_file(tmp_path: Path, kang: BrakeModel) -> None:
    with pytest.raises(CalibrationFileError, match='check the path'):
        read_calibration(tmp_path / 'none.yaml', kang)

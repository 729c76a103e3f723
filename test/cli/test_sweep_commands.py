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

"""`squeal map` and `squeal locus`: friction at each point, what is counted, what is kept."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.studies.sweep_file import load_sweep
from squeal_ros.cli.main import main
from support.commands import answer, FEW

RADIUS = 2.0 / 3.0 * (0.142**3 - 0.1**3) / (0.142**2 - 0.1**2)  # m, of K09's patch
LAW = [(0.32 + fall, -fall) for fall in (0.18 * math.exp(-RADIUS * speed)
                                         for speed in (2.0, 10.0))]


@pytest.mark.parametrize(('arguments', 'expected'), [
    ([], LAW), (['--friction-law'], LAW), (['--friction', '0.5'], [(0.5, 0.0)] * 2),
    (['--friction', '0.5', '--friction-slope', '-0.1'], [(0.5, -0.1)] * 2),
    # the law's slope, scaled to --friction, at each speed
    (['--friction', '0.5', '--friction-law'], [(0.5, 0.5 * s / f) for f, s in LAW])])
def test_friction_over_speed(arguments: list[str], expected: list[tuple[float, float]],
                             tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'map.csv'
    assert main(['map', 'kang2009', '--over', 'rotor_speed=2:10:2', '-o', str(path),
                 *arguments]) == 0
    with path.open(newline='') as file:
        rows = [row for row in csv.DictReader(list(file)[1:]) if row['index'] == '1']
    assert [float(row['rotor_speed']) for row in rows] == [2.0, 10.0]
    for row, (friction, slope) in zip(rows, expected, strict=True):
        assert float(row['friction']) == pytest.approx(friction, rel=1e-12)
        assert float(row['friction_slope']) == pytest.approx(slope, rel=1e-12)


def test_swept_friction_is_constant_over_speed(tmp_path: Path,
                                               capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'map.npz'
    assert main(['map', 'kang2009', *FEW, '-o', str(path)]) == 0
    assert load_sweep(path).column('friction_slope').tolist() == [0.0] * 3
    assert main(['map', 'kang2009', '--over', 'friction=0.3:0.6:2', '--over',
                 'rotor_speed=2:10:2', '--friction-law', '-o', str(path), '--force']) == 0
    record = load_sweep(path)
    assert record.column('friction').tolist() == [0.3, 0.3, 0.6, 0.6]
    assert record.column('friction_slope') == pytest.approx(
        [mu * s / f for mu in (0.3, 0.6) for f, s in LAW], rel=1e-12)
    assert record.about['friction_law'] == 'slope'


def test_flutter_and_divergence_are_counted_apart(tmp_path: Path,
                                                  capsys: pytest.CaptureFixture[str]) -> None:
    """One mode that slides freely and one that vibrates, each with a slope of its own."""
    for diagonal, expected in (([1e-3, 0.0], (0, 2)), ([0.0, 1e-2], (2, 0))):
        BrakeModel(angular_frequencies=[0.0, 1e4], negative_slope=np.diag(diagonal)).save(
            tmp_path / 'two.npz')
        found = answer(capsys, 'map', str(tmp_path / 'two.npz'), '--over',
                       'friction_slope=-0.1:0:3', '--friction', '0.3')
        assert (found['points_with_flutter'], found['points_with_divergence']) == expected


def test_a_locus_with_and_without_rotation(tmp_path: Path,
                                           capsys: pytest.CaptureFixture[str]) -> None:
    files = [tmp_path / name for name in ('a.json', 'a_without_rotation.json', 'a.svg')]
    assert main(['locus', 'kang2009', '--over', 'friction=0.3:0.5:5', '--modes', '13,14',
                 '--without-rotation', '-o', str(files[0]), '--plot', str(files[2])]) == 0
    one, other = map(load_sweep, files[:2])
    assert (one.about['rotation'], other.about['rotation']) == (True, False)
    assert not one.merged(13).any()
    # it merges at 0.348, wherever the path begins
    assert other.merged(14).tolist() == [False, True, True, True, True]
    assert other.names(13).tolist()[::4] == ['13', '13/14']

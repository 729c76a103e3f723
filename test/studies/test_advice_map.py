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

"""The map of the risk: its numbers, and its files, the C one compiled and run."""

import csv
from pathlib import Path
import shutil
import subprocess

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator
from squeal_core.common.output import OutputError
from squeal_core.risk.holding import holding_exceedances, over_members
from squeal_core.studies.advice_files import AdviceFileError, write_advice_map
from squeal_core.studies.advice_map import advice_map, AdviceMap, NOTICE
from support.advised_brakes import falling, falling_growth, falling_risk

PRESSURES, SPEEDS = np.geomspace(2e6, 1.2e7, 5), np.array([6.0, 10.0, 18.0])
FRICTIONS = np.array([0.25, 0.3, 0.35, 0.5])
CC = shutil.which('cc') or shutil.which('gcc')
PROGRAM = """
#include <stdio.h>
#include <stdlib.h>
#include "map.c"
int main(int argc, char **argv)
{{
    int i;
    const float *all = &squeal_risk[0][0][0];
    for (i = 0; i < {size}; ++i) {{
        printf("%.9g\\n", (double)all[i]);
    }}
    for (i = 1; i + 2 < argc; i += 3) {{
        printf("%.9g\\n", (double)squeal_risk_at((float)atof(argv[i]), (float)atof(argv[i + 1]),
                                                (float)atof(argv[i + 2])));
    }}
    return 0;
}}
"""


@pytest.fixture(scope='module')
def found() -> AdviceMap:
    """Return a map whose risk is not known from a friction of 0.4 on."""
    model = falling()
    return advice_map(model, PRESSURES, SPEEDS, FRICTIONS, hold=3.0, workers=0,
                      risk=falling_risk(model, most_friction=0.4),
                      about={'model': 'falling */ friction', 'made by': 'tests'})


def test_numbers(found: AdviceMap) -> None:
    model = falling()
    risk = falling_risk(model)
    for (i, j, k), value in np.ndenumerate(found.risk[:, :, :3]):
        alone = over_members(risk, holding_exceedances(
            risk, model, 3.0, PRESSURES[i:i + 1], SPEEDS[j], FRICTIONS[k]))
        assert value == pytest.approx(alone[0], abs=1e-12)
        assert found.growth_rate[i, j, k] == pytest.approx(falling_growth(
            model, SPEEDS[j], model.contact_pressure(PRESSURES[i]), FRICTIONS[k]), abs=1e-6)
    assert np.isnan(found.risk[:, :, 3]).all()
    assert 0.0 <= found.risk[0, 2, 0] < 0.01
    assert found.risk[-1, 0, 2] > 0.99


def test_csv_says_what_it_is_and_leaves_out_what_is_not_known(found: AdviceMap,
                                                              tmp_path: Path) -> None:
    path = tmp_path / 'map.csv'
    write_advice_map(found, path)
    lines = path.read_text().splitlines()
    assert lines[0] == f'# {NOTICE}'
    assert '# made by: tests' in lines
    rows = [*csv.DictReader(line for line in lines if not line.startswith('#'))]
    assert list(rows[0]) == ['pressure_pa', 'rotor_speed_rad_s', 'friction', 'risk',
                             'growth_rate_1_s']
    for row, (place, risk) in zip(rows, np.ndenumerate(found.risk), strict=True):
        expected = (PRESSURES[place[0]], SPEEDS[place[1]], FRICTIONS[place[2]])
        assert [float(row[name]) for name in list(row)[:3]] == pytest.approx(expected, rel=1e-6)
        assert float(row['growth_rate_1_s']) == pytest.approx(found.growth_rate[place], rel=1e-6)
        assert (row['risk'] == '') == np.isnan(risk)
    with pytest.raises(OutputError, match='exists'):
        write_advice_map(found, path)


@pytest.mark.skipif(CC is None, reason='no C compiler here')
def test_c_compiles_and_has_the_numbers_of_the_csv(found: AdviceMap, tmp_path: Path) -> None:
    write_advice_map(found, tmp_path / 'map.c', tmp_path / 'map.csv')
    source = (tmp_path / 'map.c').read_text()
    assert source.startswith(f'/*\n * {NOTICE}\n * model: falling * / friction\n')
    assert 'static const float squeal_risk[5][3][4] = {' in source
    (tmp_path / 'main.c').write_text(PROGRAM.format(size=found.risk.size))
    strict = [str(CC), '-std=c99', '-Wall', '-Wextra', '-Werror', '-pedantic']
    subprocess.run([*strict, '-c', 'map.c', '-o', 'map.o'], cwd=tmp_path, check=True)
    subprocess.run([*strict, 'main.c', '-o', 'main'], cwd=tmp_path, check=True)
    random = np.random.default_rng(3)
    inside = random.uniform([2e6, 6.0, 0.25], [1.2e7, 18.0, 0.35], (20, 3))
    outside = np.array([[1.9e6, 10.0, 0.3], [4e6, 19.0, 0.3], [4e6, 10.0, np.nan],
                        [4e6, 10.0, 0.4]])  # the last one is not known
    asked = [f'{value:.9g}' for value in np.concatenate([inside, outside]).ravel()]
    printed = subprocess.run([str(tmp_path / 'main'), *asked], capture_output=True, check=True,
                             text=True).stdout.split()
    values = [float(text) for text in printed]
    with (tmp_path / 'map.csv').open() as file:
        rows = [*csv.DictReader(line for line in file if not line.startswith('#'))]
    risks = [float(row['risk'] or 'nan') for row in rows]
    assert np.array_equal(np.array(values[:len(rows)], np.float32), np.array(risks, np.float32),
                          equal_nan=True)
    linear = RegularGridInterpolator((PRESSURES, SPEEDS, FRICTIONS[:3]), found.risk[:, :, :3])
    assert values[len(rows):-4] == pytest.approx(linear(inside), abs=1e-5)
    assert np.isnan(values[-4:]).all()


def test_without_any_risk_there_is_no_c(tmp_path: Path) -> None:
    none = advice_map(falling(), PRESSURES, SPEEDS, FRICTIONS, hold=3.0, risk=None)
    with pytest.raises(AdviceFileError, match='would hold no risk; write a .csv'):
        write_advice_map(none, tmp_path / 'map.csv', tmp_path / 'map.c')
    assert [*tmp_path.iterdir()] == []
    write_advice_map(none, tmp_path / 'map.csv')
    assert (tmp_path / 'map.csv').read_text().count('\n') == 60 + 5


def test_other_suffixes_are_refused(found: AdviceMap, tmp_path: Path) -> None:
    with pytest.raises(AdviceFileError, match='end it in .csv, .c, .h'):
        write_advice_map(found, tmp_path / 'map.txt')

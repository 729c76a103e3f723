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

"""
Damaged model, brake and table files: one line of the named error, under 1 s and 500 MB each.

The files are read by a process of its own, whose memory is limited (`reading_mutants.py`).
"""

import json
import os
from pathlib import Path
import random
import subprocess
import sys

import pytest
from squeal_core.common.resources import find
from support.mutants import mutant_of_archive, mutant_of_text
from support.processes import linux, short_and_long

# a shipped model takes some ten times as long as a small one
SHARE = {'model': 1.0, 'shipped model': 0.1, 'brake': 1.0, 'table': 1.0}


@linux
@pytest.mark.parametrize('kind', SHARE)
@short_and_long('count', 300, 5000, minutes=20.0)
def test_damaged_files(kind: str, count: int, tmp_path: Path) -> None:
    count = round(SHARE[kind] * count)
    done = subprocess.run(
        [sys.executable, '-m', 'support.reading_mutants', kind, '0', str(count), str(tmp_path)],
        text=True, capture_output=True, check=False, cwd=Path(__file__).parent,
        env={**os.environ, 'OPENBLAS_NUM_THREADS': '1'})
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout)
    print(f'\n{kind}: {found["refused"]} refused, {found["read"]} read, slowest '
          f'{found["slowest"]:.2f} s, {found["memory"] / 1e6:.0f} MB')
    assert found['failures'] == []
    assert found['refused'] + found['read'] == count
    assert found['refused'] > 0.5 * count
    assert found['read'] > 0.01 * count  # some wounds are none, and reading goes on after them
    assert found['slowest'] < 1.0  # of computing: others may be at work
    assert found['memory'] < 500e6


def test_a_mutant_is_a_function_of_its_number() -> None:
    brake = find('brakes', 'kang2009', '.yaml').read_bytes()
    model = find('models', 'kang2009', '.npz').read_bytes()
    for mutate, whole in ((mutant_of_text, brake), (mutant_of_archive, model)):
        mutants = [mutate(whole, random.Random(f'x {number}')) for number in (1, 2, 1)]
        assert mutants[0] == mutants[2] != mutants[1]

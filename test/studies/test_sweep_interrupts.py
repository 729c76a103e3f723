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

"""Progress of sweeps; interrupts and workers."""

import os
from pathlib import Path
import signal
import subprocess
import sys

import numpy as np
import pytest
from squeal_core.studies.sweep import sweep
from support.processes import process
from support.sweeps import FRICTIONS, interrupted, PAIR, POINT


@pytest.mark.parametrize('tracked', [False, True])
def test_progress(tracked: bool) -> None:
    told: list[tuple[int, int]] = []
    sweep(PAIR, POINT, {'friction': FRICTIONS}, tracked=tracked,
          progress=lambda *counts: told.append(counts))
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]


@pytest.mark.parametrize('tracked', [False, True])
def test_an_interrupt_keeps_what_is_done(tracked: bool) -> None:
    found = interrupted(7, tracked=tracked)
    whole = sweep(PAIR, POINT, {'friction': np.linspace(0.0, 0.9, 20)}, tracked=tracked)
    assert not found.complete
    assert found.done.tolist() == [True] * 7 + [False] * 13
    assert np.array_equal(found.eigenvalues[:7], whole.eigenvalues[:7])
    assert np.array_equal(found.identities[:7], whole.identities[:7])
    assert np.isnan(found.eigenvalues[7:]).all()
    assert (found.kinds[7:] == '').all()
    assert np.isnan(found.largest_growth()).tolist() == (~found.done).tolist()
    assert np.isnan(found.of(1)).tolist() == (~found.done).tolist()


def test_an_interrupt_keeps_a_part_of_a_line_that_is_tracked() -> None:
    """A line is not divided among workers, so they would keep all of it or nothing."""
    found = interrupted(7, tracked=True, workers=2)
    assert found.done.tolist() == [True] * 7 + [False] * 13


def test_an_interrupt_ends_workers() -> None:
    found = interrupted(3, workers=2)
    assert 3 <= found.done.sum() < 20
    whole = sweep(PAIR, POINT, {'friction': np.linspace(0.0, 0.9, 20)})
    assert found.eigenvalues[found.done] == pytest.approx(whole.eigenvalues[found.done], rel=1e-12)


SCRIPT = """
import os
import numpy as np
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.studies.sweep import sweep
if __name__ == '__main__':
    kang = BrakeModel.load('kang2009')
    point = OperatingPoint(rotor_speed=5.0, friction=0.42, contact_stiffness=0.35e11,
                           contact_pressure=2000.0 / kang.contact_area)
    axes = {'rotor_speed': [5.0, 20.0], 'friction': np.linspace(0.0, 0.5, 3)}
    before = dict(os.environ)
    for tracked in (False, True):
        one, two = (sweep(kang, point, axes, tracked=tracked, workers=n) for n in (0, 2))
        assert two.complete
        print(one.eigenvalues.tobytes() == two.eigenvalues.tobytes(),
              one.identities.tobytes() == two.identities.tobytes())
    print(before == dict(os.environ))
"""


def test_workers_equal_one_process_bit_for_bit(tmp_path: Path) -> None:
    script = tmp_path / 'script.py'
    script.write_text(SCRIPT)
    pinned = {**os.environ, 'OPENBLAS_NUM_THREADS': '1', 'OMP_NUM_THREADS': '1',
              'PYTHONPATH': str(Path(__file__).parents[2])}
    run = subprocess.run([sys.executable, script], env=pinned, capture_output=True, text=True)
    assert run.stderr == ''
    assert run.stdout.split() == ['True'] * 5


LONG = """
import numpy as np
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.studies.sweep import sweep
if __name__ == '__main__':
    kang = BrakeModel.load('kang2009')
    point = OperatingPoint(rotor_speed=5.0, friction=0.42, contact_stiffness=0.35e11,
                           contact_pressure=2000.0 / kang.contact_area)
    found = sweep(kang, point, {'friction': np.linspace(0.0, 0.8, 20000)}, workers=2,
                  progress=lambda done, count: print(done, flush=True))
    print('kept', found.done.sum(), found.complete, flush=True)
"""


def test_ctrl_c_with_workers(tmp_path: Path) -> None:
    """It goes to all processes of the terminal; the parent returns its part, nobody complains."""
    script = tmp_path / 'script.py'
    script.write_text(LONG)
    with process([script], {**os.environ, 'PYTHONPATH': str(Path(__file__).parents[2])},
                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                 start_new_session=True) as started:
        assert started.stdout.readline() == '1\n'
        os.killpg(started.pid, signal.SIGINT)
        output, complaints = started.communicate()
    last = output.splitlines()[-1].split()
    assert (last[0], last[2]) == ('kept', 'False')
    assert 1 <= int(last[1]) < 20000
    assert complaints == ''

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

"""Jobs in processes of their own: results, errors, and that no process outlives its parent."""

import multiprocessing
import os
import signal
import subprocess
import sys

import pytest
from squeal_core.common.errors import SquealError
from squeal_core.common.worker_processes import run_jobs
from support.processes import process

TWICE = """
from squeal_core.common.worker_processes import run_jobs
from support.processes import stay
list(run_jobs(stay, {0: (), 1: ()}, 2))
"""


def root(value: float) -> tuple[float, int]:
    if value < 0.0:
        raise ValueError(f'{value} is negative')
    return value**0.5, os.getpid()


def end() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.parametrize('workers', [0, 2])
def test_results_and_errors_by_key(workers: int) -> None:
    jobs = {key: (float(key * key),) for key in range(5)}
    found = dict(run_jobs(root, jobs, workers))
    assert {key: value for key, (value, _) in found.items()} == {key: key for key in range(5)}
    assert (os.getpid() in {process for _, process in found.values()}) == (workers == 0)
    with pytest.raises(ValueError, match='-1.0 is negative'):
        list(run_jobs(root, {0: (1.0,), 1: (-1.0,)}, workers))
    assert not multiprocessing.active_children()


def test_a_worker_that_is_killed_is_told() -> None:
    with pytest.raises(SquealError, match='ended from outside.*fewer workers'):
        list(run_jobs(end, {0: ()}, 1))


def test_workers_at_work_end_with_the_iterator() -> None:
    results = run_jobs(pow, {0: (2, 3), 1: (2, 10**9, 10**9 + 7), 2: (10**9, 10**9)}, 2)
    assert next(results)[0] in (0, 1)  # the last one computes for hours
    results.close()  # type: ignore[attr-defined]
    assert not multiprocessing.active_children()


def test_workers_at_work_end_when_their_parent_is_killed() -> None:
    with process(['-c', TWICE], {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)},
                 stdout=subprocess.PIPE, text=True) as parent:
        assert [parent.stdout.readline() for _ in range(2)] == ['here\n', 'here\n']
        parent.kill()
        assert not parent.stdout.read()  # nobody has it open any more

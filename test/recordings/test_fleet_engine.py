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

"""Jobs on Dask with real processes: workers and schedulers that are ended, hang, are not there."""

from collections.abc import Iterator
from contextlib import ExitStack
import operator
import os
from pathlib import Path
import signal
import socket
import sys
import threading
from types import ModuleType

import pytest

pytest.importorskip('distributed', reason='needs dask')
pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_ros.recordings.fleet.fleet_engine import FleetEngine, FleetLost  # noqa: E402
from support.bags import braking, write_bag  # noqa: E402, I100
from support.commands import squeal  # noqa: E402
from support.fleets import cluster, free_port, held, Release  # noqa: E402
from support.processes import linux  # noqa: E402


@linux
def test_a_worker_killed_in_the_middle(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its job is done by another one; an error is that of its job, also what is not installed."""
    here = ModuleType('only_here')
    exec('def job(): pass', here.__dict__)
    monkeypatch.setitem(sys.modules, 'only_here', here)
    release = Release(tmp_path, lambda pid: os.kill(pid, signal.SIGKILL))
    with FleetEngine(workers=2, retries=1) as engine:
        first = dict(engine.results(held, {'held': (str(tmp_path),)}, release))
        jobs = {'wrong': (1, 0), 'good': (1, 2)}
        found = dict(engine.results(operator.truediv, jobs, lambda: True))
        missing = dict(engine.results(here.job, {'missing': ()}, lambda: True))
    assert release.ended not in (0, first['held'])
    assert found['good'] == 0.5
    assert isinstance(found['wrong'], ZeroDivisionError)
    assert isinstance(missing['missing'], ModuleNotFoundError)


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as found:
        yield found


@linux
def test_a_scheduler_that_is_restarted_hangs_or_has_no_worker(
        tmp_path: Path, stack: ExitStack, capfd: pytest.CaptureFixture[str]) -> None:
    port = free_port()
    address = f'tcp://127.0.0.1:{port}'
    scheduler, worker = stack.enter_context(cluster(port))

    def restart(_: int) -> None:
        nonlocal scheduler, worker
        scheduler.kill()
        worker.kill()
        scheduler.wait()
        scheduler, worker = stack.enter_context(cluster(port))

    release = Release(tmp_path, restart)
    with FleetEngine(address, timeout=120.0) as engine:
        first = dict(engine.results(held, {'held': (str(tmp_path),)}, release))
    assert first['held'] == worker.pid != release.ended
    with FleetEngine(address, timeout=120.0) as engine:
        engine._timeout = 1.0
        worker.kill()
        with pytest.raises(FleetLost, match=f'{address}: has had no worker for 1 s; see'):
            list(engine.results(held, {'held': (str(tmp_path),)}, lambda: True))
        scheduler.send_signal(signal.SIGSTOP)
        with pytest.raises(FleetLost, match=f'{address}: has not answered for 1 s; see'):
            list(engine.results(held, {'held': (str(tmp_path),)}, lambda: True))
    for wrong in (f'tcp://127.0.0.1:{free_port()}', 'nowhere://x', address):  # halted
        with (pytest.raises(FleetLost, match=f'{wrong}: cannot be reached within 0.5 s'),
              FleetEngine(wrong, timeout=0.5)):
            pass
    assert capfd.readouterr().err == ''


@linux
def test_ctrl_c_while_it_connects(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What accepts a connection and never speaks is left at once."""
    write_bag(tmp_path / 'bag', braking(1.0))
    with socket.create_server(('127.0.0.1', 0)) as silent:
        def interrupt() -> None:
            with silent.accept()[0]:
                os.kill(os.getpid(), signal.SIGINT)
                left.wait()

        left, thread = threading.Event(), threading.Thread(target=interrupt)
        thread.start()
        address = f'tcp://127.0.0.1:{silent.getsockname()[1]}'
        code, _, err = squeal(capsys, 'fleet', str(tmp_path / 'bag'), '-o', str(tmp_path / 'out'),
                              '--scheduler', address, '--timeout', '3600')
        left.set()
        thread.join()
    assert (code, 'interrupted' in err) == (130, True)

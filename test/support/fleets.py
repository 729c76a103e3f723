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


"""Engines, clusters and jobs for tests of fleets."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, ExitStack
import os
from pathlib import Path
import socket
import time
from typing import Any

from support.processes import process


class SerialEngine:
    """Runs jobs in this process, in order, as `FleetEngine` does in others."""

    def __init__(self, *_: Any, **__: Any) -> None:
        pass

    def __enter__(self) -> 'SerialEngine':
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def results(self, function: Callable[..., Any], jobs: Mapping[str, tuple[Any, ...]],
                going_on: Callable[[], bool]) -> Iterator[tuple[str, Any]]:
        for key, job in jobs.items():
            if not going_on():
                return
            try:
                found = function(*job)
            except Exception as error:  # noqa: BLE001 - as that of a worker
                found = error
            yield key, found


def held(folder: str) -> int:
    """Return the process number of a worker, once it may: for a job that is ended meanwhile."""
    (Path(folder) / f'{os.getpid()}.held').touch()
    while not (Path(folder) / 'go').exists():
        time.sleep(0.01)
    return os.getpid()


class Release:
    """Ends what holds a job as soon as it is held, by what is given; then lets the next one go."""

    def __init__(self, folder: Path, end: Callable[[int], None]) -> None:
        self._folder, self._end = folder, end
        self.ended = 0

    def __call__(self) -> bool:
        for path in self._folder.glob('*.held') if not self.ended else ():
            self.ended = int(path.stem)
            self._end(self.ended)
            (self._folder / 'go').touch()
        return True


def free_port() -> int:
    with socket.socket() as one:
        one.bind(('127.0.0.1', 0))
        return int(one.getsockname()[1])


@contextmanager
def cluster(port: int) -> Iterator[tuple[Any, Any]]:
    """Run a scheduler and a worker as processes of their own."""
    variables = {**os.environ, 'PYTHONPATH': os.pathsep.join(
        (str(Path(__file__).parents[1]), os.environ.get('PYTHONPATH', '')))}
    with ExitStack() as stack:
        scheduler = stack.enter_context(process(
            ['-m', 'distributed.cli.dask_scheduler', '--host', '127.0.0.1', '--port', str(port),
             '--no-dashboard'], variables, stderr=-3))
        worker = stack.enter_context(process(
            ['-m', 'distributed.cli.dask_worker', f'tcp://127.0.0.1:{port}', '--nthreads', '1',
             '--no-nanny', '--no-dashboard'], variables, stderr=-3))
        yield scheduler, worker

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
Worker processes for independent jobs, each with one BLAS thread.

Each worker takes one job at a time through a pipe of its own, so that it can be ended at any
moment. It ends itself as soon as its parent is gone, however that was ended.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import islice
import multiprocessing
from multiprocessing.connection import Connection, wait
import os
import signal
import threading
import traceback
from typing import Any, TypeVar

from squeal_core.common.errors import SquealError

_Result = TypeVar('_Result')
_HEARTBEAT = 0.25  # s
_THREADS = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS', 'BLIS_NUM_THREADS')


class WorkerLost(SquealError):
    """A worker process that was ended from outside."""


def run_jobs(function: Callable[..., _Result], jobs: Mapping[int, tuple[Any, ...]], workers: int,
             *, while_waiting: Callable[[], bool] | None = None,
             lost: Callable[[int, WorkerLost], _Result] | None = None
             ) -> Iterator[tuple[int, _Result]]:
    """
    Yield the key and the result of each job as it ends.

    Parameters
    ----------
    function : callable
        Of a module, called with the arguments of a job.
    jobs : mapping
        Arguments by key.
    workers : int
        Processes; 0: this one, in order.
    while_waiting : callable, optional
        Of no arguments, called some times a second while workers are busy: whether to hand out
        further jobs.
    lost : callable, optional
        Makes the result of a job, by its key, whose worker was ended from outside.

    Raises
    ------
    WorkerLost
        Where a worker was ended from outside, unless `lost` is given.

    """
    if workers < 1:
        for key, job in jobs.items():
            yield key, function(*job)
        return
    waiting, busy = iter(jobs.items()), dict[Any, int]()

    def hand_out(worker: Any) -> None:
        if while_waiting is None or while_waiting():
            for busy[worker], job in islice(waiting, 1):
                with suppress(BrokenPipeError):  # what is received then tells it
                    worker.send(job)

    with _workers(function) as start:
        for _ in range(min(workers, len(jobs))):
            hand_out(start())
        while busy:
            for ready in wait(busy, None if while_waiting is None else _HEARTBEAT):
                key = busy.pop(ready)
                try:
                    result = _received(ready)
                except WorkerLost as error:
                    if lost is None:
                        raise
                    result, ready = lost(key, error), start()
                hand_out(ready)
                yield key, result
            if while_waiting is not None:
                while_waiting()


def _received(worker: Any) -> Any:
    try:
        result, error = worker.recv()
    except (EOFError, OSError):
        raise WorkerLost('a worker process was ended from outside; is there enough memory? Give '
                         'fewer workers') from None
    if error is not None:
        raise error
    return result


@contextmanager
def _workers(function: Callable[..., Any]) -> Iterator[Callable[[], Connection]]:
    """Yield a function that starts a process and returns its pipe; all end with the context."""
    context = multiprocessing.get_context('spawn')  # a forked process may keep locked locks
    pipes, processes = list[Connection](), []

    def start() -> Connection:
        ours, theirs = context.Pipe()
        process = context.Process(target=_work, args=(function, theirs), daemon=True)
        with _one_thread(), no_interrupts():
            process.start()
        processes.append(process)
        theirs.close()
        pipes.append(ours)
        return ours

    try:
        yield start
    finally:
        for process in processes:
            process.kill()  # nothing that it has would be lost
        for process in processes:
            process.join()
        for pipe in pipes:
            pipe.close()


def _work(function: Callable[..., Any], pipe: Connection) -> None:
    """Do jobs until the parent is gone."""
    # Ctrl-C goes to every process of a terminal, and what ends a job to every process of it; it is
    # the parent's to end its workers
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError):  # the parent is gone
        while True:
            pipe.send(_done(function, pipe.recv()))


def _done(function: Callable[..., Any], job: tuple[Any, ...]) -> tuple[Any, Exception | None]:
    try:
        return function(*job), None
    except Exception as error:  # noqa: BLE001 - it is raised in the parent
        error.add_note(traceback.format_exc())
        return None, error


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def no_interrupts() -> Iterator[None]:
    """Block SIGINT while workers are started, so that they inherit the mask."""
    if not hasattr(signal, 'pthread_sigmask'):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Pin BLAS in processes that start meanwhile: it reads its environment as it loads."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, '1'))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value

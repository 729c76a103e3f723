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

"""Worker processes for independent jobs, each with one BLAS thread."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import as_completed, Future, ProcessPoolExecutor
from contextlib import contextmanager
import multiprocessing
import os
import signal
from typing import Any, TypeVar

_Result = TypeVar('_Result')
_THREADS = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS', 'BLIS_NUM_THREADS')


def run_jobs(function: Callable[..., _Result], jobs: Mapping[int, tuple[Any, ...]],
             workers: int) -> Iterator[tuple[int, _Result]]:
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

    """
    if workers < 1:
        for key, job in jobs.items():
            yield key, function(*job)
        return
    context = multiprocessing.get_context('spawn')  # a forked process may keep locked locks
    with _one_thread(), ProcessPoolExecutor(workers, context, _ignore_interrupts) as pool:
        with _no_interrupts():
            futures: dict[Future[_Result], int] = {
                pool.submit(function, *job): key for key, job in jobs.items()}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _ignore_interrupts() -> None:
    """Ctrl-C goes to every process of a terminal; it is the parent's to end its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _no_interrupts() -> Iterator[None]:
    """Hold Ctrl-C back while workers are started: they inherit that, and are deaf from birth."""
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

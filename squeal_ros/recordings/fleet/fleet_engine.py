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


"""Jobs on Dask, on a local or an existing cluster: timeouts, retries, lost connections."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import suppress
from itertools import islice
import logging
import multiprocessing
from multiprocessing import resource_tracker
import pickle
import queue
import time
from types import TracebackType
from typing import Any, Self
import uuid

try:
    import dask
    from distributed import Client, Future, LocalCluster
    from distributed.scheduler import KilledWorker
except ImportError as error:
    raise ImportError("fleets need dask: pip install -e '.[fleet]' in the checkout") from error

from squeal_core.common.errors import in_one_line, SquealError
from squeal_core.common.worker_processes import no_interrupts
from squeal_ros.recordings.fleet.fleet_scheduler import answers, silence, TICK
from squeal_ros.recordings.fleet.fleet_task import FleetError

_PROBE = 5.0  # s without a result, after which the scheduler is asked whether it is there
_WINDOW = 1_000  # jobs that the scheduler has at once
_CLOSING = 10.0  # s
_STARTING = 600.0  # s that a worker of a local cluster may take to start, on a busy machine
_OWN = 'Dask Worker'  # begins the names of the worker processes of a local cluster


class FleetLost(FleetError):
    """The rest of a run that cannot be computed: finished results stay."""


class FleetEngine:
    """
    Runs jobs on a Dask cluster; a context manager.

    Parameters
    ----------
    address : str
        Of a scheduler; '': a cluster of processes on this machine.
    workers : int
        Processes of that cluster.
    retries : int
        How often a job is tried again that fails, loses its worker or its scheduler.
    timeout : float
        For how long a scheduler may not answer, or have no worker [s].
    stall : float
        For how long no job may end [s].

    """

    def __init__(self, address: str = '', *, workers: int = 1, retries: int = 3,
                 timeout: float = 60.0, stall: float = 7200.0) -> None:
        self._address, self._workers = address, workers
        self._where = f'the scheduler {address}' if address else 'the local cluster'
        self._retries, self._stall = retries, stall
        self._timeout = timeout if address else max(timeout, _STARTING)
        self._cluster: Any = None
        self._client: Any = None

    def __enter__(self) -> Self:
        silence()
        dask.config.set({'distributed.scheduler.allowed-failures': self._retries,
                         # none waits at a worker, to be suspected where the one before ends it
                         'distributed.scheduler.worker-saturation': 1.0,
                         # a worker that starts anew is no lost one
                         'distributed.deploy.lost-worker-timeout': f'{_STARTING:.0f}s',
                         'distributed.comm.timeouts.connect': self._timeout})
        try:
            if not self._address:
                self._start()
            self._connect()
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._close()

    def _close(self) -> None:
        """Disconnect, and end started processes: results are on the disk by now."""
        for one in (self._client, self._cluster):
            if one is not None:
                with suppress(Exception):  # it is not to hide what went before
                    one.close(timeout=_CLOSING)
        if not self._address:
            for process in multiprocessing.active_children():
                if process.name.startswith(_OWN):
                    process.kill()
        self._client = self._cluster = None

    def _start(self) -> None:
        """Start a cluster of processes on this machine."""
        try:
            resource_tracker.ensure_running()  # which lets interrupts through as it starts
            with no_interrupts():  # Ctrl-C is for this process alone
                self._cluster = LocalCluster(
                    n_workers=self._workers, threads_per_worker=1, processes=True,
                    silence_logs=logging.CRITICAL, scheduler_kwargs={
                        'dashboard': False, 'dashboard_address': '127.0.0.1:0'})
        except (OSError, ValueError, ImportError, RuntimeError) as error:
            raise FleetLost(f'{self._workers} worker processes', 'could not be started '
                            f'({in_one_line(error, 120)})', 'give fewer --workers') from None

    def _connect(self, going_on: Callable[[], bool] = lambda: True) -> bool:
        """Connect to the scheduler; return whether that was before the work was stopped."""
        try:
            if self._address and not answers(self._address, self._timeout, going_on):
                return False
            self._client = Client(self._cluster or self._address, timeout=self._timeout,
                                  set_as_default=False)
        except (OSError, ValueError, ImportError, RuntimeError) as error:  # or no address
            raise FleetLost(
                self._where, f'cannot be reached within {self._timeout:g} s '
                f'({in_one_line(error, 120)})', 'check --scheduler, and that `dask scheduler` '
                'runs there') from None
        return True

    def results(self, function: Callable[..., Any], jobs: Mapping[str, tuple[Any, ...]],
                going_on: Callable[[], bool]) -> Iterator[tuple[str, Any]]:
        """
        Yield the key and the result of each job as it ends; of one that failed, the error.

        Parameters
        ----------
        function : callable
            Of a module, called with the arguments of a job; it may be called again.
        jobs : mapping
            Arguments by key.
        going_on : callable
            Of no arguments, called several times a second: whether to go on.

        Raises
        ------
        FleetLost
            Where the scheduler is gone, hangs, has no worker or ends no job.

        """
        if not going_on():
            return
        left = dict(jobs)
        for attempt in range(self._retries + 1):
            if attempt:
                with suppress(Exception):  # it is lost
                    self._client.close(timeout=_CLOSING)
                if not self._connect(going_on):
                    return
            run = _Attempt(self._client, function, left, self._retries, going_on)
            yield from run.results(_Guard(self._client, self._timeout, self._stall, self._where))
            if not left or run.stopped:
                return
        raise FleetLost(self._where, f'was lost {self._retries + 1} times',
                        'see its log, then run this again: what is finished is kept')


class _Attempt:
    """Jobs on one connection to a scheduler; takes those that end out of `left`."""

    def __init__(self, client: Any, function: Callable[..., Any],
                 left: dict[str, tuple[Any, ...]], retries: int,
                 going_on: Callable[[], bool]) -> None:
        self._client, self._function, self._left = client, function, left
        self._retries, self._going_on = retries, going_on
        self._done: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._running: dict[str, tuple[str, Future]] = {}
        self.stopped = False

    def results(self, guard: '_Guard') -> Iterator[tuple[str, Any]]:
        """Yield as `FleetEngine.results` does, up to the end or the loss of the connection."""
        waiting, run = iter(list(self._left.items())), uuid.uuid4().hex[:8]
        try:
            while True:
                for key, job in islice(waiting, _WINDOW - len(self._running)):
                    self._submit(f'squeal-{run}-{key}', key, job)
                if not self._running:
                    return
                ended = self._next()
                if ended is None:
                    guard.check()
                elif ended.status in ('cancelled', 'lost'):
                    return  # with the connection
                elif result := self._taken(ended, guard.timeout):
                    guard.ended()
                    yield result
                self.stopped = not self._going_on()
                if self.stopped:
                    return
        except CancelledError:
            return  # likewise
        finally:
            for _, future in self._running.values():
                future.cancel()

    def _submit(self, name: str, key: str, job: tuple[Any, ...]) -> None:
        future = self._client.submit(pickle.loads, pickle.dumps(_Call(self._function, job)),
                                     key=name, retries=self._retries, pure=False)
        self._running[name] = key, future
        future.add_done_callback(self._done.put)

    def _next(self) -> Any:
        try:
            return self._done.get(timeout=TICK)
        except queue.Empty:
            return None

    def _taken(self, ended: Future, timeout: float) -> tuple[str, Any] | None:
        """Return key and result of a job; None: its worker was lost before it was fetched."""
        try:
            result = ended.result(timeout=timeout) if ended.status == 'finished' else _of_job(
                ended.exception(timeout=timeout))
        except TimeoutError:
            ended.add_done_callback(self._done.put)
            return None
        key, _ = self._running.pop(ended.key)
        del self._left[key]
        return key, result


class _Call:
    """
    A call that is made by unpickling it, within the job.

    An import that fails as Dask itself unpickles a task ends the worker, which is restarted.
    """

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        self._call = function, arguments

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self._call


def _of_job(error: Exception) -> Exception:
    if isinstance(error, KilledWorker):
        return SquealError('its worker process was ended from outside each time; is there enough '
                           'memory? Give fewer --workers')
    return error


class _Guard:
    """Raises where a scheduler hangs, has no worker, or ends no job for too long."""

    def __init__(self, client: Any, timeout: float, stall: float, where: str) -> None:
        self._client, self.timeout, self._stall, self._where = client, timeout, stall, where
        self.ended()

    def ended(self) -> None:
        """Record that a job ended."""
        self._last = self._probed = self._with_workers = time.monotonic()

    def check(self) -> None:
        """Check the state of the scheduler, now and then."""
        now = time.monotonic()
        if now - self._probed < min(_PROBE, self.timeout):
            return
        try:
            workers = self._client.sync(self._client.scheduler.ncores,
                                        callback_timeout=self.timeout)
        except TimeoutError:
            raise self._lost(f'has not answered for {self.timeout:g} s') from None
        except OSError:
            return  # the connection is lost: all jobs are cancelled then
        self._probed = time.monotonic()
        if workers:
            self._with_workers = self._probed
        elif self._probed - self._with_workers > self.timeout:
            raise self._lost(f'has had no worker for {self.timeout:g} s')
        if self._probed - self._last > self._stall:
            raise self._lost(f'has ended no recording for {self._stall:g} s')

    def _lost(self, what: str) -> FleetLost:
        return FleetLost(self._where, what, 'see its log and its workers, then run this again: '
                         'what is finished is kept')

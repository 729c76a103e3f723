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
Replay in two processes: this one reads the bag, another evaluates the brakes and writes.

The other process gets prepared ticks in blocks through a pipe, and waits for one before it takes
the next, so memory does not grow with the bag. It runs in a session of its own: an interrupt
reaches this process, whose pipe then ends before the last block, and the other one removes what
it has written. So it does when this process is killed.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Iterator  # noqa: I100
from contextlib import contextmanager, suppress
import gc
import os
import pickle
import subprocess
import sys
from types import TracebackType
from typing import Any, BinaryIO, IO, NoReturn

from squeal_core.common.errors import in_one_line, SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.vehicle_monitor import Assessment, completed, PreparedTick
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_ros.recordings.replay import Outputs, Replay

_FEW_MESSAGES = 20_000  # read in less time than a process takes to start
_START = ('import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); '
          'from squeal_ros.recordings.output_process import work; work()')
_ALLOCATIONS = 100_000  # from one search for garbage to the next; a block of ticks has 10,000
_PATIENCE = 60.0  # s for a block that is being evaluated when this process is interrupted


class _EndedEarlyError(Exception):
    """The pipe ended before the last block."""


def write_replay(replay: Replay, outputs: Outputs, *, parallel: bool | None = None) -> None:
    """
    Write the outputs of a replay.

    Parameters
    ----------
    replay : Replay
    outputs : Outputs
        Its summary and its events are those of the replay afterwards.
    parallel : bool, optional
        In two processes; by default where there are two processors and the bag is not short.

    Raises
    ------
    SquealError
        As iterating over the replay, and writing the outputs, does.

    """
    if parallel is None:
        parallel = (os.cpu_count() or 1) > 1 and replay.messages >= _FEW_MESSAGES
    if not parallel:
        outputs.write(iter(replay))
        return
    with _OutputProcess(outputs, replay.model) as process, _rare_collections():
        for block in replay.blocks():
            process.send(block)
        outputs.summary, outputs.detector = process.result()


@contextmanager
def _rare_collections() -> Iterator[None]:
    """Look for cyclic garbage, of which ticks leave none, less often."""
    before = gc.get_threshold()
    gc.set_threshold(_ALLOCATIONS)
    try:
        yield
    finally:
        gc.set_threshold(*before)


class _OutputProcess:
    """The process that evaluates and writes; a context manager."""

    def __init__(self, outputs: Outputs, model: BrakeModel) -> None:
        self._job = outputs, model

    def __enter__(self) -> '_OutputProcess':
        self._process = subprocess.Popen(
            [sys.executable, '-P', '-c', _START], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            start_new_session=True)
        self.send(sys.path)
        self.send(self._job)
        return self

    def send(self, what: object) -> None:
        """Hand over a block of ticks; waits until the one before it was taken."""
        pipe = self._process.stdin
        assert pipe is not None
        try:
            pickle.dump(what, pipe, protocol=pickle.HIGHEST_PROTOCOL)
            pipe.flush()
        except BrokenPipeError:
            self._raise_error()

    def result(self) -> Any:
        """Return summary and events, once all is written."""
        self.send(None)
        return self._received()

    def _raise_error(self) -> NoReturn:
        self._received()
        raise AssertionError('a process that wrote all and took less')

    def _received(self) -> Any:
        """Return the result of the process; raise its error."""
        self._close(self._process.stdin)
        try:
            assert self._process.stdout is not None
            kind, *values = pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError):
            raise SquealError('the process that writes the outputs ended with code '
                              f'{self._process.wait()}; give it memory, or see what it says '
                              'above') from None
        if kind == 'error':
            _raise(*values)
        return values

    @staticmethod
    def _close(pipe: IO[bytes] | None) -> None:
        if pipe is not None and not pipe.closed:
            with suppress(BrokenPipeError):
                pipe.close()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._close(self._process.stdin)
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._close(self._process.stdout)


def _raise(number: int | None, text: str) -> NoReturn:
    raise SquealError(text) if number is None else OSError(number, text)


def work() -> None:
    """Evaluate and write what comes through the standard input; for the process itself."""
    outputs, model = pickle.load(sys.stdin.buffer)
    gc.set_threshold(_ALLOCATIONS)
    try:
        outputs.write(_assessed(outputs, model, sys.stdin.buffer))
        result: tuple[object, ...] = 'done', outputs.summary, outputs.detector
    except _EndedEarlyError:
        return
    except SquealError as error:
        result = 'error', None, str(error)
    except OSError as error:
        result = 'error', error.errno, error.strerror or in_one_line(error)
    pickle.dump(result, sys.stdout.buffer)
    sys.stdout.buffer.flush()


def _assessed(outputs: Outputs, model: BrakeModel, blocks: BinaryIO
              ) -> Iterator[tuple[Assessment, ...]]:
    stability = VehicleStability(model, outputs.settings)
    for block in _received(blocks):
        yield from completed(stability, block)


def _received(stream: BinaryIO) -> Iterator[list[PreparedTick]]:
    """Yield blocks until the one that says that there are no more."""
    while True:
        try:
            block = pickle.load(stream)
        except (EOFError, pickle.UnpicklingError):
            raise _EndedEarlyError from None
        if block is None:
            return
        yield block

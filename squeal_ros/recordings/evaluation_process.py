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
Replay in two processes: this one reads and writes, the other evaluates the brakes in between.

The other process gets prepared ticks in blocks through a pipe and answers with their records.
While it evaluates a block, this one writes the records of the block before and prepares the next,
so that memory does not grow with the bag. It has no files, runs in a session of its own, so that
an interrupt reaches this process only, and ends when its pipe ends.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Iterable, Iterator  # noqa: I100
from contextlib import contextmanager, suppress
import gc
import os
import pickle
import subprocess
import sys
from types import TracebackType
from typing import Any

from squeal_core.common.errors import SquealError
from squeal_core.monitor.assessment import PreparedTick
from squeal_core.monitor.vehicle_evaluator import VehicleEvaluator
from squeal_ros.recordings.replay import Replay
from squeal_ros.recordings.replay_outputs import Outputs
from squeal_ros.recordings.tick_record import TickRecord

_FEW_MESSAGES = 20_000  # read in less time than a process takes to start
_START = ('import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); '
          'from squeal_ros.recordings.evaluation_process import work; work()')
_ALLOCATIONS = 100_000  # from one search for garbage to the next; a block of ticks has 10,000


def write_replay(replay: Replay, outputs: Outputs, *, parallel: bool | None = None) -> None:
    """
    Write the outputs of a replay.

    Parameters
    ----------
    replay : Replay
        What is written.
    outputs : Outputs
        Its summary and its events are those of the replay afterwards.
    parallel : bool, optional
        In two processes; by default where there are two processors and the bag is not short.

    Raises
    ------
    SquealError
        As iterating over the replay, and writing the outputs, does.

    """
    outputs.recorder.unknown_risk = replay.unknown_risk
    if parallel is None:
        parallel = (os.cpu_count() or 1) > 1 and replay.messages >= _FEW_MESSAGES
    if not parallel:
        outputs.write_records(map(outputs.recorder.record, replay), replay)
        return
    with _EvaluationProcess(replay, outputs) as process, _rare_collections():
        outputs.write_records(process.records(replay.blocks()), replay)


@contextmanager
def _rare_collections() -> Iterator[None]:
    """Look for cyclic garbage, of which ticks leave none, less often."""
    before = gc.get_threshold()
    gc.set_threshold(_ALLOCATIONS)
    try:
        yield
    finally:
        gc.set_threshold(*before)


class _EvaluationProcess:
    """The process that evaluates; a context manager."""

    def __init__(self, replay: Replay, outputs: Outputs) -> None:
        self._replay, self._outputs = replay, outputs

    def __enter__(self) -> '_EvaluationProcess':
        self._process = subprocess.Popen(
            [sys.executable, '-P', '-c', _START], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            start_new_session=True)
        self._send(sys.path)
        self._send((self._replay.model, self._replay.settings, self._outputs.recorder))
        return self

    def records(self, blocks: Iterable[list[PreparedTick]]) -> Iterator[TickRecord]:
        """Yield the records of all ticks; the outputs have the recorder of the drive then."""
        answered: list[TickRecord] = []
        pending = False
        for block in blocks:
            if pending:  # before the next is sent: both pipes may be too short for a block
                answered = self._received()
            self._send(block)
            pending = True
            yield from answered
        if pending:
            yield from self._received()
        self._send(None)
        self._outputs.recorder = self._received()

    def _send(self, what: object) -> None:
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # its answer says why
            pickle.dump(what, self._process.stdin, protocol=pickle.HIGHEST_PROTOCOL)
            self._process.stdin.flush()

    def _received(self) -> Any:
        assert self._process.stdout is not None
        try:
            answer = pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError):
            raise SquealError('the process that evaluates the brakes ended with code '
                              f'{self._process.wait()}; give it memory, or see what it says '
                              'above') from None
        if isinstance(answer, str):
            raise SquealError(answer)
        return answer

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._process.kill()  # it has nothing to clear up
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with suppress(BrokenPipeError):
                pipe.close()


def work() -> None:
    """Answer blocks of the standard input by their records; for the process itself."""
    gc.set_threshold(_ALLOCATIONS)
    with suppress(EOFError, pickle.UnpicklingError, BrokenPipeError):  # the other process ended
        try:
            model, settings, recorder = pickle.load(sys.stdin.buffer)
            evaluator = VehicleEvaluator(model, settings)
            while (block := pickle.load(sys.stdin.buffer)) is not None:
                _answer([*map(recorder.record, evaluator.complete(block))])
            _answer(recorder)
        except SquealError as error:
            _answer(str(error))


def _answer(what: object) -> None:
    pickle.dump(what, sys.stdout.buffer, protocol=pickle.HIGHEST_PROTOCOL)
    sys.stdout.buffer.flush()

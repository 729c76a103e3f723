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
Replay in processes: this one reads and writes, one or two others evaluate the brakes in between.

The others get prepared ticks in blocks through pipes, each those of its brakes, and answer with
their records. While they evaluate, this one writes the records before and prepares the next ticks,
so that memory does not grow with the bag. They have no files, run in sessions of their own, so
that an interrupt reaches this process only, and end when their pipes end.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Iterator, Sequence  # noqa: I100
from contextlib import contextmanager, ExitStack, suppress
import gc
from itertools import chain, islice
import os
import pickle
import subprocess
import sys
from types import TracebackType
from typing import Any

from squeal_core.common.errors import SquealError
from squeal_core.monitor.assessment import PreparedTick
from squeal_core.monitor.vehicle_evaluator import VehicleEvaluator
from squeal_ros.recordings.replay.evaluation_worker import ALLOCATIONS, pickled, SIZE
from squeal_ros.recordings.replay.replay import Replay
from squeal_ros.recordings.replay.replay_outputs import Outputs
from squeal_ros.recordings.replay.tick_record import Recorder, TickRecord

_FEW_MESSAGES = 20_000  # read in less time than a process takes to start
# from which a second one that evaluates saves more than the 2 s of processor time of its start
_MANY_MESSAGES = 100_000
# blocks that are handed over together: brakes are released in some, and applied in others
_AT_ONCE = 4
_START = ('import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); '
          'from squeal_ros.recordings.replay.evaluation_worker import work; work()')


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
        In several processes; by default where there are two processors and the bag is not short.

    Raises
    ------
    SquealError
        As iterating over the replay, and writing the outputs, does.

    """
    if parallel is None:
        parallel = (os.cpu_count() or 1) > 1 and replay.messages >= _FEW_MESSAGES
    if not parallel:
        evaluator = VehicleEvaluator(replay.model, replay.settings)
        outputs.recorder.unknown_risk = evaluator.risk.unknown
        outputs.write_records(map(outputs.recorder.record, replay.evaluated_by(evaluator)),
                              replay)
        return
    with _Evaluation(replay, outputs) as evaluation, _rare_collections():
        outputs.write_records(evaluation.records(), replay)


@contextmanager
def _rare_collections() -> Iterator[None]:
    """Collect cyclic garbage, of which ticks leave none, less often."""
    before = gc.get_threshold()
    gc.set_threshold(ALLOCATIONS)
    try:
        yield
    finally:
        gc.set_threshold(*before)


class _Evaluation(ExitStack):
    """
    The evaluation of a replay in other processes; a context manager.

    Two of them for many messages of several brakes: reading and writing take as long as either.
    """

    def __init__(self, replay: Replay, outputs: Outputs) -> None:
        super().__init__()
        self._replay, self._outputs = replay, outputs

    def __enter__(self) -> '_Evaluation':
        super().__enter__()
        settings = self._replay.settings
        count = len(settings.brakes)
        half = (count + 1) // 2 if self._replay.messages >= _MANY_MESSAGES else count
        self._parts = [part for part in (slice(0, half), slice(half, None))
                       if settings.brakes[part]]
        self._processes = [self.enter_context(_EvaluationProcess()) for _ in self._parts]
        for process, part in zip(self._processes, self._parts, strict=True):
            process.send(pickled((self._replay.model, settings,
                                  Recorder(settings, self._outputs.node, part))))
        return self

    def records(self) -> Iterator[TickRecord]:
        """Yield the records of all ticks; the outputs have the recorder of the drive then."""
        blocks, pending = self._replay.blocks(), False
        while some := list(islice(blocks, _AT_ONCE)):
            packed = [*map(pickled, self._split(some))]
            # before the next are sent: both pipes may be too short for a block
            answers = [process.receive() for process in self._processes if pending]
            for process, data in zip(self._processes, packed, strict=True):
                process.send(data)
            pending = True
            yield from _records(answers)  # while the others evaluate
        if pending:
            yield from _records([process.receive() for process in self._processes])
        self._finish()

    def _split(self, blocks: list[list[PreparedTick]]) -> Iterator[list[list[PreparedTick]]]:
        """Yield the ticks of the brakes of each process."""
        for part in self._parts:
            yield [[tick[part] for tick in block] for block in blocks]

    def _finish(self) -> None:
        for process in self._processes:
            process.send(pickled(None))
        answers = [_unpickled(process.receive()) for process in self._processes]
        (self._outputs.recorder, self._replay.risk_warnings), *others = answers
        for recorder, _ in others:
            self._outputs.recorder.add_brakes(recorder)


def _records(answers: Sequence[bytes]) -> Iterator[TickRecord]:
    """Return the records in the answers of all processes to the same ticks."""
    parts = [*map(_unpickled, answers)]
    if len(parts) < 2:
        return chain.from_iterable(parts)
    return map(TickRecord.joined, zip(*parts, strict=True))


def _unpickled(answer: bytes) -> Any:
    result = pickle.loads(answer)
    if isinstance(result, str):
        raise SquealError(result)
    return result


class _EvaluationProcess:
    """A process that evaluates; a context manager."""

    def __enter__(self) -> '_EvaluationProcess':
        self._process = subprocess.Popen(
            [sys.executable, '-P', '-c', _START], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            start_new_session=True)
        self.send(pickled(sys.path))
        return self

    def send(self, data: bytes) -> None:
        """Send a pickle."""
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # its answer says why
            self._process.stdin.write(data)
            self._process.stdin.flush()

    def receive(self) -> bytes:
        """Return an answer, pickled."""
        pipe = self._process.stdout
        assert pipe is not None
        header = pipe.read(SIZE.size)
        if len(header) == SIZE.size:
            size, = SIZE.unpack(header)
            answer = pipe.read(size)
            if len(answer) == size:
                return answer
        raise SquealError('the process that evaluates the brakes ended with code '
                          f'{self._process.wait()}; give it memory, or see what it says above')

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._process.kill()  # it has nothing to clear up
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with suppress(BrokenPipeError):
                pipe.close()

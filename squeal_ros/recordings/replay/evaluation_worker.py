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

"""The process that evaluates the brakes of a replay: prepared ticks in, their records out."""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from contextlib import suppress  # noqa: I100
import gc
from itertools import chain
import pickle
import struct
import sys

from squeal_core.common.errors import SquealError
from squeal_core.monitor.vehicle_evaluator import VehicleEvaluator

ALLOCATIONS = 100_000  # from one search for garbage to the next; a block of ticks has 10,000
SIZE = struct.Struct('<Q')  # of an answer, which stands before it [bytes]


def work() -> None:
    """Answer blocks of the standard input by their records; for the process itself."""
    gc.set_threshold(ALLOCATIONS)
    with suppress(EOFError, pickle.UnpicklingError, BrokenPipeError):  # the other process ended
        try:
            model, settings, recorder = pickle.load(sys.stdin.buffer)
            evaluator = VehicleEvaluator(model, settings)
            recorder.unknown_risk = evaluator.risk.unknown
            while (blocks := pickle.load(sys.stdin.buffer)) is not None:
                ticks = chain.from_iterable(map(evaluator.complete, blocks))
                _answer([*map(recorder.record, ticks)])
            _answer((recorder, evaluator.risk.warnings))
        except SquealError as error:
            _answer(str(error))


def _answer(what: object) -> None:
    data = pickled(what)
    sys.stdout.buffer.write(SIZE.pack(len(data)))
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()


def pickled(what: object) -> bytes:
    """Return an object as it is sent."""
    return pickle.dumps(what, protocol=pickle.HIGHEST_PROTOCOL)

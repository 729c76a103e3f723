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

"""Anchors being made beside the work: which are asked for, when they are due, how patiently."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
import math
from typing import NamedTuple

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.surrogate.expansion_table import TableEntry
from squeal_core.surrogate.neighbours import alike
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.steps import Steps
from squeal_core.surrogate.workers import Allowance, Work, Worker

_PATIENCE = 6  # anchors nobody used before the next are asked for less often
_COST = 5  # full solves that an anchor costs as much as
_STEPS = 4  # in which it is made
_BESIDE = 3  # times its cost that it takes beside full solves, which keep its thread from running
_PENDING = 2  # anchors being made at a time: brakes of both axles ask


class Count(NamedTuple):
    """Solves so far, and how many of them were full ones."""

    solves: int
    full: int


@dataclass(frozen=True)
class Request:
    """An anchor that was asked for; `expected` for points that may come, not for one that did."""

    point: OperatingPoint
    due: Count  # from which on its steps are, whichever comes first
    work: Work[SpectralExpansion]
    expected: bool


class AnchorRequests:
    """
    Requests in order of their due, by count alone, so that the same solves give the same.

    Parameters
    ----------
    making : callable
        Makes the anchor at a point, in steps.

    """

    def __init__(self, making: Callable[[OperatingPoint], 'Steps[SpectralExpansion]']) -> None:
        self._making = making
        self._worker = Worker('anchors', urgent=True)
        self._pending: list[Request] = []
        self._latest: deque[TableEntry] = deque(maxlen=_PATIENCE - 1)
        self._unused = 0  # anchors in a row that were never used
        self._pause_until = 0

    def ask(self, point: OperatingPoint, brakes: int, now: Count, delay: int, *,
            lacking: int = 1, expected: bool = False) -> bool:
        """
        Have an anchor made here, unless one is being made near here, or enough are.

        Where points are solved in full it is due earlier: when no more of it is left than the full
        solves of a tick. Tells whether it is asked for.

        Parameters
        ----------
        point : OperatingPoint
            Operating point.
        brakes : int
            Of a call, which is allowed as many steps.
        now : Count
            Present time [ns].
        delay : int
            Solves from now to its first use.
        lacking : int
            How many of the brakes lack an anchor.
        expected : bool
            Whether it is for points that may come.

        """
        if now.solves < self._pause_until or len(self._pending) >= _PENDING or any(
                alike(point, request.point) for request in self._pending):
            return False
        before = len(self._pending)
        delay -= brakes * (_STEPS - 1)  # a call grants one
        solves = max(now.solves, self._pending[-1].due.solves - delay // 4 if before else 0)
        full = max(lacking, _BESIDE * (_COST - lacking)) * (before + 1) - (
            brakes * ((_STEPS - 1) // brakes))  # a call grants one a brake
        self._pending.append(Request(point, Count(solves + delay, now.full + full),
                                     self._worker.begin(self._making(point)), expected))
        return True

    def over(self, now: Count, allowance: Allowance) -> Request | None:
        """
        Grant steps to the first, if it is due; return it once all of its steps are granted.

        One at a time, so that calls are kept little, but where all of them save full solves.
        """
        if not self._pending:
            return None
        first = self._pending[0]
        most = (math.inf if now.full >= first.due.full else
                1 if now.solves >= first.due.solves else 0)
        if not most or not self._worker.granted(first.work, allowance, most):
            return None
        return self._pending.pop(0)

    def note(self, entry: TableEntry | None, now: Count, delay: int) -> None:
        """Learn what became of one that was asked for, None: nothing; wait after many in vain."""
        if entry is not None and any(one.hits for one in self._latest):
            self._unused = 0
        else:
            self._unused += 1
        if entry is not None:
            self._latest.append(entry)
        pause = 2 ** min(max(self._unused - _PATIENCE, 0), _PATIENCE) - 1
        self._pause_until = now.solves + pause * delay

    def close(self) -> None:
        """End the worker, forget the requests; new ones begin another."""
        self._worker.close()
        self._pending = []

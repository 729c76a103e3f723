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

"""Threads beside the work, which give way to it, and works that it never waits for at length."""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
import math
import os
import sys
import threading
from typing import Any, Generic, TypeVar

from squeal_core.surrogate.steps import Call, Steps

_NICE = 10
_PATIENCE = 0.02  # s that a tick waits for a worker's step, about what it takes to make it
_here = threading.local()
_Result = TypeVar('_Result')


class Allowance:
    """
    How many steps of works a tick may be kept by, if need be; without end until renewed.

    It is used up whether a worker was quicker or not, so it does not depend on time what is done.
    """

    def __init__(self) -> None:
        self._left = math.inf
        self._patience = _PATIENCE

    @property
    def endless(self) -> bool:
        return math.isinf(self._left)

    def renew(self, steps: int) -> None:
        """Begin a tick, which may be kept by so many steps."""
        self._left, self._patience = steps, _PATIENCE

    def take(self) -> bool:
        """Take one step of it; tell whether there was one."""
        self._left -= 1
        return self._left >= 0

    def wait(self, changed: threading.Condition, kept_up: Callable[[], bool]) -> None:
        """Wait for a worker's next step, but not again in a tick if it does not come soon."""
        if not changed.wait_for(kept_up, self._patience):
            self._patience = 0.0


class Work(Generic[_Result]):
    """
    Work in steps, each made by whoever gets done with it first, a worker or its owner.

    Parameters
    ----------
    steps : Steps

    """

    def __init__(self, steps: 'Steps[_Result]') -> None:
        self._steps = steps
        self._changed = threading.Condition()
        self._call: Call | None = _nothing
        self._made, self._granted = 0, 1  # to begin is hardly a step
        self._result: _Result
        self._error: Exception | None = None

    @property
    def finished(self) -> bool:
        return self._call is None

    def result(self) -> _Result:
        """Return what a finished work came to, or raise what it raised."""
        if self._error is not None:
            raise self._error
        return self._result

    def go_on(self) -> bool:
        """Make a step, unless it is made elsewhere meanwhile; tell whether there are more."""
        with self._changed:
            call, number = self._call, self._made
        if call is None:
            return False
        found, error = _made(call)
        with self._changed:
            if number == self._made:
                self._send(found, error)
                self._changed.notify_all()
            return not self.finished

    def _send(self, found: Any, error: Exception | None) -> None:
        self._made += 1
        try:
            self._call = self._steps.send(found) if error is None else self._steps.throw(error)
        except StopIteration as end:
            self._call, self._result = None, end.value
        except Exception as failure:
            self._call, self._error = None, failure

    def grant(self, allowance: Allowance, most: float = math.inf) -> bool:
        """Have made what is allowed; tell whether all of it is, by what was granted so far."""
        while most > 0 and allowance.take():
            most -= 1
            self._granted += 1
            with self._changed:
                allowance.wait(self._changed, self._kept_up)
            while not self._kept_up():
                self.go_on()
            if self.finished and self._made <= self._granted:
                return True
        return False

    def _kept_up(self) -> bool:
        """Tell whether all that is granted is made, or there is no more to make."""
        with self._changed:
            return self.finished or self._made >= self._granted


class Worker:
    """
    Does works one after the other beside the caller.

    Its thread begins with the first of them; on Linux it has a lower priority than the caller's.

    Parameters
    ----------
    name : str
        Of the thread.
    urgent : bool
        Whether other workers pause while it works.

    """

    def __init__(self, name: str, *, urgent: bool = False) -> None:
        self._name, self._urgent = name, urgent
        self._pool: ThreadPoolExecutor | None = None
        self._line: deque[Work[Any]] = deque()
        self._ending = threading.Event()

    def begin(self, steps: 'Steps[_Result]', *, beside: bool = True) -> 'Work[_Result]':
        """Have a work done after those before it: beside the caller, or at once while it waits."""
        work = Work(steps)
        self._line.append(work)
        if not beside:
            while work.go_on():
                pass
            return work
        if self._pool is None:
            self._pool = ThreadPoolExecutor(
                1, self._name, initializer=_give_way, initargs=(self._urgent,))
        self._pool.submit(self._do, work)
        return work

    def _do(self, work: Work[Any]) -> None:
        with _urgency.felt(self._urgent):
            while not self._ending.is_set() and work.go_on():
                pause()

    def granted(self, work: Work[Any], allowance: Allowance, most: float = math.inf) -> bool:
        """
        Grant steps to works in their order; tell whether one of them is finished by that.

        What is granted and not made by then is made here. One that was never finished, as the
        worker was closed, is so for good.

        Parameters
        ----------
        work : Work
            What is to be done.
        allowance : Allowance
            Time that may be spent.
        most : float
            Steps to grant to each, though more be allowed.

        """
        while work in self._line:
            if not self._line[0].grant(allowance, most):
                return False
            self._line.popleft()
        return True

    def close(self) -> None:
        """End the thread after the step it is at, forget the works; a new one begins another."""
        self._line.clear()
        if self._pool is not None:
            self._ending.set()
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._ending.clear()
            self._pool = None


class _Urgency:
    """Whether urgent work is under way."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._works = 0

    @contextmanager
    def felt(self, urgent: bool) -> Iterator[None]:
        """Let others pause for as long as the context of urgent work lasts."""
        self._add(int(urgent))
        try:
            yield
        finally:
            self._add(-int(urgent))

    def _add(self, change: int) -> None:
        with self._changed:
            self._works += change
            self._changed.notify_all()

    def wait(self) -> None:
        """Return once there is none."""
        with self._changed:
            self._changed.wait_for(lambda: not self._works)


_urgency = _Urgency()


def pause() -> None:
    """Wait, in a worker that is not urgent itself, while urgent work is under way."""
    if getattr(_here, 'pauses', False):
        _urgency.wait()


def _nothing() -> None:
    """Begin: what is before the first call is no call."""


def _made(call: Call) -> tuple[Any, Exception | None]:
    try:
        return call(), None
    except Exception as error:
        return None, error


def _give_way(urgent: bool) -> None:
    _here.pauses = not urgent
    if sys.platform == 'linux':  # where a thread has a priority of its own
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)

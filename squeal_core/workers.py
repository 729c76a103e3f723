"""Threads beside the work, which give way to it, and to those of them that are urgent."""

from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
import os
import sys
import threading
from typing import Any, TypeVar

_NICE = 10
_here = threading.local()
_Result = TypeVar('_Result')


class Worker:
    """Does tasks one after the other: beside the caller, or at once while it waits.

    Its thread begins with the first task that asks for it; on Linux it has a lower priority than
    the caller's.

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

    def submit(self, beside: bool, task: Callable[..., _Result], *arguments: Any,
               **options: Any) -> 'Future[_Result]':
        """Have a task done; its result, or what it raised, is in the future."""
        if beside:
            if self._pool is None:
                self._pool = ThreadPoolExecutor(
                    1, self._name, initializer=_give_way, initargs=(self._urgent,))
            return self._pool.submit(self._do, task, *arguments, **options)
        done: Future[_Result] = Future()
        try:
            done.set_result(task(*arguments, **options))
        except Exception as error:
            done.set_exception(error)
        return done

    def _do(self, task: Callable[..., _Result], *arguments: Any, **options: Any) -> _Result:
        if not self._urgent:
            return task(*arguments, **options)
        with _urgency.felt():
            return task(*arguments, **options)

    def close(self) -> None:
        """End the thread after the task it is at, cancel the others; a new task begins another."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None


class _Urgency:
    """Whether urgent work is under way."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._works = 0

    @contextmanager
    def felt(self) -> Iterator[None]:
        """Let others pause for as long as the context lasts."""
        self._add(1)
        try:
            yield
        finally:
            self._add(-1)

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


def gives_way() -> bool:
    """Tell whether this thread is a worker's."""
    return getattr(_here, 'gives_way', False)


def _give_way(urgent: bool) -> None:
    _here.gives_way, _here.pauses = True, not urgent
    if sys.platform == 'linux':  # where a thread has a priority of its own
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)

"""A thread beside the work, which gives way to it."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
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
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._pool: ThreadPoolExecutor | None = None

    def submit(self, beside: bool, task: Callable[..., _Result], *arguments: Any,
               **options: Any) -> 'Future[_Result]':
        """Have a task done; its result, or what it raised, is in the future."""
        if beside:
            if self._pool is None:
                self._pool = ThreadPoolExecutor(1, self._name, initializer=_give_way)
            return self._pool.submit(task, *arguments, **options)
        done: Future[_Result] = Future()
        try:
            done.set_result(task(*arguments, **options))
        except Exception as error:
            done.set_exception(error)
        return done

    def close(self) -> None:
        """End the thread after the task it is at, cancel the others; a new task begins another."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None


def gives_way() -> bool:
    """Tell whether this thread is a worker's."""
    return getattr(_here, 'gives_way', False)


def _give_way() -> None:
    _here.gives_way = True
    if sys.platform == 'linux':  # where a thread has a priority of its own
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)

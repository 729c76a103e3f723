"""A thread beside the work, which gives way to it."""

from concurrent.futures import ThreadPoolExecutor
import os
import sys
import threading

_NICE = 10
_here = threading.local()


def worker(name: str) -> ThreadPoolExecutor:
    """Return an executor of one thread, on Linux of a lower priority than the caller's."""
    return ThreadPoolExecutor(1, name, initializer=_give_way)


def gives_way() -> bool:
    """Tell whether this thread is one of a `worker`."""
    return getattr(_here, 'gives_way', False)


def _give_way() -> None:
    _here.gives_way = True
    if sys.platform == 'linux':  # where a thread has a priority of its own
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)

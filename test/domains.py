"""ROS domains that no other test on this machine uses at the same time."""

from collections.abc import Iterator
from contextlib import contextmanager
import os
import socket

_FIRST_PORT = 47000  # one port a domain, held while the domain is in use


@contextmanager
def free_domain() -> Iterator[int]:
    """Reserve a domain id between 1 and 100."""
    for offset in range(100):
        domain = (os.getpid() + offset) % 100 + 1
        with socket.socket() as lock:
            try:
                lock.bind(('127.0.0.1', _FIRST_PORT + domain))
            except OSError:
                continue
            yield domain
            return
    raise RuntimeError('all domains are in use')

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

"""ROS domains that no other test on this machine uses at the same time."""

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
import os
import socket

import pytest

_FIRST_PORT = 47000  # one port a domain, held while the domain is in use
_START = count(os.getpid() * 37)


@contextmanager
def free_domain() -> Iterator[int]:
    """
    Reserve a domain id between 1 and 100, each time another.

    A participant that ended is in the graph of the next one in its domain for up to 20 s, and a
    client there may wait that long for its services.
    """
    start = next(_START)
    for offset in range(100):
        domain = (start + offset) % 100 + 1
        with socket.socket() as lock:
            try:
                lock.bind(('127.0.0.1', _FIRST_PORT + domain))
            except OSError:
                continue
            yield domain
            return
    raise RuntimeError('all domains are in use')


@contextmanager
def own_environment() -> Iterator[None]:
    """Let the processes started from here on see each other and nobody else."""
    with free_domain() as domain, pytest.MonkeyPatch.context() as patch:
        for name, value in (('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST'),
                            ('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4'),
                            ('ROS_DOMAIN_ID', str(domain))):
            patch.setenv(name, value)
        yield

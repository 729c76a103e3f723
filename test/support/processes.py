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

"""The node as a process of its own, what the kernel says of it, and long forms of tests."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
import ctypes
from dataclasses import dataclass
import os
from pathlib import Path
import signal
import subprocess
import sys
from typing import Any

import pytest

_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_MEGABYTE = 1e6

linux = pytest.mark.skipif(not Path('/proc/self/statm').exists(), reason='needs /proc')


def short_and_long(name: str, short: Any, long: Any, *, minutes: float = 4.0) -> Any:
    """Parametrize a test with its length: the long one is run by `make soak` only."""
    return pytest.mark.parametrize(name, [short, pytest.param(
        long, marks=[pytest.mark.soak, pytest.mark.timeout(60.0 * minutes)])])


# What takes a process to each of the middleware's transports. A range of LOCALHOST always brings
# shared memory, whatever FASTDDS_BUILTIN_TRANSPORTS says.
TRANSPORTS = {
    'shared memory': {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'},
    'UDPv4': {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET', 'ROS_STATIC_PEERS': '127.0.0.1',
              'FASTDDS_BUILTIN_TRANSPORTS': 'UDPv4'}}


def environment(domain: int, transport: str = 'shared memory') -> dict[str, str]:
    """Return what a process needs to be in a domain."""
    return {**os.environ, **TRANSPORTS[transport], 'ROS_DOMAIN_ID': str(domain),
            'OPENBLAS_NUM_THREADS': '1'}


@contextmanager
def process(command: Sequence[str | Path], variables: dict[str, str] | None = None,
            **names: Any) -> Iterator[subprocess.Popen[Any]]:
    """Run Python for as long as the context lasts, whatever becomes of this process."""
    found = subprocess.Popen([sys.executable, *command], env=variables,
                             preexec_fn=_end_with_parent, **names)
    try:
        yield found
    finally:
        found.kill()
        found.wait()
        for stream in (found.stdin, found.stdout, found.stderr):
            if stream:
                stream.close()


def _end_with_parent() -> None:
    if sys.platform == 'linux':
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def monitor(domain: int, *, transport: str = 'shared memory', namespace: str = '',
            streams: dict[str, Any] | None = None, **parameters: Any) -> Any:
    """Run the node for a brake `fl`, or for those given as `brakes`, as a process."""
    from support.brake_monitors import EAGER

    chosen = {**EAGER, 'brakes': '[fl]', 'rate': 20.0, 'diagnostics_rate': 20.0, **parameters}
    command = ['-m', 'squeal_ros.node', '--ros-args', '--log-level', 'warn']
    for name, value in chosen.items():
        command += ['-p', f'{name.replace("__", ".")}:={value}']
    if namespace:
        command += ['-r', f'__ns:={namespace}']
    return process(command, environment(domain, transport), **(streams or {}))


@dataclass(frozen=True)
class Footprint:
    """What a process holds: resident memory [bytes], threads, open files."""

    memory: int
    threads: int
    files: int

    @classmethod
    def of(cls, pid: int) -> 'Footprint':
        folder = Path('/proc') / str(pid)
        pages = int((folder / 'statm').read_text().split()[1])
        return cls(pages * os.sysconf('SC_PAGE_SIZE'), len(list((folder / 'task').iterdir())),
                   len(list((folder / 'fd').iterdir())))

    def __str__(self) -> str:
        return (f'{self.memory / _MEGABYTE:.1f} MB, {self.threads} threads, {self.files} open '
                'files')


def cpu_seconds(pid: int) -> float:
    """Return what a process has computed so far [s]."""
    fields = (Path('/proc') / str(pid) / 'stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def stay() -> None:
    """Say that this process is here, and stay until it is ended."""
    print('here', flush=True)
    signal.pause()

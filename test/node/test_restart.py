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
Nodes as processes: killed and started again, several in a domain, one in each of two domains.

Times are printed; what depends on the machine's speed is not asserted.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import json
import math
import os
from pathlib import Path
import subprocess
import time
from typing import Any

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from support import processes  # noqa: E402
from support.domains import free_domain  # noqa: E402, I100
from support.node_runs import outside  # noqa: E402
from support.processes import linux, monitor, short_and_long  # noqa: E402
from support.vehicle import Vehicle  # noqa: E402

SHARED = Path('/dev/shm')
RATE = 20.0  # ticks a second
# as flooding.py names its topics, and the field of its wheel
SIGNALS = {'fl__rotor_speed__topic': 'fl/rotor_speed', 'fl__pressure__topic': 'fl/pressure',
           'fl__rotor_speed__field': 'velocity[name=wheel]'}


@contextmanager
def signals(domain: int, transport: str) -> Iterator[subprocess.Popen[Any]]:
    """Run a process that gives all inputs of `fl` until the context ends."""
    topics = [[f'fl/{kind}', kind, 50.0] for kind in ('rotor_speed', 'pressure', 'friction')]
    script = Path(__file__).parents[1] / 'support' / 'flooding.py'
    with processes.process([str(script), json.dumps(topics)],
                           processes.environment(domain, transport), stdin=subprocess.PIPE,
                           stdout=subprocess.DEVNULL) as started:
        yield started


def shared_memory(pid: int) -> set[Path]:
    """Files in shared memory that a process has mapped."""
    lines = Path(f'/proc/{pid}/maps').read_text().splitlines()
    return {Path(line.split()[-1]) for line in lines if f' {SHARED}/fastrtps' in line}


def answering(ear: Vehicle) -> None:
    ear.spin(0.1)  # what the last one said
    ear.said.clear()
    ear.until(lambda: any(s.hardware_id == 'fl' and s.level == b'\x01' for s in getattr(
        ear.said.get('diagnostics'), 'status', ())), 'an answer of the node')


@linux
@short_and_long('count', 2, 30, minutes=10.0)
@pytest.mark.parametrize('transport', [
    'shared memory', pytest.param('UDPv4', marks=pytest.mark.soak)])  # nearly all tests use UDPv4
def test_killed_and_started_again(count: int, transport: str,
                                  monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing that a killed node leaves in shared memory stops the next one."""
    times, published, held = [], [], set[Path]()
    for name, value in processes.TRANSPORTS[transport].items():
        monkeypatch.setenv(name, value)
    with free_domain() as domain, signals(domain, transport), \
            outside(domain, brake='ear') as ear:
        ear.silent = set(ear._publishers)
        for _ in range(count):
            start = time.monotonic()
            with monitor(domain, transport=transport, rate=RATE, **SIGNALS,
                         streams={'stderr': subprocess.PIPE, 'text': True}) as node:
                answering(ear)
                assert int(ear.figures['ticks_done']) < 2000
                times.append(time.monotonic() - start)
                published.append(times[-1] - int(ear.figures['ticks_done']) / RATE)
                held |= shared_memory(node.pid)
                node.kill()
                node.wait()
                said = node.stderr.read()
            assert 'rror' not in said, said
    left = [path for path in held - shared_memory(os.getpid()) if path.exists()]
    size = sum(path.stat().st_blocks * 512 for path in left)
    print(f'\n{transport}: publishes {np.median(published):.2f} s after its start, at most '
          f'{max(published):.2f} s; heard to answer after {np.median(times):.2f} s, at most '
          f'{max(times):.2f} s, {count} times; of {len(held)} files in shared memory {len(left)} '
          f'are left, {size / 1e6:.1f} MB')
    assert (transport == 'UDPv4') == (not held)
    assert len(left) < 20  # the next ones clear away what the killed ones left


def together(one: Vehicle, two: Vehicle, condition: Callable[[], bool], what: str) -> None:
    """Give the signals of two vehicles until a condition holds."""
    def both() -> bool:
        two.publish()
        two.spin(0.02)
        return condition()

    one.until(both, what)


def test_two_namespaces_in_one_domain() -> None:
    """Each node hears its own vehicle only, and goes on when the other is killed."""
    with free_domain() as domain, monitor(domain, namespace='/left') as left, \
            monitor(domain, namespace='/right') as right, \
            outside(domain, namespace='/left') as one, outside(domain, namespace='/right') as two:
        names = {'left': set[str](), 'right': set[str]()}

        def told() -> bool:
            for status in getattr(one.said.get('diagnostics'), 'status', ()):
                names[status.name.partition('/')[0]].add(status.name)
            return all(names.values())

        two.pressure = 0.0
        together(one, two, lambda: one.risk > 0.99 and two.risk == 0.0, 'only the left squeals')
        one.pressure, two.pressure = 0.0, 7.84e5
        together(one, two, lambda: one.risk == 0.0 and two.risk > 0.99, 'only the right squeals')
        together(one, two, told, 'both in /diagnostics')
        assert names == {side: {f'{side}/squeal_monitor: fl', f'{side}/squeal_monitor: node'}
                         for side in names}
        left.kill()
        left.wait()
        two.said.clear()
        two.until(lambda: two.risk > 0.99, 'the right one without the left')
        assert right.poll() is None


def test_two_vehicles_in_two_domains() -> None:
    """The same names everywhere, and nothing of one vehicle reaches the other."""
    with free_domain() as first, free_domain() as second, monitor(first), monitor(second), \
            outside(first) as one, outside(second) as two:
        two.silent = {'rotor_speed', 'pressure', 'friction'}
        together(one, two, lambda: one.risk > 0.99 and two.status is not None, 'both nodes speak')
        assert [s.hardware_id for s in two.said['diagnostics'].status] == ['fl', 'squeal_monitor']
        assert 'pressure never received' in two.status.message
        assert math.isnan(two.risk)
        two.silent, two.pressure = set(), 0.0
        one.said.clear()
        together(one, two, lambda: one.risk > 0.99 and two.risk == 0.0, 'only the first squeals')
        publishers = two.node.get_publishers_info_by_topic('/squeal_monitor/fl/squeal_risk')
        assert len(publishers) == 1

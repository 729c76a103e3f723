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
Floods of messages from another process: ticks go on, memory stays, what is dropped is counted.

Figures are printed; what depends on the machine's speed is not asserted.
"""

from collections.abc import Iterator
from contextlib import contextmanager
import json
from pathlib import Path
import subprocess
import time
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from support import processes  # noqa: E402
from support.domains import free_domain  # noqa: E402, I100
from support.flooding import MESSAGES  # noqa: E402
from support.node_runs import outside  # noqa: E402
from support.processes import cpu_seconds, Footprint, short_and_long  # noqa: E402
from support.vehicle import Vehicle  # noqa: E402

BRAKES = ('fl', 'fr', 'rl', 'rr')
RATE, TRICKLE = 100.0, 40.0  # Hz
WINDOW = 1000  # ticks that the node's percentiles are of
LEAST = 0.1  # of the ticks that a flood should have: it lasts until they are done
GROWTH = 1.05  # of resident memory: pools of Python and of the middleware round up
FLOODS = {'5 kHz on one input': {'fl/pressure': 5000.0},
          '500 Hz on all twelve': {f'{b}/{k}': 500.0 for b in BRAKES for k in MESSAGES}}
TOPICS = tuple(FLOODS['500 Hz on all twelve'])


def settings() -> dict[str, Any]:
    chosen: dict[str, Any] = {
        'rate': RATE, 'diagnostics_rate': 10.0, 'brakes': list(BRAKES)}
    for topic in TOPICS:
        name = topic.replace('/', '__')
        chosen[f'{name}__topic'] = topic
        chosen[f'{name}__max_age'] = 600.0  # a busy machine may pause
        if topic.endswith('rotor_speed'):
            chosen[f'{name}__field'] = 'velocity[name=wheel]'
    return chosen


class Flood:
    """The process that publishes."""

    def __init__(self, started: subprocess.Popen[Any]) -> None:
        self._process = started

    def tell(self) -> None:
        self._process.stdin.write('\n')  # type: ignore[union-attr]
        self._process.stdin.flush()  # type: ignore[union-attr]

    def hear(self) -> dict[str, int]:
        """Return what was sent so far, once there is another stage."""
        line = self._process.stdout.readline()  # type: ignore[union-attr]
        return json.loads(line)['sent']  # type: ignore[no-any-return]


@contextmanager
def flooding(domain: int) -> Iterator[Flood]:
    spec = [[topic, topic.rpartition('/')[2], TRICKLE,
             *(rates.get(topic, TRICKLE) for rates in FLOODS.values())] for topic in TOPICS]
    script = Path(__file__).parents[1] / 'support' / 'flooding.py'
    with processes.process([str(script), json.dumps(spec)],
                           processes.environment(domain), stdin=subprocess.PIPE,
                           stdout=subprocess.PIPE, text=True) as started:
        yield Flood(started)


def settled(ear: Vehicle) -> None:
    """Wait until every input comes as it should, and its publisher is known to be the only one."""
    ear.until(lambda: all(0.2 * TRICKLE < float(ear.figures.get(f'{topic} rate_hz', 'nan'))
                          < 2.0 * TRICKLE for topic in TOPICS), 'inputs at their rate')
    assert all(s.level < b'\x02' for s in ear.said['diagnostics'].status), ear.said


def known(ear: Vehicle) -> int:
    """Messages that the node took or knows it missed."""
    return sum(int(ear.figures[f'{topic} {what}'])
               for topic in TOPICS for what in ('received', 'dropped'))


def watch(ear: Vehicle, seconds: float) -> tuple[float, float]:
    """
    Hear diagnostics for so long and until enough ticks are done; return p99 and lateness [s].

    Both are the largest. A p99 is that of a window of ticks; of a short flood some were before it.
    """
    end, p99, latest = time.monotonic() + seconds, 0.0, 0.0
    begin = int(ear.figures['ticks_done'])
    own = begin + min(WINDOW, round(0.5 * seconds * RATE))
    enough = begin + LEAST * seconds * RATE
    while time.monotonic() < end or int(ear.figures['ticks_done']) <= enough:
        last = ear.said['diagnostics']
        ear.until(lambda last=last: ear.said['diagnostics'] is not last)  # type: ignore[misc]
        latest = max(latest, float(ear.figures['tick_lateness_max_s']))
        if int(ear.figures['ticks_done']) >= own:
            p99 = max(p99, float(ear.figures['tick_lateness_p99_s']))
    return p99, latest


def warmed_up(ear: Vehicle, process: int) -> None:
    """Wait until memory stands still before there is a flood."""
    before = 0
    for _ in range(20):
        memory = Footprint.of(process).memory
        if memory < 1.005 * before:
            return
        before, enough = memory, int(ear.figures['ticks_done']) + 300
        ear.until(lambda to=enough: int(ear.figures['ticks_done']) >= to)  # type: ignore[misc]


@processes.linux
@short_and_long('seconds', 1.5, 60.0)
def test_floods(seconds: float) -> None:
    with free_domain() as domain, processes.monitor(domain, **settings()) as node, \
            outside(domain, brake='ear') as ear, flooding(domain) as flood:
        ear.silent = set(ear._publishers)
        settled(ear)
        warmed_up(ear, node.pid)
        before: Any = None
        for name in FLOODS:
            flood.tell()
            sent, heard = sum(flood.hear().values()), known(ear)
            first, footprint, cpu = ear.figures, Footprint.of(node.pid), cpu_seconds(node.pid)
            before = before or footprint
            p99, latest = watch(ear, seconds)
            flood.tell()
            count = sum(flood.hear().values()) - sent
            load = (cpu_seconds(node.pid) - cpu) / seconds
            done, lost, dropped = (int(ear.figures[key]) - int(first[key]) for key in (
                'ticks_done', 'ticks_lost', 'dropped_messages'))
            # a few may have been under way when it began
            accounted = heard + count - len(TOPICS)
            ear.until(lambda to=accounted: known(ear) >= to,  # type: ignore[misc]
                      'all messages taken or known to be dropped')
            settled(ear)
            print(f'\n{name}: {count / seconds:.0f} messages/s, {dropped / count:.0%} dropped; '
                  f'{done} ticks, {lost} lost, lateness p99 {1e3 * p99:.1f} ms, max '
                  f'{1e3 * latest:.1f} ms; node at {load:.0%} of a core')
            assert done > LEAST * seconds * RATE
        after = Footprint.of(node.pid)
        print(f'{before} -> {after}')
        assert ear.figures['errors'] == ear.figures['unreadable_messages'] == '0'
        assert node.poll() is None
    assert after.memory < GROWTH * before.memory
    assert (after.threads, after.files) == (before.threads, before.files)

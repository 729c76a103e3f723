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

"""The demo on real processes and real DDS, for the first seconds of the cycle."""

from collections.abc import Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import time
from typing import Any

import pytest
from squeal_core.monitor.settings import load_settings

pytest.importorskip('rclpy', reason='needs rclpy')
pytest.importorskip('rosbags', reason='needs rosbags')
pytest.importorskip('matplotlib', reason='needs matplotlib')

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue  # noqa: E402, I100
import numpy as np  # noqa: E402
from squeal_core.monitor.results.history import AssessmentRecord  # noqa: E402
from squeal_core.vehicle.vehicle_model import BrakeSignals  # noqa: E402
from squeal_core.view.table import drive_console, DriveDisplay  # noqa: E402
from squeal_ros.cli.demo import (  # noqa: E402
    monitor_process,
    NAMESPACE,
    own_domain,
)
from squeal_ros.cli.player import BrakePlayer, NUMBERS  # noqa: E402
from support.processes import process  # noqa: E402, I100
from support.vehicle import TIMEOUT  # noqa: E402

COMMAND = ['-m', 'squeal_ros.cli', 'demo', '--speed-up', '4']
pytestmark = pytest.mark.usefixtures('own_domain')


def test_demo_end_to_end_and_replay_equals_live(tmp_path: Path) -> None:
    """
    Live and replayed numbers: equal bit for bit until they saw different samples.

    A sample is seen one tick later (1 s of the drive) where its message arrives after the tick
    it belongs to: here later than 12 ms. How many are depends on the machine.
    """
    compared, equal, same, output = demo_of_24_seconds(tmp_path)
    parted = re.search(r'until (\S+) s, .*?, (\d+) of (\d+)', output)
    if parted is None:
        assert equal == same
    else:
        assert parted[2] == parted[3]
    assert compared >= same > 0
    folder = tmp_path / 'demo_output'
    assert {p.name for p in folder.iterdir()} == {
        'inputs.mcap', 'live.csv', 'drive.png', 'outputs.mcap', 'outputs.csv',
        'outputs.events.csv', 'outputs.applications.csv', 'outputs.summary.json'}
    assert (folder / 'drive.png').read_bytes().startswith(b'\x89PNG')
    assert 'Squeal events' in output
    assert 'the demo has fewer (--rate)' in output
    assert 'of the braking time' in output.partition('Squeal events')[0]
    found = re.search(r'in ROS domain (\d+), namespace /squeal_demo', output)
    assert found is not None
    assert found[1] != os.environ['ROS_DOMAIN_ID']
    assert re.search(r'state +reason', output)


def demo_of_24_seconds(folder: Path) -> tuple[int, int, int, str]:
    """Return the assessments compared, those equal of those with the same samples, the output."""
    done = subprocess.run([sys.executable, *COMMAND, '--duration', '24'], cwd=folder,
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    output = ' '.join(done.stdout.split())
    found = re.search(r'(\d+) assessments, (\d+) of (\d+) with the same samples equal bit for bit',
                      output)
    assert found is not None, done.stdout
    compared, equal, same = map(int, found.groups())
    return compared, equal, same, output


def children(pid: int) -> list[int]:
    listing = subprocess.run(['ps', '-eo', 'pid,ppid'], capture_output=True, text=True, check=True)
    pairs = [line.split() for line in listing.stdout.splitlines()[1:]]
    return [int(child) for child, parent in pairs if int(parent) == pid]


def alive(pid: int) -> bool:
    status = Path(f'/proc/{pid}/stat')
    return status.exists() and status.read_text().rpartition(')')[2].split()[0] != 'Z'


@contextmanager
def demonstration(folder: Path) -> Iterator[Any]:
    """Run the demo in a process; yield it once its node has answered."""
    with process(COMMAND, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                 text=True) as demo:
        while 'ticks done' not in demo.stdout.readline():
            assert demo.poll() is None
        yield demo


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGKILL])
def test_interrupt_ends_all_processes(number: signal.Signals, tmp_path: Path) -> None:
    with demonstration(tmp_path) as demo:
        nodes = children(demo.pid)
        assert nodes
        demo.send_signal(number)
        rest = demo.stderr.read()
        assert demo.wait() != 0
    assert 'Traceback' not in rest
    end = time.monotonic() + TIMEOUT
    while any(map(alive, nodes)):
        assert time.monotonic() < end, 'a node outlived the demo'
        time.sleep(0.01)
    if number != signal.SIGKILL:
        assert not list((tmp_path / 'demo_output').iterdir())


def test_node_that_dies_ends_the_demo_with_the_reason(tmp_path: Path) -> None:
    with demonstration(tmp_path) as demo:
        os.kill(children(demo.pid)[0], signal.SIGKILL)
        assert 'the monitor ended' in demo.stderr.read()
        assert demo.wait() == 2


SIGNALS = BrakeSignals(
    brakes=('fl',), time=np.array([0.0, 0.1]), vehicle_speed=np.zeros(2),
    rotor_speed=np.zeros((2, 1)), pressure=np.zeros((2, 1)), friction=np.full((2, 1), 0.4),
    temperature=np.full((2, 1), 300.0))


def test_domains_of_demos_are_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not that of another demo, not the terminal's, none in which somebody is."""
    with own_domain() as first, own_domain() as second:
        assert first != second

    def taken_when_first_tried(domain: int) -> bool:
        monkeypatch.setattr('squeal_ros.cli.demo.os.getpid', lambda: domain - 1)
        with own_domain() as chosen:
            return chosen != domain

    assert not taken_when_first_tried(first)
    monkeypatch.setenv('ROS_DOMAIN_ID', str(first))
    assert taken_when_first_tried(first)
    monkeypatch.delenv('ROS_DOMAIN_ID')
    with BrakePlayer(SIGNALS, domain=first):
        assert taken_when_first_tried(first)


def diagnostics(node: str, brakes: dict[str, float]) -> DiagnosticArray:
    """Return what a monitor of this name says of its brakes, given their risks."""
    def status(name: str, values: dict[str, object]) -> DiagnosticStatus:
        return DiagnosticStatus(name=f'{node}: {name}', message='why', hardware_id=name, values=[
            KeyValue(key=key, value=str(value)) for key, value in values.items()])

    figures = dict.fromkeys(('rotor_speed_input', 'pressure_input', 'friction', *NUMBERS), 1.0)
    return DiagnosticArray(status=[
        *(status(name, {**figures, 'state': 'steady', 'squeal_risk': risk,
                        'unstable_frequencies_hz': '', 'unstable_growth_rates_1_s': ''})
          for name, risk in brakes.items()),
        status('node', {'ticks_done': len(brakes), 'ticks_lost': 0})])


def test_only_the_demos_own_monitor_is_heard() -> None:
    """Others in the same domain, of the same brakes or of others, are not."""
    with own_domain() as domain, BrakePlayer(SIGNALS, namespace=NAMESPACE,
                                             domain=domain) as player:
        for node in ('squeal_monitor', 'car/squeal_monitor', 'squeal_demo/squeal_monitor',
                     'other/squeal_demo/squeal_monitor'):
            own = node == 'squeal_demo/squeal_monitor'
            player._hear(diagnostics(node, {'fl': 0.3 if own else 0.9, 'other': 0.5}))
        (heard,) = player._heard
    assert [(row.brake, row.squeal_risk) for row in heard.rows] == [('fl', 0.3), ('other', 0.5)]


def test_topics_in_full_are_the_demos_too(tmp_path: Path) -> None:
    """Settings that name /joint_states: the node takes it in the demo's namespace."""
    config = tmp_path / 'config.yaml'
    config.write_text('/**: {ros__parameters: {brakes: [fl], fl: {'
                      'rotor_speed: {topic: /joint_states}, '
                      'pressure: {topic: /fl/brake_pressure}}}}')
    with (own_domain() as domain, monitor_process(config, load_settings(config), domain) as node,
          BrakePlayer(SIGNALS, namespace=NAMESPACE, domain=domain) as player):
        assert player.wait_for_listener(TIMEOUT, still_alive=lambda: node.poll() is None)


def test_the_table_gives_the_reason_of_what_is_not_known() -> None:
    """In full, with the brackets of a field path; a steady brake's columns say all of it."""
    row = AssessmentRecord(time_s=1.0, brake='front_left', state='stale', rotor_speed_rad_s=40.0,
                           pressure_pa=1e6, friction=0.4, squeal_risk=float('nan'),
                           instability_probability=0.4, build_up_nepers=2.0,
                           time_to_squeal_s=3.0, growth_rate_1_s=1.0, damping_ratio=-8e-5,
                           worst_frequency_hz=2000.0, friction_margin=0.1,
                           unstable_frequencies_hz=(), unstable_growth_rates_1_s=(),
                           reason='no velocity[name=fl] in the list')
    console = drive_console()
    with console.capture() as captured:
        DriveDisplay(console, 'us06').update(1.0, 2.0, [row, row._replace(
            state='steady', reason='squeal risk 0.10: mode; friction by temperature')], 1, 0)
    words = ' '.join(captured.get().split())
    assert 'no velocity[name=fl] in the list' in words
    assert 'squeal risk 0.10' not in words
    assert 'friction by temperature' in words
    assert max(map(len, captured.get().splitlines())) <= 99

"""The demo on real processes and real DDS, for the first seconds of the cycle."""

from collections.abc import Iterator
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import time

from domains import free_domain
import pytest

from squeal_core.settings import load_settings, MONITOR_KEYS

pytest.importorskip('rclpy', reason='needs rclpy')
pytest.importorskip('rosbags', reason='needs rosbags')
pytest.importorskip('matplotlib', reason='needs matplotlib')

from squeal_ros.demo import default_config, demo_settings  # noqa: E402

COMMAND = [sys.executable, '-m', 'squeal_ros.cli', 'demo', '--speed-up', '4']
ENVIRONMENT: dict[str, str] = {}


@pytest.fixture(scope='module', autouse=True)
def environment() -> Iterator[dict[str, str]]:
    """Run every process of this module in a domain of its own."""
    with free_domain() as domain:
        ENVIRONMENT.update(os.environ, ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST',
                           FASTDDS_BUILTIN_TRANSPORTS='UDPv4', ROS_DOMAIN_ID=str(domain))
        yield ENVIRONMENT


def test_demo_end_to_end_and_replay_equals_live(tmp_path: Path) -> None:
    """Live and replayed numbers: equal bit for bit until they saw different samples.

    A sample is seen one tick later (1 s of the drive) where its message arrives after the tick
    it belongs to: here later than 12 ms, so seldom unless the machine is busy.
    """
    compared, equal, same, output = demo_of_40_seconds(tmp_path)
    parted = re.search(r'until (\S+) s, .*?, (\d+) of (\d+)', output)
    if parted is None:
        assert equal == same
    else:
        assert parted[2] == parted[3]
    assert same > 0.5 * compared
    assert compared > 4 * 35  # 40 s, a tick a second, four brakes, less start and end
    folder = tmp_path / 'demo_output'
    assert {p.name for p in folder.iterdir()} == {
        'inputs.mcap', 'live.csv', 'outputs.mcap', 'outputs.csv', 'drive.png'}
    assert (folder / 'drive.png').read_bytes().startswith(b'\x89PNG')
    assert 'Squeal events' in output
    assert 'of the braking time' in output.partition('Squeal events')[0]


def demo_of_40_seconds(folder: Path) -> tuple[int, int, int, str]:
    """Return the assessments compared, those equal of those with the same samples, the output."""
    done = subprocess.run([*COMMAND, '--duration', '40'], cwd=folder, env=ENVIRONMENT,
                          capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    output = ' '.join(done.stdout.split())
    found = re.search(r'(\d+) assessments, (\d+) of (\d+) with the same samples equal bit for bit',
                      output)
    assert found is not None, done.stdout
    compared, equal, same = map(int, found.groups())
    return compared, equal, same, output


def children(process: int) -> list[int]:
    listing = subprocess.run(['ps', '-eo', 'pid,ppid'], capture_output=True, text=True, check=True)
    pairs = [line.split() for line in listing.stdout.splitlines()[1:]]
    return [int(pid) for pid, parent in pairs if int(parent) == process]


def alive(process: int) -> bool:
    status = Path(f'/proc/{process}/stat')
    return status.exists() and status.read_text().rpartition(')')[2].split()[0] != 'Z'


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_interrupt_ends_all_processes(number: signal.Signals, tmp_path: Path) -> None:
    with subprocess.Popen(COMMAND, cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True,
                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)) as demo:
        assert demo.stdout is not None
        assert demo.stderr is not None
        while 'ticks done' not in demo.stdout.readline():
            assert demo.poll() is None
        nodes = children(demo.pid)
        assert nodes
        demo.send_signal(number)
        rest = demo.stderr.read()
        assert demo.wait(15) != 0
    assert 'Traceback' not in rest
    end = time.monotonic() + 10.0
    while any(map(alive, nodes)):
        assert time.monotonic() < end, 'a node outlived the demo'
    if number != signal.SIGKILL:
        assert not list((tmp_path / 'demo_output').iterdir())


def test_node_that_dies_ends_the_demo_with_the_reason(tmp_path: Path) -> None:
    with subprocess.Popen(COMMAND, cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as demo:
        assert demo.stdout is not None
        assert demo.stderr is not None
        while 'ticks done' not in demo.stdout.readline():
            assert demo.poll() is None
        os.kill(children(demo.pid)[0], signal.SIGKILL)
        assert 'the monitor ended' in demo.stderr.read()
        assert demo.wait(15) == 2


@pytest.mark.parametrize('speed_up', [0.01, 1.0, 10.0, 50.0, 1000.0])
def test_the_demos_settings_are_ones_that_the_node_takes(speed_up: float) -> None:
    """However fast time runs: work and delays are of real time, within their keys' ranges."""
    chosen = demo_settings(default_config(), 10.0, speed_up)
    for key in MONITOR_KEYS:
        if isinstance(key.default, float):
            assert key.minimum <= getattr(chosen, key.name) <= key.maximum, key.name
    if speed_up == 10.0:
        assert chosen.risk_delay == 10.0 * load_settings(default_config()).risk_delay

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

"""The node and the commands as processes: signals, exit codes, one-line errors, threads."""

from collections.abc import Iterator
import json
import math
from pathlib import Path
import signal
import subprocess
import sys
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from diagnostic_msgs.msg import DiagnosticStatus  # noqa: E402, I100
from squeal_ros.cli.main import main  # noqa: E402
from squeal_ros.node.arguments import check_arguments  # noqa: E402
from squeal_ros.node.lifecycle_node import main as node_main  # noqa: E402
from support.domains import free_domain  # noqa: E402, I100
from support.node_runs import outside  # noqa: E402
from support.processes import monitor, process  # noqa: E402

NODE = ['-m', 'squeal_ros.node', '--ros-args']
SQUEAL = ['-m', 'squeal_ros.cli']
pytestmark = pytest.mark.usefixtures('own_domain')


@pytest.fixture
def handlers() -> Iterator[None]:
    """Set back what SIGINT and SIGTERM do, which both programs set."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def squeal(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Run a command in this process: its code, output and errors."""
    code = main(arguments)
    return code, *capsys.readouterr()


def run(command: list[str], cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *command], capture_output=True, text=True,
                          cwd=cwd, check=False)


def test_a_signal_ends_the_node_cleanly() -> None:
    with process(NODE, stderr=subprocess.PIPE, text=True) as node:
        assert 'watching' in node.stderr.readline()
        node.send_signal(signal.SIGTERM)
        rest = node.stderr.read()
        assert node.wait() == 0
    assert 'Traceback' not in rest


@pytest.mark.parametrize(('number', 'simulated'), [
    (signal.SIGTERM, False), (signal.SIGINT, True)])
def test_the_last_word_after_a_signal_is_that_nothing_is_known(number: int, simulated: bool
                                                               ) -> None:
    """What another process has heard by the time the node has ended, while an alarm is up."""
    streams = {'stderr': subprocess.PIPE, 'text': True}
    with free_domain() as domain, monitor(domain, streams=streams, use_sim_time=simulated) as node:
        with outside(domain, simulated=simulated) as car:
            car.until(lambda: car.risk > 0.99 and car.events, 'alarm')
            node.send_signal(number)
            assert node.wait() == 0
            car.hear()
            assert math.isnan(car.risk)
            assert math.isnan(car.unstable[0])
            events = [value.value for message in car.events for status in message.status
                      for value in status.values if value.key == 'event']
            assert events == ['start', 'end']
            assert car.status.level == DiagnosticStatus.STALE
            assert 'not active' in car.status.message
        log = node.stderr.read()
    assert 'Traceback' not in log
    assert 'Error' not in log


def test_a_subscriber_that_stands_still_does_not_keep_the_node() -> None:
    listening = ('import rclpy, sys; from std_msgs.msg import Float64; rclpy.init();'
                 'node = rclpy.create_node("listener"); node.create_subscription('
                 'Float64, "/squeal_monitor/front_left/squeal_risk", print, 1);'
                 'rclpy.spin_once(node); print("heard", flush=True); rclpy.spin(node)')
    with process(NODE, stderr=subprocess.PIPE, text=True) as node, process(
            ['-c', listening], stdout=subprocess.PIPE, text=True) as listener:
        while 'heard' not in listener.stdout.readline():
            pass
        listener.send_signal(signal.SIGSTOP)
        node.send_signal(signal.SIGTERM)
        assert node.wait() == 0


@pytest.mark.parametrize(('arguments', 'words'), [
    (['-p', 'model:=nobody'], 'nobody'), (['-p', 'brakes:=[a b]'], 'a b')])
def test_bad_settings_end_in_one_line(arguments: list[str], words: str) -> None:
    done = run([*NODE, *arguments])
    assert done.returncode == 2
    own = [line for line in done.stderr.splitlines() if not line.startswith('[')]  # rcl's log
    assert len(own) == 1
    assert own[0].startswith('squeal_monitor: ')
    assert words in own[0]


def test_blas_runs_on_one_thread() -> None:
    pytest.importorskip('threadpoolctl', reason='needs threadpoolctl')
    done = run(['-c', (
        'import squeal_ros.node.lifecycle_node, scipy.linalg, threadpoolctl, json;'
        'print(json.dumps([p["num_threads"] for p in threadpoolctl.threadpool_info()]))')])
    threads = json.loads(done.stdout)
    assert threads
    assert set(threads) == {1}


def modes(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    code, out, err = squeal(capsys, 'modes', 'kang2009', *arguments, '--json')
    assert code == 0, err
    return json.loads(out)


def test_modes_json_is_whole(capsys: pytest.CaptureFixture[str], handlers: None) -> None:
    answer = modes(capsys, '--rotor-speed', '20', '--friction', '0.42', '--preload', '2000')
    assert [m['index'] for m in answer['modes']] == list(range(1, 93))
    assert set(answer['modes'][0]) == {
        'index', 'identity', 'kind', 'frequency_hz', 'growth_rate', 'damping_ratio',
        'backward_error', 'condition', 'error_bound', 'mechanism', 'participation',
        'coupled_with', 'contributions', 'without', 'sensitivity'}
    assert [m['kind'] for m in answer['modes'][:6]] == ['rigid'] * 6
    assert all(m['growth_rate'] * m['damping_ratio'] <= 0.0 for m in answer['modes'])
    by_pressure = modes(capsys, '--rotor-speed', '20', '--friction', '0', '--pressure', '783773.1')
    assert by_pressure['point']['contact_pressure'] == pytest.approx(
        answer['point']['contact_pressure'], rel=1e-5)  # 2000 N on a 57 mm piston


def test_modes_take_slope_from_option_or_law(capsys: pytest.CaptureFixture[str],
                                             handlers: None) -> None:
    law = modes(capsys, '--rotor-speed', '5', '--friction-law')
    assert law['point']['friction_slope'] < -0.05
    assert any(m['kind'] == 'divergence' for m in law['modes'])
    own = modes(capsys, '--rotor-speed', '5', '--friction', '0.1', '--friction-slope', '-0.1')
    assert own['point']['friction_slope'] == -0.1


BAD_INPUT = [
    (['modes', 'nobody', '--rotor-speed', '5'], 'nobody'),
    (['modes', 'kang2009', '--rotor-speed', '0'], '--rotor-speed'),
    (['modes', 'kang2009', '--rotor-speed', 'nan'], '--rotor-speed'),
    (['modes', 'kang2009', '--rotor-speed', '5', '--preload', '-1'], '--preload'),
    (['build', 'nobody.yaml', '-o', 'x.npz'], 'nobody.yaml'),
    (['info', 'README.md'], 'README.md'),
    (['replay', 'nobody.mcap', '-o', 'x.mcap'], 'nobody.mcap'),
    (['settings', '1st'], '1st'),
    (['demo', 'nobody'], 'nobody'), (['demo', '--rate', '0'], '--rate')]


@pytest.mark.parametrize(('arguments', 'words'), BAD_INPUT)
def test_bad_input_is_two_and_one_line(
        arguments: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str], handlers: None) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = squeal(capsys, *arguments)
    assert (code, out, len(err.splitlines())) == (2, '', 1)
    assert words in err
    assert not list(tmp_path.glob('x.*'))


def test_bad_input_is_exit_two(tmp_path: Path) -> None:
    done = run([*SQUEAL, *BAD_INPUT[0][0]], cwd=tmp_path)
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (2, '', 1)
    assert BAD_INPUT[0][1] in done.stderr


def test_info_shows_the_model(capsys: pytest.CaptureFixture[str], handlers: None) -> None:
    _, out, _ = squeal(capsys, 'info', 'kang2009', '--json')
    header = json.loads(out)
    assert header['schema'] == 1
    assert len(header['frequencies_hz']) == 92
    assert header['provenance']['description']['name'] == 'kang2009'
    assert 'disc (3,0)c' in squeal(capsys, 'info', 'kang2009')[1]


NODE_MODULE, SQUEAL_MODULE = ['-m', 'squeal_ros.node'], ['-m', 'squeal_ros.cli', 'map', 'kang2009']


def interrupted(command: list[str], moment: str, count: int) -> tuple[int, list[str]]:
    """Send SIGINT at the import of a module, or at a word of the log; exit code and last words."""
    with process(['-X', 'importtime', *command], stderr=subprocess.PIPE,
                 stdout=subprocess.DEVNULL, text=True) as started:
        said = []
        for line in started.stderr:
            said.append(line)
            if moment in line:
                break
        for _ in range(count):
            started.send_signal(signal.SIGINT)
        said += started.stderr.readlines()
        code = started.wait()
    return code, [line for line in said if not line.startswith('import time')]


@pytest.mark.parametrize(('moment', 'count'), [
    ('numpy.linalg', 1), ('rclpy.context', 2), ('watching', 2)])
def test_an_interrupt_at_any_moment_ends_the_node_with_zero(moment: str, count: int) -> None:
    code, words = interrupted(NODE_MODULE, moment, count)
    assert code == 0
    assert not [line for line in words if 'Traceback' in line or 'Error' in line]


def test_an_interrupt_while_a_command_starts() -> None:
    code, words = interrupted(SQUEAL_MODULE, 'numpy.linalg', 2)
    assert code == 130
    assert set(words) == {'squeal: interrupted\n'}


@pytest.mark.parametrize(('arguments', 'words'), [
    (['--params-file', 'x.yaml'], 'write --ros-args before'),
    (['x.yaml'], '--ros-args --params-file x.yaml'), (['--versio'], 'did you mean --version?'),
    (['--ros-args', '--parms-file', 'x'], 'did you mean --params-file?'),
    (['--ros-args', '--params-file', 'none.yaml'], 'none.yaml: cannot be read'),
    (['--ros-args', '-p', 'brakes:='], "is followed by 'brakes:='"),
    (['--ros-args', '-p', 'brakes:=[]'], 'brakes: is an empty list'),
    (['--ros-args', '-p', 'brakes:=[fl]', '-p', 'fl.pressure.topic:=[]'],
     'fl.pressure.topic: is an empty list'),
    (['--ros-args', '-p', 'front_left.presure.topic:=x'],
     'did you mean front_left.pressure.topic?')])
def test_arguments_that_the_node_refuses(arguments: list[str], words: str, handlers: None,
                                         capsys: pytest.CaptureFixture[str]) -> None:
    try:
        code = node_main(arguments)
    except SystemExit as end:  # argparse
        code = int(end.code or 0)
    out, err = capsys.readouterr()
    assert (code, out, len(err.splitlines())) == (2, '', 1)
    assert words in err


def test_the_node_refuses_arguments_with_exit_two() -> None:
    done = run([*NODE_MODULE, 'x.yaml'])
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (2, '', 1)
    assert '--ros-args --params-file x.yaml' in done.stderr


def test_help_and_version_of_both_programs(capsys: pytest.CaptureFixture[str]) -> None:
    from squeal_core import __version__
    for command, called in ((NODE_MODULE, check_arguments), (SQUEAL, main)):
        shown = run([*command, '--version'])
        assert (shown.returncode, shown.stdout) == (0, f'squeal_ros {__version__}\n')
        with pytest.raises(SystemExit) as ended:
            called(['--help'])
        assert ended.value.code == 0
        assert capsys.readouterr().out.startswith('usage: squeal')


def test_standard_output_that_is_full() -> None:
    with Path('/dev/full').open('w') as full:
        done = subprocess.run([sys.executable, *SQUEAL, 'info', 'kang2009'], text=True,
                              stdout=full, stderr=subprocess.PIPE, check=False)
    assert done.returncode == 2
    assert done.stderr == ('squeal: standard output: No space left on device; check path, rights '
                           'and space\n')

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

"""`squeal replay` over bags that do not fit its settings: what it says first, exit codes."""

import json
from pathlib import Path
import re
from typing import Any

import numpy as np
import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_ros.cli.main import main  # noqa: E402
from squeal_ros.node.messages import DIAGNOSTICS_TYPE, WARN  # noqa: E402
from squeal_ros.recordings.bags.bag_reader import Bag  # noqa: E402
from support.bags import (  # noqa: E402, I100
    braking,
    Entry,
    FLOAT,
    FRAME,
    header,
    make,
    PRESSURE,
    report_inputs,
    reports,
    SECOND,
    settings_file,
    times,
    write_bag,
)


class Run:
    """Runs `squeal replay` over messages, in a folder of its own."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder, self._capsys = folder, capsys

    def __call__(self, entries: list[Entry], *options: str, brake: str = 'fl',
                 **inputs: Any) -> tuple[int, str, str]:
        """Return exit code, stdout and stderr."""
        bag, config = self.folder / 'bag', self.folder / 'config.yaml'
        if not bag.exists():
            write_bag(bag, entries)
        settings_file(config, brake, **inputs)
        code = main(['replay', str(bag), '--config', str(config), '-o',
                     str(self.folder / 'out.mcap'), '--force', *options])
        said = self._capsys.readouterr()
        return code, said.out, said.err


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    return Run(tmp_path, capsys)


def test_a_good_bag(run: Run) -> None:
    code, out, err = run(braking())
    assert (code, err) == (0, '')
    first, second, brake, basis, events, *_ = out.splitlines()
    assert first == ('squeal risk known for 100 % of the braking time (2.1 of 2.1 s), 100 % in '
                     'brake applications seen in part only')  # it has no release
    assert second == 'assessed 100 % of the braking time (2.1 of 2.1 s)'
    assert re.fullmatch(r'fl +100 % of 2\.1 s; squeal risk 0\.[0-9]{2} on average, up to '
                        r'0\.[0-9]{2}; ticks: 21 steady', brake)
    assert basis == ('squeal risk: not calibrated: the level of the risk is mostly the prior of '
                     'damping')
    assert events == '21 ticks, 1 squeal event'
    code, out, _ = run([], '--json')
    found = json.loads(out)
    assert code == 0
    assert list(found)[:2] == ['risk_known_share', 'risk_known_s']
    assert (found['risk_known_share'], found['never_known']) == (1.0, [])
    assert (found['assessed_share'], found['never_assessed']) == (1.0, [])
    assert found['ticks_by_state'] == found['brakes']['fl']['ticks_by_state'] == {'steady': 21}
    assert (found['top_reason'], found['findings'], found['notes']) == (None, [], [])
    (event,) = found['events']
    assert event['brake'] == 'fl'
    assert found['output'].endswith('out.mcap')


# what is wrong with the bag or the settings; what is then said, and what helps
CASES: dict[str, tuple[list[Entry], dict[str, Any], str, str]] = {
    'clock': (braking(behind=50 * 365 * 86400 * SECOND), {}, 'are 50.0 years or more behind',
              'stamp: receipt'),
    'clock ahead': (braking(behind=-3 * SECOND), {}, 'are 3 s or more ahead of', 'stamp: receipt'),
    'joint': (braking(joint='wheel_fl'), {}, "no 'fl_wheel_joint' in the list 'name'",
              'steering, wheel_fl'),
    'topic': (braking(), {'pressure': {'topic': '/fl/brake_presure'}},
              '/fl/brake_presure is not in the bag', '/fl/brake_pressure'),
    'namespace': (braking(topics='/car/fl'), {}, '/fl/brake_pressure is not in the bag',
                  '--namespace /car'),
    'field': (reports(), {**report_inputs(), 'pressure': {
        **report_inputs()['pressure'], 'field': 'presures[0]'}},
        "no field 'presures'", "'pressures'? its fields are: header, speed, pressures"),
    'index': (reports(), {**report_inputs(), 'pressure': {
        **report_inputs()['pressure'], 'field': 'pressures[2]'}}, 'too short', 'has 2 entries'),
    'type': (braking(), {'pressure': {'type': FLOAT, 'field': 'data'}},
             f'of type {PRESSURE} in the bag', f'type: {PRESSURE}'),
    'bar': (braking(pressure=8.0), {}, 'looks like bar', 'scale: 1.0e+5'),
}


@pytest.mark.parametrize('case', CASES)
def test_nothing_assessed_is_said_first_with_the_remedy(case: str, run: Run) -> None:
    entries, inputs, what, remedy = CASES[case]
    code, out, _ = run(entries, **inputs)
    assert code == 1
    lines = out.splitlines()
    assert lines[0].startswith('squeal risk known for 0 % of the braking time (0.0 of ')
    assert lines[1].startswith('assessed 0 % of the braking time (0.0 of ')
    assert lines[1].endswith('; never assessed: fl')
    assert what in out
    (said,) = [line for line in lines if line.startswith('  remedy: ')]
    assert remedy in said
    assert 'squeal events: not known' in out
    code, out, _ = run([], '--json', **inputs)
    found = json.loads(out)
    assert code == 1
    assert (found['assessed_share'], found['never_assessed']) == (0.0, ['fl'])
    assert remedy in found['top_reason']['remedy']


@pytest.mark.parametrize('off', ['growth_emulator: none',
                                 'squeal_band_low_hz: 2.0e+4, squeal_band_high_hz: 2.5e+4'])
def test_a_risk_that_was_never_known_is_said_first(off: str, run: Run, tmp_path: Path) -> None:
    """The setting has no emulator, or a squeal band without a family."""
    own = tmp_path / 'own.yaml'
    own.write_text(f'/**: {{ros__parameters: {{brakes: [fl], {off}}}}}')
    code, out, _ = run(braking(), '--config', str(own))
    first, _, finding, _, events, _ = out.splitlines()
    assert code == 1
    assert first == 'squeal risk known for 0 % of the braking time (0.0 of 2.1 s); never known: fl'
    assert finding.startswith(
        'finding: fl: squeal risk not known for 2.1 s of sliding under load: no ')
    assert off.partition(':')[0] in finding
    assert events == '21 ticks, squeal events: not known (squeal risk known at none)'
    code, out, _ = run([], '--config', str(own), '--json')
    found = json.loads(out)
    assert (code, found['risk_known_share'], found['events']) == (1, 0.0, None)
    assert (found['never_known'], found['findings'][0]['inputs']) == (['fl'], ['fl'])
    written = Bag(tmp_path / 'out.mcap').messages({'/diagnostics': DIAGNOSTICS_TYPE})
    assert {(status.name, status.level) for _, _, message, _ in written
            for status in message.status} == {('squeal_monitor: fl', WARN),
                                              ('squeal_monitor: node', WARN)}


def test_a_risk_that_was_partly_unknown(run: Run) -> None:
    """90 bar is beyond the emulator of the model; and two ticks a second miss short squeals."""
    entries = braking(4.0)
    for entry in entries:
        if entry.type == PRESSURE and entry.time > entries[0].time + 2 * SECOND:
            entry.message.fluid_pressure *= 90.0 / 8.0
    code, out, _ = run(entries, '--rate', '2')
    assert code == 0
    lines = out.splitlines()
    assert lines[0].startswith('squeal risk known for 55.5 % of the braking time (2.5 of 4.5 s)')
    assert 'outside the range of the growth emulator; `squeal info MODEL` shows' in lines[2]
    assert re.search(r'9 ticks, [0-9] squeal events? while the squeal risk was known', out)
    assert 'note: the squeal risk is evaluated 2 times a second, so short' in out
    found = json.loads(run([], '--json', '--rate', '2')[1])
    assert found['risk_known_share'] == pytest.approx(5 / 9)


def test_the_remedy_of_another_clock_helps(run: Run) -> None:
    code, out, _ = run(CASES['clock'][0], rotor_speed={'stamp': 'receipt'},
                       pressure={'stamp': 'receipt'})
    assert (code, '\nassessed 100 % of the' in out) == (0, True)


def test_a_clock_that_was_set_on_the_way_is_said(run: Run) -> None:
    entries = braking()
    for entry in entries[len(entries) // 2:]:
        if hasattr(entry.message, 'header'):
            entry.message.header.stamp.sec -= 3600
    code, out, _ = run(entries)
    assert code == 0
    assert 'so one of the two clocks was set' in out, out


def test_a_misspelt_brake_beside_good_ones(run: Run, tmp_path: Path) -> None:
    """One brake that was never assessed is exit code 1, whatever the others are."""
    (tmp_path / 'two.yaml').write_text('/**: {ros__parameters: {brakes: [fl, fll]}}')
    code, out, _ = run(braking(), '--config', str(tmp_path / 'two.yaml'))
    assert code == 1
    assert ('assessed 50 % of the braking time (2.1 of 4.2 s of all brakes); never assessed: '
            'fll\n') in out
    for words in ("do you mean 'fl_wheel_joint'?", 'nearest in the bag: /fl/brake_pressure',
                  'nearest in the bag: /fl/friction'):
        assert words in out


def test_nothing_of_the_settings_in_the_bag_is_bad_input(run: Run) -> None:
    code, out, err = run(reports(), brake='rr', **{
        name: {'topic': f'/nobody/{name}'} for name in ('rotor_speed', 'pressure', 'friction')})
    assert (code, out) == (2, '')
    assert err.count('\n') == 1
    assert 'has none of the topics /nobody/friction' in err
    assert '/fl/friction' in err


def test_topics_without_a_message_are_bad_input(run: Run) -> None:
    entries = [e._replace(message=make(FLOAT, data=0.4), topic='/other', type=FLOAT)
               for e in braking(0.1)]
    code, out, err = run(entries, friction={'topic': '/other', 'type': 'std_msgs/msg/Float32'})
    assert (code, out) == (2, '')
    assert 'has no message to read on the topics' in err


def test_a_drive_without_braking_is_good_and_says_so(run: Run) -> None:
    code, out, _ = run(braking(pressure=0.0))
    assert code == 0
    assert out.startswith('no braking in 21 ticks, so nothing to assess\n')


def frames(ids: list[int]) -> list[Entry]:
    """Return raw frames with ids in turn, of which one carries speed and one pressure."""
    return [Entry('/can', FRAME, time, make(
        FRAME, header=header(time), id=ids[n % len(ids)], dlc=8,
        data=np.full(8, 20 + n % 3, np.uint8)))
        for n, time in enumerate(times(2.0, 0.02))] + [e for e in braking() if e.type == FLOAT]


RAW = {'rotor_speed': {'topic': '/can', 'type': FRAME, 'field': 'data[0]'},
       'pressure': {'topic': '/can', 'type': FRAME, 'field': 'data[1]', 'scale': 4e4}}


def test_raw_frames_of_several_ids_are_never_mixed(run: Run) -> None:
    code, out, err = run(frames([0x1A0, 0x2B0]), **RAW)
    assert (code, out) == (2, '')
    assert '/can: carries raw frames of several ids (0x1A0, 0x2B0)' in err
    assert 'fl.rotor_speed, fl.pressure' in err
    assert 'decode' in err
    assert not (run.folder / 'out.mcap').exists()


def test_frames_of_one_sensor_after_the_other_are_told(run: Run) -> None:
    """Four gauges on one topic, which only their frames tell apart."""
    entries = braking()
    for number, entry in enumerate(e for e in entries if e.type == PRESSURE):
        entry.message.header.frame_id = ('fl', 'fr')[number % 2]
    _, out, _ = run(entries)
    assert ('finding: fl.pressure: messages on /fl/brake_pressure are of several ids (fl, fr)'
            in out)


def test_outputs_are_refused_before_any_work(run: Run, tmp_path: Path) -> None:
    """The table beside the bag too; and neither is there without the other."""
    (tmp_path / 'out.csv').write_text('mine')
    write_bag(tmp_path / 'bag', braking(0.5))
    arguments = ['replay', str(tmp_path / 'bag'), '-o', str(tmp_path / 'out.mcap'), '--config',
                 str(settings_file(tmp_path / 'config.yaml'))]
    assert main(arguments) == 2
    assert (tmp_path / 'out.csv').read_text() == 'mine'
    assert not (tmp_path / 'out.mcap').exists()
    for name in ('bag', 'bag/bag.mcap', 'config.yaml'):  # what is read is never replaced
        assert main(['replay', str(tmp_path / 'bag'), '-o', str(tmp_path / name), '--force',
                     '--config', arguments[-1]]) == 2
    assert main([*arguments, '--force']) == 0
    assert (tmp_path / 'out.csv').read_text().startswith('time_s,')
    assert {path.name for path in tmp_path.iterdir()} == {
        'bag', 'config.yaml', 'out.csv', 'out.mcap', 'out.events.csv', 'out.applications.csv',
        'out.summary.json'}

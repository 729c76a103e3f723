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

"""Squeal risk of a running node from the shipped emulator, and its alarms: topic and log."""

import math
from pathlib import Path
import runpy
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100
from squeal_ros.node.messages import OK, WARN  # noqa: E402
from support.node_outputs import EVENTS  # noqa: E402, I100
from support.node_runs import vehicle  # noqa: E402
from support.vehicle import Vehicle  # noqa: E402

TOPIC = '/squeal_monitor/events'
EXAMPLES = Path(__file__).parents[2] / 'examples'
# the prior as it is shipped; node tests have one brake without uncertainty else
PRIOR = {'ensemble_size': 64.0, 'audible_build_up': 5.5, 'audible_build_up_deviation': 2.0,
         'damping_deviation': 0.3, 'contact_stiffness_deviation': 0.1,
         'friction_bias_deviation': 0.03, 'friction_slope_deviation': 0.3,
         'friction_scatter': 0.02, 'damping_scatter': 0.15}


def values(status: Any) -> dict[str, str]:
    return {item.key: item.value for item in status.values}


def said(message: Any) -> tuple[int, dict[str, str]]:
    """Return level and values of an event's only status."""
    [status] = message.status
    assert (status.name, status.hardware_id) == ('squeal_monitor: fl', 'fl')
    return status.level[0], values(status)


def braking(car: Vehicle) -> None:
    car.pressure = 0.0
    car.until(lambda: car.risk == 0.0, 'the release')
    car.pressure = 7.84e5
    car.until(lambda: car.risk > 0.99 and car.events, 'an alarm')


def test_an_alarm_is_an_event_a_level_and_a_line_of_the_log(
        capfd: pytest.CaptureFixture[str]) -> None:
    with vehicle() as car:
        braking(car)
        car.pressure = 0.0
        car.until(lambda: len(car.events) > 1, 'its end')
        (first, begun), (last, over) = map(said, car.events)
        assert (first, last) == (WARN, OK)
        assert (begun['event'], over['event']) == ('start', 'end')
        assert begun['brake'] == over['brake'] == 'fl'
        assert float(begun['squeal_risk']) == float(over['peak_risk']) == 1.0
        assert begun['cause'].startswith('build-up ')
        assert over['cause'].endswith('brake released')
        assert 0.5 <= float(over['duration_s']) < 3.0
        assert begun['modes'] == over['modes'] != ''
        assert 1250.0 < float(begun['frequency_hz']) < 16000.0
        stamps = [message.header.stamp for message in car.events]
        assert stamps[0].sec + 1e-9 * stamps[0].nanosec == pytest.approx(
            stamps[1].sec + 1e-9 * stamps[1].nanosec - float(over['duration_s']))
        late: list[Any] = []
        car.node.create_subscription(DiagnosticArray, TOPIC, late.append, EVENTS)
        car.wait(lambda: len(late) == 2, 'what a late subscriber gets')
        assert [message.status[0].message for message in late] == [
            message.status[0].message for message in car.events]
    log = [line for line in capfd.readouterr().err.splitlines() if 'fl: squeal' in line]
    assert [('WARN' in line, 'INFO' in line) for line in log] == [(True, False), (False, True)]


def test_the_example_hears_of_alarms_that_began_before_it(
        capsys: pytest.CaptureFixture[str]) -> None:
    example = runpy.run_path(str(EXAMPLES / 'act_on_alarms.py'))
    with vehicle() as car:
        braking(car)
        listener = example['AlarmListener'](context=car.context)
        car.executor.add_node(listener)
        car.until(lambda: listener.squealing, 'the alarm, late')
        assert list(listener.squealing) == ['fl']
        assert 1250.0 < listener.squealing['fl'] < 16000.0
        car.until(lambda: 'squeal_monitor: fl' not in listener.unknown, 'a known brake')
        car.pressure = 0.0
        car.until(lambda: not listener.squealing, 'its end')
        car.pressure = math.nan
        car.until(lambda: 'squeal_monitor: fl' in listener.unknown, 'a brake not known')
        listener.destroy_node()
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2
    assert lines[0].startswith('fl: squeal probable, risk ')
    assert lines[1].startswith('fl: squeal alarm over after ')


def test_a_node_that_stops_ends_its_alarms() -> None:
    with vehicle() as car:
        braking(car)
        car.monitor.trigger_deactivate()
        car.hear()
        level, over = said(car.events[-1])
        assert (level, over['event'], over['cause']) == (
            OK, 'end', 'whether it squeals is no longer known: the monitor is not active')


def test_the_risk_of_the_shipped_ensemble_rises_through_an_application() -> None:
    with vehicle(**PRIOR) as car:
        car.pressure = 0.0
        car.until(lambda: car.risk == 0.0, 'the release')
        car.pressure, risks = 7.84e5, list[float]()
        car.until(lambda: risks.append(car.risk) or car.risk > 0.8, 'a risk')  # type: ignore
        assert risks == sorted(risks)
        assert len({risk for risk in risks if 0.02 < risk < 0.8}) > 3  # neither never nor always
        figures = values(car.status)
        assert figures['risk_basis'].startswith('not calibrated')
        assert figures['risk_incomplete'] == 'False'
        assert 0.0 < float(figures['risk_error']) < 0.2
        assert float(figures['build_up_nepers']) == car.said['build_up'].data > 3.0
        assert float(figures['damping_ratio']) == car.said['damping_ratio'].data < 0.0
        assert 0.9 < car.said['instability_probability'].data <= 1.0
        assert float(figures['time_to_squeal_s']) >= 0.0
        assert int(car.figures['emulator_evaluations']) > 3


def test_without_an_emulator_the_node_names_the_remedy_once(
        capfd: pytest.CaptureFixture[str]) -> None:
    with vehicle(growth_emulator='none') as car:
        car.until(lambda: len(car.unstable) > 1, 'unstable modes')
        assert math.isnan(car.risk)
        assert car.said['instability_probability'].data == 1.0
        assert car.status.level[0] == WARN
        assert car.status.message.startswith('squeal risk not known: no growth emulator')
        assert car.node_status.level[0] == WARN
        assert 'squeal tabulate' in car.node_status.message
        assert not car.events
    log = [line for line in capfd.readouterr().err.splitlines() if 'squeal risk not known' in line]
    assert len(log) == 1
    assert 'WARN' in log[0]

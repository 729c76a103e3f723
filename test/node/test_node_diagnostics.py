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

"""/diagnostics of the node (REP-107): how often, on what, in which form; the log beside it."""

import math
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from sensor_msgs.msg import JointState  # noqa: E402
from squeal_core.monitor.alarm_events import AlarmEvents  # noqa: E402
from squeal_core.monitor.margins import Margin, OTHERS  # noqa: E402
from squeal_core.monitor.settings import read_settings  # noqa: E402
from squeal_core.monitor.vehicle_monitor import Assessment, Reading  # noqa: E402
from squeal_ros.node import diagnostics as reporting  # noqa: E402
from squeal_ros.node.costly_figures import CostlyFigures  # noqa: E402
from squeal_ros.node.messages import COSTLY, levels, OK, WARN  # noqa: E402
from support.node_runs import vehicle  # noqa: E402, I100
from support.vehicle import Vehicle  # noqa: E402


def test_once_a_second_and_at_once_on_a_change_of_level(monkeypatch: pytest.MonkeyPatch) -> None:
    steady = [10**9]
    monkeypatch.setattr(reporting, 'time', SimpleNamespace(monotonic_ns=lambda: steady[0]))
    with vehicle(diagnostics_rate=1.0) as car:
        car.until(lambda: car.risk > 0.99 and car.status.level[0] == WARN)
        heard: list[Any] = []
        car.node.create_subscription(type(car.said['diagnostics']), '/diagnostics',
                                     heard.append, 10)
        car.until(lambda: heard)
        heard.clear()
        car.advance(4.0)
        assert sorted(status.name for message in heard for status in message.status) == (
            4 * ['squeal_monitor: fl'] + 4 * ['squeal_monitor: node'])
        assert len(heard) == 8  # in ticks of their own
        heard.clear()
        for _ in range(3):  # a second of steady time counts, too, for a simulation that crawls
            steady[0] += 10**9
            car.advance(0.05)
        assert len(heard) == 3
        heard.clear()
        car.pressure, released = 0.0, car.simulated
        car.until(lambda: heard and car.status.level[0] == OK)
        assert car.simulated <= released + 0.65 * 1e9  # risk_hold, and two ticks


def test_every_figure_is_a_value() -> None:
    with vehicle(brakes=['fl', 'fr']) as car:
        car.until(lambda: car.risk > 0.99)
        fl, fr, node = car.said['diagnostics'].status
        assert [s.name for s in (fl, fr, node)] == [
            f'squeal_monitor: {part}' for part in ('fl', 'fr', 'node')]
        assert [s.hardware_id for s in (fl, fr)] == ['fl', 'fr']
        texts = {'state', 'friction_source', 'modes_from', 'risk_basis', 'risk_incomplete',
                 'likely_modes', 'unstable_frequencies_hz', 'unstable_growth_rates_1_s',
                 'unstable_mode_numbers',
                 'unstable_build_ups_nepers', 'mode_shapes', 'model',
                 'audit_failed_names', 'cross_checks', 'friction_margin_reason',
                 'friction_margin_confirmed', 'quiet_pressure_confirmed',
                 'quiet_pressure_reason', 'split_basis', 'split_confirmed', 'split_reason'}
        for status in (fl, fr, node):
            keys = [item.key for item in status.values]
            assert len(set(keys)) == len(keys)
            for item in status.values:
                if item.key not in texts and not item.key.endswith('_status'):
                    float(item.value)
        assert all(len(text.split()) == len(car.unstable) for text in (
            item.value for item in fl.values if item.key.startswith('unstable_')))


@pytest.mark.parametrize(('rate', 'diagnostics_rate', 'at_once'), [
    (100.0, 1.0, 1), (10.0, 1.0, 2), (10.0, 10.0, 12)])
def test_costly_figures_are_spread_over_ticks(rate: float, diagnostics_rate: float,
                                              at_once: int) -> None:
    """Each from its tick's assessment; a brake is complete before the next one's turn."""
    computed: list[tuple[int, str]] = []

    def brake(tick: int, name: str) -> Assessment:
        def margin(key: str) -> Margin:
            computed.append((tick, f'{name} {key}'))
            return Margin(parameter='friction', kind='squeal', present=0.4, reason='')

        stability: Any = SimpleNamespace(margins=SimpleNamespace(compute_other=margin))
        return Assessment(brake=name, time=tick, state='steady', reason='', stability=stability)

    settings = read_settings({'brakes': ['fl', 'fr'], 'rate': rate,
                              'diagnostics_rate': diagnostics_rate})
    costly = CostlyFigures(settings)
    costly.begin({0, 1})
    found: dict[int, dict[str, object]] = {}
    for tick in range(-(-2 * len(COSTLY) // at_once)):
        assert len(found) < 2
        found |= costly.compute([brake(tick, name) for name in ('fl', 'fr')])
    assert [name for _, name in computed] == [f'{b} {n}' for b in ('fl', 'fr') for n in COSTLY]
    assert [tick for tick, _ in computed] == [i // at_once for i in range(len(computed))]
    assert all(f'margin_{name}' in values for name in OTHERS for values in found.values())
    assert costly.compute([brake(99, name) for name in ('fl', 'fr')]) == {}


def test_a_risk_about_its_threshold_does_not_chatter() -> None:
    settings = read_settings({'brakes': ['fl'], 'risk_warning': 0.5, 'risk_hysteresis': 0.1})
    alarms = AlarmEvents(settings)
    inputs = {'rotor_speed': Reading('good'), 'pressure': Reading('good')}

    def level(tick: int, risk: float) -> int:
        found = [Assessment(brake='fl', time=tick * 100_000_000, state='steady', reason='',
                            inputs=inputs, risk=risk)]
        alarms.update(found)
        return levels(found, alarms)[0]

    said = [level(tick, 0.5 + 0.05 * (-1) ** tick) for tick in range(100)]
    assert said == [WARN] * 100
    said = [level(tick, 0.3) for tick in range(100, 120)]
    assert said == sorted(said, reverse=True)
    assert said[-1] == OK


def test_what_cannot_be_read_is_logged_once_and_counted_after(
        capfd: pytest.CaptureFixture[str]) -> None:
    with vehicle(brakes=['fl', 'fr']) as car:
        car.silent = {'rotor_speed'}
        for message in (JointState(name=['WSS', 'fl_wheel'], velocity=[1.0, 2.0]),
                        JointState(name=['fl_wheel_joint', 'fr_wheel_joint'])):
            before = int(car.figures.get('unreadable_messages', 0))
            car.until(lambda m=message, n=before: unread(car, m) > n + 20,  # type: ignore[misc]
                      'twenty more')
        assert math.isnan(car.risk)
        log = capfd.readouterr().err
        for brake in ('fl', 'fr'):
            path = f'velocity[name={brake}_wheel_joint]'
            assert log.count(f"{path}: no '{brake}_wheel_joint' in the list 'name'; do you mean "
                             "'fl_wheel'? the message has in its list 'name': WSS, fl_wheel\n"
                             ) == 1
            assert log.count(f'{path}: the list is empty; have its source send as many values as '
                             "there are in 'name': 0 and 2 now\n") == 1


def unread(car: Vehicle, message: Any) -> int:
    car._publishers['rotor_speed'].publish(message)
    return int(car.figures.get('unreadable_messages', 0))

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

"""The node's life cycle: transitions good and bad, failures that say why, other models."""

import math
from pathlib import Path
import random
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from lifecycle_msgs.msg import State, Transition  # noqa: E402, I100
from lifecycle_msgs.srv import (  # noqa: E402
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from squeal_core import BrakeModel  # noqa: E402
from squeal_core.common.resources import config_folder  # noqa: E402
from support.node_runs import vehicle  # noqa: E402, I100
from support.vehicle import Vehicle  # noqa: E402

CONFIGURE, CLEANUP = Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_CLEANUP
ACTIVATE, DEACTIVATE = Transition.TRANSITION_ACTIVATE, Transition.TRANSITION_DEACTIVATE
# where each valid request leads, by label: what REP-2002's design of managed nodes draws
LEADS = {'unconfigured': {CONFIGURE: 'inactive'},
         'inactive': {ACTIVATE: 'active', CLEANUP: 'unconfigured'},
         'active': {DEACTIVATE: 'inactive'}}
LABELS = {CONFIGURE: 'configure', CLEANUP: 'cleanup', ACTIVATE: 'activate',
          DEACTIVATE: 'deactivate'}


def change(car: Vehicle, number: int = 0, label: str = '') -> bool:
    request = ChangeState.Request(transition=Transition(id=number, label=label))
    return bool(car.ask(ChangeState, 'change_state', request).success)


def state(car: Vehicle) -> str:
    return str(car.ask(GetState, 'get_state', GetState.Request()).current_state.label)


def assessing(car: Vehicle) -> None:
    car.said.clear()
    car.until(lambda: car.risk > 0.99, 'risk near one')


def test_random_requests_lead_where_they_should_or_nowhere() -> None:
    """500 requests, by number and by label, most of them invalid where they come."""
    draw = random.Random(5)
    labels = [*LABELS.values(), 'shutdown now', 'transition_success', 'create', 'x' * 300, 'é']
    with vehicle(autostart=False) as car:
        expected = 'unconfigured'
        for _ in range(500):
            number, label = draw.choice([
                (draw.choice(list(LABELS)), ''), (0, draw.choice(labels)),
                (draw.choice([0, 1, 8, 10, 30, 62, 99, 255]), ''),
                (99, draw.choice(list(LABELS.values())))])
            meant = next((n for n, text in LABELS.items() if text == label), number)
            leads = LEADS[expected].get(meant) if label in ('', *LABELS.values()) else None
            assert change(car, number, label) == (leads is not None), (expected, number, label)
            expected = leads or expected
            assert state(car) == expected
        if expected == 'unconfigured':
            assert change(car, CONFIGURE)
        if expected != 'active':
            assert change(car, ACTIVATE)
        assessing(car)
        assert car.monitor.health.errors == 0  # a refusal is none of the node's


@pytest.mark.parametrize(('number', 'label', 'name'), [
    (CONFIGURE, '', 'number 1'), (0, 'configure', "'configure'"), (0, 'no\n', r"'no\n'")])
def test_a_refused_request_is_one_line_that_says_what_is_possible(
        number: int, label: str, name: str, capfd: pytest.CaptureFixture[str]) -> None:
    with vehicle() as car:
        capfd.readouterr()
        assert not change(car, number, label)
        (line,) = (part for part in capfd.readouterr().err.splitlines() if 'transition' in part)
        assert line.startswith('[WARN]')
        assert line.endswith(f'refused transition {name}: the node is active; possible now: '
                             'deactivate, shutdown')


def test_shutdown_is_the_end_and_the_node_still_answers() -> None:
    with vehicle() as car:
        assert change(car, Transition.TRANSITION_ACTIVE_SHUTDOWN)
        for number in range(12):
            assert not change(car, number)
        assert state(car) == 'finalized'
        answer = car.ask(GetAvailableTransitions, 'get_available_transitions',
                         GetAvailableTransitions.Request())
        assert list(answer.available_transitions) == []
        states = car.ask(GetAvailableStates, 'get_available_states', GetAvailableStates.Request())
        assert State.PRIMARY_STATE_ACTIVE in {s.id for s in states.available_states}


def test_autostart_false_waits_for_a_request() -> None:
    with vehicle(autostart=False) as car:
        assert state(car) == 'unconfigured'
        assert change(car, CONFIGURE)
        assert change(car, ACTIVATE)
        assessing(car)


def set_model(car: Vehicle, model: object) -> Any:
    return car.monitor.set_parameters([Parameter('model', value=str(model))])[0]


def test_another_model_without_a_restart(kang: BrakeModel, tmp_path: Path) -> None:
    from dataclasses import replace
    softer = replace(kang, nominal_contact_stiffness=0.5 * kang.nominal_contact_stiffness)
    softer.save(tmp_path / 'softer.npz')
    with vehicle() as car:
        car.until(lambda: len(car.unstable) > 1)
        before = car.unstable
        for number in (DEACTIVATE, CLEANUP):
            assert change(car, number)
        assert set_model(car, tmp_path / 'softer.npz').successful
        for number in (CONFIGURE, ACTIVATE):
            assert change(car, number)
        car.said.clear()
        car.until(lambda: len(car.unstable) > 1)
        assert car.unstable != before
        assert math.isnan(car.risk)  # the other model has no emulator of growth
        assert 'no growth emulator' in car.node_status.message


@pytest.mark.parametrize(('name', 'bad', 'words'), [
    ('model', 'nobody', 'nobody'), ('model', str(config_folder() / 'monitor.yaml'), 'monitor'),
    ('fl.pressure.type', 'no_msgs/msg/None', 'no_msgs'),
    ('fl.pressure.type', 'std_msgs/msg/__name__', '__name__'),
    ('fl.pressure.topic', 'not a topic', 'not a topic'),
    ('fl.pressure.field', 'a..b', 'a..b')])
def test_failed_configure_says_why_and_works_once_mended(
        name: str, bad: str, words: str, capfd: pytest.CaptureFixture[str]) -> None:
    with vehicle(autostart=False) as car:
        good = car.monitor.get_parameter(name).value
        assert car.monitor.set_parameters([Parameter(name, value=bad)])[0].successful
        assert not change(car, CONFIGURE)
        assert state(car) == 'unconfigured'
        log = capfd.readouterr().err
        assert 'cannot configure' in log
        assert words in log
        assert car.monitor.set_parameters([Parameter(name, value=good)])[0].successful
        for number in (CONFIGURE, ACTIVATE):
            assert change(car, number)
        assessing(car)


def test_cycles_leave_nothing_behind() -> None:
    with vehicle() as car:
        def entities() -> list[int]:
            node = car.monitor
            return [len(list(x)) for x in (node.publishers, node.subscriptions, node.timers,
                                           node.guards, node.services, node.waitables)]

        before = entities()
        for _ in range(3):
            for trigger in ('deactivate', 'cleanup', 'configure', 'activate'):
                done = getattr(car.monitor, f'trigger_{trigger}')()
                assert done == TransitionCallbackReturn.SUCCESS
        assert entities() == before
        car.monitor.trigger_deactivate()
        car.monitor.trigger_cleanup()
        left = [s.topic_name for s in car.monitor.subscriptions]
        assert left == ['/clock']
        assert not [p.topic_name for p in car.monitor.publishers if 'fl/' in p.topic_name]
        car.monitor.trigger_configure()
        car.monitor.trigger_activate()
        assessing(car)


def test_after_an_error_the_node_can_be_configured_again() -> None:
    with vehicle() as car:
        done = car.monitor.on_error(LifecycleState('active', State.PRIMARY_STATE_ACTIVE))
        assert done == TransitionCallbackReturn.SUCCESS
        assert [s.topic_name for s in car.monitor.subscriptions] == ['/clock']

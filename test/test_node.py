"""The node on real DDS: inputs published, outputs heard. No launch, no mock, no sleep."""

import math
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from harness import LATCHED, PATIENT, Vehicle, vehicle  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from std_msgs.msg import Float64MultiArray  # noqa: E402

from squeal_core import BrakeModel  # noqa: E402
from squeal_core.errors import SquealError  # noqa: E402
from squeal_core.stability import complex_modes  # noqa: E402

OK, WARN, ERROR, STALE = (bytes([n]) for n in range(4))


def steady(car: Vehicle) -> None:
    car.until(lambda: car.risk > 0.99 and car.status is not None and car.status.level == WARN,
              'risk near one')


def test_braking_gives_the_modes_of_the_full_solution(kang: BrakeModel) -> None:
    with vehicle() as car:
        steady(car)
        car.until(lambda: car.status is not None and car.status.level == WARN)
        point = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
        expected = [m.frequency_hz for m in complex_modes(kang, point).unstable
                    if m.kind == 'flutter']
        assert car.unstable == pytest.approx(expected, rel=1e-9)  # at an anchor: rounding alone
        worst = complex_modes(kang, point).flutter_in(1250.0, 16000.0)[0]
        assert car.said['growth_rate'].data == pytest.approx(worst.growth_rate, abs=1e-4)
        car.until(lambda: car.said['friction_margin'].data < 0.0, 'a margin that is confirmed')
        layout = car.said['unstable'].layout
        assert (layout.dim[0].label, layout.dim[0].size) == ('frequency_hz', len(expected))
        values = {item.key: item.value for item in car.status.values}
        assert float(values['growth_rate_1_s']) == pytest.approx(worst.growth_rate, abs=1e-4)
        assert values['state'] == 'steady'
        assert car.said['diagnostics'].header.stamp.sec > 0


def test_released_is_risk_zero_and_an_empty_list() -> None:
    with vehicle() as car:
        car.pressure = 0.0
        car.until(lambda: car.risk == 0.0)
        car.until(lambda: car.status is not None and car.status.level == OK)
        assert car.unstable == []


def test_standing_still_is_not_known() -> None:
    with vehicle() as car:
        car.rotor_speed = 0.0
        car.until(lambda: car.status is not None and 'not sliding' in car.status.message)
        assert math.isnan(car.risk)
        assert len(car.unstable) == 1
        assert math.isnan(car.unstable[0])


BAD: dict[str, tuple[str, float]] = {
    'nan speed': ('rotor_speed', math.nan), 'inf speed': ('rotor_speed', math.inf),
    'nan pressure': ('pressure', math.nan), 'negative pressure': ('pressure', -5e5),
    'huge pressure': ('pressure', 1e12), 'nan friction': ('friction', math.nan),
    'negative friction': ('friction', -0.4)}


@pytest.mark.parametrize('fault', BAD)
def test_invalid_input_gives_no_number_and_recovers(fault: str) -> None:
    signal, value = BAD[fault]
    with vehicle() as car:
        steady(car)
        good = getattr(car, signal)
        setattr(car, signal, value)
        car.until(lambda: math.isnan(car.risk))
        car.until(lambda: car.status.level == ERROR)
        assert signal in car.status.message
        setattr(car, signal, good)
        steady(car)


@pytest.mark.parametrize('signal', ['rotor_speed', 'pressure', 'friction'])
def test_silent_input_goes_stale_and_recovers(signal: str) -> None:
    with vehicle(**{f'fl__{signal}__max_age': 0.2}) as car:
        steady(car)
        car.silent.add(signal)
        # a busy machine may make others stale for a moment, too
        car.until(lambda: car.status.level == STALE and signal in car.status.message
                  and math.isnan(car.risk))
        assert math.isnan(car.unstable[0])
        car.silent.clear()
        steady(car)


def test_nothing_received_is_stale_from_the_first_tick() -> None:
    with vehicle() as car:
        car.silent |= {'rotor_speed', 'pressure', 'friction'}
        car.until(lambda: car.status is not None)
        assert car.status.level == STALE
        assert 'never received' in car.status.message
        assert math.isnan(car.risk)


def test_turning_backwards_is_assessed_too() -> None:
    with vehicle() as car:
        car.rotor_speed = -20.0
        steady(car)


def test_temperature_stands_in_for_friction() -> None:
    with vehicle(fl__friction__topic='', fl__temperature__topic='fl/rotor_temperature') as car:
        car.temperature = 100.0
        steady(car)
        values = {item.key: item.value for item in car.status.values}
        assert values['friction_source'] == 'temperature'
        assert float(values['friction']) == pytest.approx(0.42)  # the table's own point


def test_scale_turns_bar_into_pascal() -> None:
    with vehicle(fl__pressure__scale=1e5) as car:
        car.pressure = 7.84
        steady(car)


def test_late_subscriber_gets_the_last_unstable_list() -> None:
    with vehicle(**PATIENT) as car:
        steady(car)
        topic, heard = '/squeal_monitor/fl/unstable_frequencies', list[Any]()
        car.monitor.set_parameters([Parameter('rate', value=0.1)])  # no other comes for a while
        car.node.create_subscription(Float64MultiArray, topic, heard.append, LATCHED)
        car.until(lambda: len(heard) > 0)
        assert len(heard[0].data) > 1


def test_last_word_of_a_node_that_stops_is_not_known() -> None:
    with vehicle() as car:
        steady(car)
        car.monitor.trigger_deactivate()
        car.until(lambda: math.isnan(car.risk))
        car.until(lambda: car.status.level == STALE and 'not active' in car.status.message)
        heard = list[Any]()
        car.node.create_subscription(
            Float64MultiArray, '/squeal_monitor/fl/unstable_frequencies', heard.append, LATCHED)
        car.until(lambda: len(heard) > 0)
        assert math.isnan(heard[0].data[0])


def test_namespace_moves_inputs_and_outputs() -> None:
    with vehicle(namespace='/car') as car:
        steady(car)


def test_unreadable_messages_are_counted_and_never_a_number() -> None:
    with vehicle(fl__rotor_speed__field='velocity[name=nobody]') as car:
        car.until(lambda: car.status is not None and car.status.level == STALE)
        assert math.isnan(car.risk)
        car.until(lambda: int(car.figures.get('unreadable_messages', 0)) > 0)
        car.until(lambda: car.status.message == (
            'rotor_speed never received, messages come without it '
            "(velocity[name=nobody]: no 'nobody' in the list 'name')"), 'the cause')


def test_inactive_node_is_silent() -> None:
    with vehicle() as car:
        steady(car)
        car.monitor.trigger_deactivate()
        for _ in range(10):  # what was on its way when it stopped
            car.spin(0.01)
        car.said.clear()
        for _ in range(25):  # half a second: ten ticks of an active node
            car.publish()
            car.spin(0.02)
        assert not {'squeal_risk', 'diagnostics'} & set(car.said)


@pytest.mark.parametrize(('values', 'words'), [
    ({'rate': -1.0}, 'rate'), ({'rate': math.nan}, 'rate'), ({'brakse': 'x'}, 'brakse'),
    ({'model': 'nobody'}, 'nobody'), ({'fl__rotor_speed__field': 'a..b'}, 'a..b'),
    ({'fl__pressure__type': 'no_msgs/msg/None'}, 'no_msgs'),
    ({'fl__pressure__topic': 'not a topic'}, 'not a topic'),
    ({'squeal_band_low_hz': 2e4}, 'squeal_band')])
def test_bad_settings_end_the_start_with_their_name(values: dict[str, Any], words: str) -> None:
    with pytest.raises(SquealError, match=words), vehicle(**values):
        pytest.fail('the node started')


def test_one_message_feeds_several_brakes() -> None:
    with vehicle(brakes=['fl', 'fr']) as car:
        steady(car)
        statuses = car.said['diagnostics'].status
        assert [s.hardware_id for s in statuses] == ['fl', 'fr', 'squeal_monitor']
        assert 'never received' in statuses[1].message

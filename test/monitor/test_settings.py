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

"""Settings of the monitor: defaults, and every key with every kind of wrong value."""

import math
from typing import Any

from squeal_core.monitor.brake_settings import InputSettings
from squeal_core.monitor.setting_specs import SettingSpec
from squeal_core.monitor.settings import read_settings, settings_keys
from support.rows import each
from support.setting_refusals import read, refusal

KEYS = {key.name: key for key in settings_keys(('a',))}
NUMBERS = [key for key in KEYS.values() if isinstance(key.default, float)]
TEXTS = [key for key in KEYS.values() if isinstance(key.default, str)]
ROTOR = InputSettings(topic='joint_states', type='sensor_msgs/msg/JointState',
                      field='velocity[name=a_wheel_joint]', scale=1.0, offset=0.0, max_age=0.5,
                      minimum=-400.0, maximum=400.0, stuck_after=2.0, movement=0.004)


def refused(key: str, value: Any) -> str:
    """Return the refusal of a value, which names its key and shows it."""
    text = refusal({'brakes': ['a'], key: value})
    assert text.startswith(f'{key}: is {value!r} [')
    return text


def test_default_brakes_and_monitor() -> None:
    settings = read_settings({})
    assert [brake.name for brake in settings.brakes] == [
        'front_left', 'front_right', 'rear_left', 'rear_right']
    assert (settings.model, settings.autostart, settings.rate) == ('kang2009', True, 10.0)
    assert settings.period == 100_000_000
    assert (settings.squeal_band_low_hz, settings.squeal_band_high_hz) == (1250.0, 16000.0)
    assert (settings.release_pressure, settings.minimum_rotor_speed) == (0.5e5, 0.5)
    assert 0.0 < settings.risk_warning <= 1.0


def test_default_inputs() -> None:
    inputs = read().brakes[0].inputs
    assert list(inputs) == ['rotor_speed', 'pressure', 'friction']
    assert inputs['rotor_speed'] == ROTOR
    found = {name: (i.topic, i.type, i.field, i.offset) for name, i in inputs.items()}
    assert found['pressure'] == (
        'a/brake_pressure', 'sensor_msgs/msg/FluidPressure', 'fluid_pressure', 0.0)
    assert found['friction'] == ('a/friction', 'std_msgs/msg/Float64', 'data', 0.0)


def test_temperature_comes_in_degrees_celsius() -> None:
    temperature = read(a__temperature__topic='/t').brakes[0].inputs['temperature']
    assert (temperature.type, temperature.field) == ('sensor_msgs/msg/Temperature', 'temperature')
    assert (temperature.scale, temperature.offset) == (1.0, 273.15)
    assert temperature.minimum < 293.15 < 1000.0 < temperature.maximum


def test_defaults_pass_their_own_check() -> None:
    for key in KEYS.values():
        assert key.read(key.default) == key.default
        assert key.meaning
        assert key.unit


def test_values_arrive_where_they_belong() -> None:
    settings = read(rate=50, a__pressure__max_age=2, a__friction__scale=-1, autostart=False,
                    squeal_band_low_hz=800, model='/m.npz')
    assert (settings.rate, settings.period, settings.autostart) == (50.0, 20_000_000, False)
    assert (settings.squeal_band_low_hz, settings.model) == (800.0, '/m.npz')
    inputs = settings.brakes[0].inputs
    assert (inputs['pressure'].max_age, inputs['friction'].scale) == (2.0, -1.0)
    assert inputs['friction'].max_age == 0.5


def test_integers_count_as_numbers_and_become_them() -> None:
    assert type(read(rate=50).rate) is float
    assert type(read(a__pressure__scale=100000).brakes[0].inputs['pressure'].scale) is float


@each('key', NUMBERS)
@each('value', ['10', '', None, True, False, [1.0], {}, 1j])
def test_what_is_no_number(key: SettingSpec, value: Any) -> None:
    assert 'give a number' in refused(key.name, value)


@each('key', NUMBERS)
@each('value', [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite(key: SettingSpec, value: float) -> None:
    remedy = 'give a number from' if math.isfinite(key.minimum) else 'give a finite number'
    assert remedy in refused(key.name, value)


def test_numbers_larger_than_floats() -> None:
    for number in (10**400, -10**400):
        text = refusal({'rate': number})
        assert text.startswith('rate: is ')
        assert text.endswith('[Hz]; give a number from 0.1 to 1000')
        assert len(text) < 150


@each('value', ['x' * 10**5, ['x'] * 10**5, {'x' * 10**5: 1}])
@each('key', ['rate', 'autostart', 'brakes', 'rats', 'k' * 10**5])
def test_refusals_stay_short(key: str, value: Any) -> None:
    assert len(refusal({key: [1, value] if key == 'brakes' else value})) < 250


@each('key', [k for k in NUMBERS if k.maximum < math.inf])
def test_numbers_out_of_range(key: SettingSpec) -> None:
    for value in (math.nextafter(key.minimum, -math.inf), math.nextafter(key.maximum, math.inf)):
        assert f'give a number from {key.minimum:g} to {key.maximum:g}' in refused(
            key.name, value)
    assert key.read(key.minimum) == key.minimum
    assert key.read(key.maximum) == key.maximum


@each('key', [
    'rate', 'diagnostics_rate', 'release_pressure', 'minimum_rotor_speed', 'squeal_band_low_hz',
    'risk_warning', 'damping_deviation', 'friction_bias_deviation', 'friction_scatter',
    'contact_stiffness_deviation', 'a.rotor_speed.max_age', 'a.friction.max_age'])
def test_what_must_not_be_negative(key: str) -> None:
    assert 'give a number from' in refused(key, -1e-9)


@each('key', ['rate', 'diagnostics_rate', 'minimum_rotor_speed',
              'squeal_band_high_hz', 'a.pressure.max_age'])
def test_what_must_not_be_zero(key: str) -> None:
    assert 'give a number from' in refused(key, 0.0)


@each('key', TEXTS)
@each('value', [1, 1.5, None, True, ['x'], {}])
def test_what_is_no_text(key: SettingSpec, value: Any) -> None:
    assert 'give a str' in refused(key.name, value)


@each('value', [0, 1, 'true', None, []])
def test_what_is_no_switch(value: Any) -> None:
    assert 'give a bool' in refused('autostart', value)


@each('value', ['front_left', None, 3, [1], ['a', None], {'a': 1}, True])
def test_what_is_no_list_of_names(value: Any) -> None:
    text = refusal({'brakes': value})
    assert text.startswith(f'brakes: is {value!r} [')
    assert 'give a list of names' in text


@each('name', [
    '', ' ', 'front left', 'a.b', 'a/b', '1a', 'a-b', '~', '{a}', 'vorn_links_ä', 'a\nb'])
def test_illegal_brake_names(name: str) -> None:
    assert refusal({'brakes': ['ok', name]}) == (
        f'brakes: has {name!r}; use letters, digits and _')


@each('names', [[], ['a', 'a'], ['a', 'b', 'a']])
def test_brakes_named_twice_or_not_at_all(names: list[str]) -> None:
    assert refusal({'brakes': names}) == f'brakes: is {names}; name each brake once'


@each('key', [
    'rates', 'a', 'a.pressure', 'a.pressure.topics', 'a.presure.topic', 'b.pressure.topic',
    'front_left.pressure.topic', 'a.pressure.topic.x', ''])
def test_unknown_keys(key: str) -> None:
    assert refusal({'brakes': ['a'], key: 'x'}).startswith(
        f"{key}: unknown key (value 'x'); see config/monitor.yaml for the keys")
    near = {'rates': 'rate', 'a.presure.topic': 'a.pressure.topic',
            'a.pressure.topics': 'a.pressure.topic'}.get(key)
    if near:
        assert refusal({'brakes': ['a'], key: 'x'}).endswith(f'(did you mean {near}?)')


def test_unknown_key_of_two_lines() -> None:
    assert refusal({'a\nb': 'x'}).startswith("a b: unknown key (value 'x'); ")


@each(('low', 'high'), [(1250.0, 1250.0), (2000.0, 1000.0), (16000.0, 1250)])
def test_squeal_band_in_order(low: float, high: float) -> None:
    text = refusal({'squeal_band_low_hz': low, 'squeal_band_high_hz': high})
    assert text.startswith('squeal_band_high_hz: is ')
    assert f'{float(high)} ' in text
    assert f'{low} Hz' in text
    assert 'make it the larger' in text


@each('signal', ['rotor_speed', 'pressure'])
def test_topics_that_must_be(signal: str) -> None:
    key = f'a.{signal}.topic'
    assert refusal({'brakes': ['a'], key: ''}) == f"{key}: is ''; name a topic"


def test_friction_or_temperature_must_be() -> None:
    text = refusal({'brakes': ['a'], 'a.friction.topic': ''})
    assert text == ("a.friction.topic: is '' and so is temperature.topic; name one of them, or "
                    'give friction.constant: docs/howto/missing_sensors.md')
    inputs = read(a__friction__topic='', a__temperature__topic='/t').brakes[0].inputs
    assert list(inputs) == ['rotor_speed', 'pressure', 'temperature']


def test_a_constant_friction_stands_alone() -> None:
    (brake,) = read(a__friction__topic='', a__friction__constant=0.4).brakes
    assert (list(brake.inputs), brake.constant_friction) == (['rotor_speed', 'pressure'], 0.4)
    assert read(a__friction__constant=0.0).brakes[0].constant_friction == 0.0
    given = {'brakes': ['a'], 'a.friction.constant': 0.4}
    assert refusal(given) == ('a.friction.constant: is 0.4, and friction has a topic; leave it '
                              "out, or set friction.topic to ''")
    given |= {'a.friction.topic': '', 'a.temperature.topic': 't'}
    assert 'is 0.4, and temperature has a topic' in refusal(given)
    given |= {'a.temperature.topic': '', 'validated_friction_low': 0.45}
    assert refusal(given) == (
        'a.friction.constant: is 0.4; give 0.45 to 0.9, or change validated_friction_low and '
        'validated_friction_high')


@each(('changes', 'text'), [
    ({'a.pressure.minimum': 2.0, 'a.pressure.maximum': 1.0},
     'a.pressure.maximum: is 1 and the minimum 2; make it the larger'),
    ({'a.pressure.minimum': 1.0, 'a.pressure.maximum': 1.0},
     'a.pressure.maximum: is 1 and the minimum 1; make it the larger'),
    ({'a.pressure.scale': 0.0}, 'a.pressure.scale: is 0; give another number'),
    *(({f'a.{signal}.{limit}': value},
       f'a.{signal}.{limit}: is {value} [{unit}]; give a number from 0.001 to inf')
      for signal, unit in (('friction', '-'), ('temperature', 'K'))
      for limit in ('minimum', 'maximum') for value in (0.0, -1.0))])
def test_limits_that_cannot_be_meant(changes: dict[str, float], text: str) -> None:
    assert refusal({'brakes': ['a'], 'a.temperature.topic': '/t', **changes}) == text


@each(('name', 'bad', 'least'), [
    ('risk_warning', 0.0, 0.01),  # it would warn at a risk of zero
    ('ensemble_size', 8.0, 16.0),  # too few for a mean
    ('noise_floor_nm', 20.0, 10.0)])  # a tone at 1 bar would end below what is audible
def test_values_with_which_the_risk_would_mean_nothing(name: str, bad: float,
                                                       least: float) -> None:
    assert 'give a number from' in refused(name, bad)
    assert getattr(read(**{name: least}), name) == least

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

"""Field paths against the types of their messages, and the node that is told a wrong one."""

from collections.abc import Mapping

import pytest
from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.settings import read_settings
from squeal_ros.node.field_check import check_fields, check_path
from squeal_ros.node.field_paths import FieldPath
from support.rows import each

TYPES: Mapping[str, Mapping[str, str]] = {
    'w/Joints': {'header': 'std/Header', 'name': 'sequence<string>',
                 'velocity': 'sequence<double>', 'wheels': 'sequence<w/Wheel, 4>'},
    'w/Wheel': {'speed': 'float', 'temperatures': 'double[3]', 'name': 'string', 'on': 'boolean'},
    'std/Header': {'frame_id': 'string'},
    'w/Frame': {'id': 'uint32', 'data': 'uint8[8]'},
    'w/Bytes': {'data': 'sequence<uint8>'}}


def fields(name: str) -> Mapping[str, str]:
    if name not in TYPES:
        raise ConfigurationError('type', f'is {name!r}', 'mend it')
    return TYPES[name]


@each('text', ['velocity[0]', 'velocity[name=fl]', 'wheels[3].speed', 'wheels[0].temperatures[2]',
               'wheels[0].on'])
def test_paths_that_lead_to_a_number(text: str) -> None:
    assert check_path(FieldPath.parse(text), 'w/Joints', fields) == ''


@each(('text', 'words'), [
    ('velocty[0]', "has no field 'velocty'; use one of header, name, velocity, wheels (did you "
     'mean velocity?)'),
    ('velocity', 'is a list (sequence<double>); write velocity[0], or velocity[name=TEXT]'),
    ('velocity.x', 'velocity is a list'), ('header', 'is a message (std/Header); use one of'),
    ('header.frame_id', 'is string, no number'), ('header[0]', 'no list; leave [0] off'),
    ('wheels[0].speed.x', 'is float and has no fields'),
    ('wheels[0].temperatures[3]', 'has 3 elements; count from 0 to 2'),
    ('velocity[nam=fl]', "no list 'nam' of texts; name one of name"),
    ('wheels[0].temperatures[name=x]', "no list 'name' of texts; write"),
    ('name[0]', 'is string')])
def test_paths_that_do_not(text: str, words: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        check_path(FieldPath.parse(text), 'w/Joints', fields)
    assert str(caught.value).startswith(f'field: is {text!r}, and ')
    assert words in str(caught.value)


def test_raw_frames_are_refused_and_single_bytes_doubted() -> None:
    with pytest.raises(ConfigurationError, match='neither an id nor a 16-bit word; decode the'):
        check_path(FieldPath.parse('data[0]'), 'w/Frame', fields)
    assert 'is a single byte' in check_path(FieldPath.parse('data[0]'), 'w/Bytes', fields)


@each(('changes', 'words'), [
    ({'a.pressure.type': 'w/Nothing'}, "a.pressure.type: is 'w/Nothing'"),
    ({'a.pressure.field': 'speeds'}, "a.pressure.field: is 'speeds', and w/Wheel has no field"),
    ({'a.pressure.type': 'can_msgs/msg/Frame'}, 'a.pressure.type: is')])
def test_errors_name_the_key(changes: Mapping[str, str], words: str) -> None:
    settings = read_settings({
        'brakes': ['a'], 'a.rotor_speed.type': 'w/Joints', 'a.pressure.type': 'w/Wheel',
        'a.pressure.field': 'speed', 'a.friction.type': 'w/Wheel', 'a.friction.field': 'speed',
        **changes})
    with pytest.raises(ConfigurationError) as caught:
        check_fields(settings, fields, lambda _: None)
    assert str(caught.value).startswith(words)


def test_the_node_checks_paths_when_it_is_configured() -> None:
    pytest.importorskip('rclpy', reason='needs rclpy')
    from support.node_runs import vehicle
    from support.vehicle import parameters
    with vehicle(bring_up=False, autostart=False) as car:
        car.monitor.set_parameters(parameters(fl__pressure__field='fluid_presure'))
        assert car.monitor.trigger_configure().name == 'FAILURE'
        car.monitor.set_parameters(parameters(fl__pressure__field='fluid_pressure'))
        assert car.monitor.trigger_configure().name == 'SUCCESS'


def test_the_node_takes_a_dump_of_its_own_parameters(tmp_path: object) -> None:
    """As `ros2 param dump` writes them and `ros2 param load` reads and sets them."""
    pytest.importorskip('rclpy', reason='needs rclpy')
    from pathlib import Path

    from rclpy.parameter import Parameter, parameter_dict_from_yaml_file
    from support.node_runs import vehicle
    import yaml
    with vehicle(bring_up=False, autostart=False) as car:
        node = car.monitor
        values = {name: parameter.value
                  for name, parameter in node.get_parameters_by_prefix('').items()}
        nested: dict[str, object] = {}
        for name, value in values.items():
            *sections, key = name.split('.') if not name.startswith('qos') else [name]
            place = nested
            for section in sections:
                place = place.setdefault(section, {})  # type: ignore[assignment]
            place[key] = value
        path = Path(str(tmp_path)) / 'dump.yaml'
        path.write_text(yaml.dump({'/squeal_monitor': {'ros__parameters': nested}}))
        loaded = parameter_dict_from_yaml_file(str(path))
        assert set(loaded) == set(values)
        writable = {name: message for name, message in loaded.items()
                    if not node.describe_parameter(name).read_only}
        assert len(writable) > 60
        results = {name: node.set_parameters([Parameter.from_parameter_msg(message)])[0]
                   for name, message in writable.items()}
        assert {name: r.reason for name, r in results.items() if not r.successful} == {}
        assert {name: node.get_parameter(name).value for name in writable} == {
            name: values[name] for name in writable}

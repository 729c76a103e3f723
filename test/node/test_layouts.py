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

"""Every topic and field of the shipped layouts is there: read from messages of a running node."""

from collections.abc import Iterator
import json
import re
import time
from typing import Any
from xml.etree import ElementTree

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from rclpy.qos import qos_profile_sensor_data  # noqa: E402
from sensor_msgs.msg import FluidPressure, JointState  # noqa: E402
from squeal_core.common.resources import config_folder  # noqa: E402
from squeal_core.model.brake_model import BrakeModel  # noqa: E402
from squeal_core.monitor.settings import read_settings  # noqa: E402
from squeal_core.surrogate.table_builder import build_table  # noqa: E402
from squeal_core.surrogate.table_domain import TableDomain  # noqa: E402
from squeal_core.surrogate.table_file import write_table  # noqa: E402
from squeal_ros.node.message_types import RosMessages  # noqa: E402
from squeal_ros.node.messages import TYPES  # noqa: E402
from std_msgs.msg import Float64  # noqa: E402
from support.node_outputs import LATCHED  # noqa: E402, I100
from support.node_runs import needs_squeal_msgs, NO_STATE, vehicle  # noqa: E402
from visualization_msgs.msg import Marker  # noqa: E402

FOLDER = config_folder() / 'layouts'
FOXGLOVE = json.loads((FOLDER / 'foxglove.json').read_text(encoding='utf-8'))
PLOTJUGGLER = ElementTree.parse(FOLDER / 'plotjuggler.xml').getroot()


def of_layout(name: str) -> Any:
    """Return a path or curve as a parameter; those of BrakeSqueal need its package."""
    return pytest.param(name, marks=needs_squeal_msgs) if '/state' in name else name


PATHS = [path['value'] for panel in FOXGLOVE['configById'].values()
         for path in panel.get('paths', ())]
CURVES = [curve.attrib['name'] for curve in PLOTJUGGLER.iter('curve')]
BRAKES = read_settings({}).brakes
# Foxglove: .field, [2], [:], {key=="text"}
STEP = re.compile(r'\.(\w+)|\[(\d+|:)\]|\{(\w+)=="([^"]+)"\}')

_LATCHED = ('unstable_frequencies', 'mode_shape')

Said = dict[str, Any]  # the last message of each topic


def braking(car: Any) -> Iterator[tuple[Any, Any]]:
    """Yield publishers and messages that make all four brakes brake."""
    node = car.node
    joints = JointState(name=[f'{brake.name}_wheel_joint' for brake in BRAKES],
                        velocity=[20.0] * len(BRAKES))
    joints.header.stamp = node.get_clock().now().to_msg()
    yield node.create_publisher(JointState, 'joint_states', 10), joints
    for brake in BRAKES:
        pressure = FluidPressure(header=joints.header, fluid_pressure=7.84e5)
        yield node.create_publisher(FluidPressure, f'{brake.name}/brake_pressure', 10), pressure
        yield node.create_publisher(Float64, f'{brake.name}/friction', 10), Float64(data=0.42)


@pytest.fixture(scope='module')
def table(kang: BrakeModel, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Build a table of what `braking` says, down to the critical friction."""
    pressure = kang.contact_pressure(7.84e5)
    path = tmp_path_factory.mktemp('table') / 'table.npz'
    write_table(build_table(kang, TableDomain(
        rotor_speed=(19.9, 20.1), contact_pressure=(0.99 * pressure, 1.01 * pressure),
        friction=(0.001, 0.43))), kang, path)
    return str(path)


@pytest.fixture(scope='module')
def said(table: str) -> Iterator[Said]:
    """Run the node with four brakes braking; what was last said on each topic it uses."""
    heard: Said = {}
    brakes = [brake.name for brake in BRAKES]
    # inputs stay fresh however busy the machine is, and need not be published at every turn: on
    # a busy machine a turn is too short to take in what all topics bring
    ages = {f'{name}__{signal}__max_age': 60.0 for name in brakes
            for signal in ('rotor_speed', 'pressure', 'friction')}
    with vehicle(brake=brakes[0], brakes=brakes, rate=5.0, diagnostics_rate=5.0, mode_shapes=True,
                 table=table, **ages) as car:
        car.silent = {'rotor_speed', 'pressure', 'friction', 'temperature'}
        node, monitor = car.node, (car.monitor.get_name(), car.monitor.get_namespace())
        inputs = dict(car.monitor.get_subscriber_names_and_types_by_node(*monitor))
        outputs = dict(car.monitor.get_publisher_names_and_types_by_node(*monitor))
        wanted = set(topics(FOXGLOVE)) | set(selected_topics())
        if NO_STATE:
            wanted -= {topic for topic in wanted if topic.endswith('/state')}
        for topic, (kind,) in {**inputs, **outputs}.items():
            if topic in wanted:
                qos = LATCHED if topic.endswith(_LATCHED) else qos_profile_sensor_data
                node.create_subscription(RosMessages().type(kind), topic,
                                         lambda message, topic=topic: heard.update(
                                             {topic: message}), qos)
        published, next_time = list(braking(car)), 0.0

        def all_said() -> bool:
            nonlocal next_time
            if time.monotonic() > next_time:
                next_time = time.monotonic() + 0.5
                for publisher, message in published:
                    publisher.publish(message)
            known = [heard[t].data for t in heard if t.endswith('/squeal_risk')]
            drawn = [heard[t].markers[0].action for t in heard if t.endswith('/mode_shape')]
            return (wanted <= set(heard) and len(known) == len(brakes) and min(known) > 0.9
                    and set(drawn) == {Marker.ADD})

        car.until(all_said, f'a message on each of {sorted(wanted)}')
        # the assessments heard last are of four braking brakes: so are the next diagnostics
        last = heard.pop('/diagnostics')
        car.until(lambda: heard.get('/diagnostics', last) is not last, 'newer diagnostics')
        yield heard


def topics(layout: Any) -> Iterator[str]:
    """Yield the topics that a Foxglove layout names, in paths and in panels."""
    for panel in layout['configById'].values():
        if 'topicToRender' in panel:
            yield panel['topicToRender']
        yield from panel.get('topics', ())
        for path in panel.get('paths', ()):
            yield path['value'].partition('.')[0]


def selected_topics() -> list[str]:
    """Return the topics that PlotJuggler subscribes to."""
    (selected,) = PLOTJUGGLER.iter('selected_topics')
    return selected.attrib['value'].split(';')


def foxglove_values(said: Said, path: str) -> list[Any]:
    """Return what Foxglove draws for a path at the last message."""
    topic, _, fields = path.partition('.')
    values, rest = [said[topic]], '.' + fields
    while rest:
        match = STEP.match(rest)
        assert match, f'{path}: cannot read from {rest!r}'
        name, index, key, text = match.groups()
        if name:
            values = [getattr(value, name) for value in values]
        elif index:
            values = [item for value in values
                      for item in (value if index == ':' else [value[int(index)]])]
        else:
            values = [value for value in values if getattr(value, key) == text]
        rest = rest[match.end():]
    return values


def plotjuggler_series(topic: str, message: Any) -> Iterator[tuple[str, float]]:
    """Yield the names PlotJuggler gives the numbers of a message, by its parsers' rules."""
    if hasattr(message, 'status'):  # DiagnosticArray: its texts are read as numbers
        for status in message.status:
            for item in status.values:
                try:
                    number = float(item.value)
                except ValueError:
                    continue
                yield f'{topic}/{status.hardware_id}/{status.name}/{item.key}', number
    elif hasattr(message, 'velocity'):  # JointState: by joint, not by index
        for name, velocity in zip(message.name, message.velocity, strict=True):
            yield f'{topic}/{name}/velocity', velocity
    else:
        for field in message.get_fields_and_field_types():
            value = getattr(message, field)
            if isinstance(value, int | float):
                yield f'{topic}/{field}', value
            elif hasattr(value, 'typecode'):
                yield from ((f'{topic}/{field}[{i}]', item) for i, item in enumerate(value))


@pytest.mark.parametrize('path', map(of_layout, PATHS))
def test_foxglove_draws_numbers_for(said: Said, path: str) -> None:
    values = foxglove_values(said, path)
    assert values
    for value in values:  # numbers, or texts that Foxglove turns into numbers; not NaN here
        number = value[0] if isinstance(value, bytes) else float(value)
        assert number == number


@pytest.mark.parametrize('curve', map(of_layout, CURVES))
def test_plotjuggler_has_the_series(said: Said, curve: str) -> None:
    series = dict(item for topic in selected_topics() if topic in said
                  for item in plotjuggler_series(topic, said[topic]))
    assert curve in series
    assert series[curve] == series[curve]


def test_layouts_show_every_output_of_every_brake(said: Said) -> None:
    for brake in BRAKES:
        for name in (*TYPES, 'state'):
            topic = f'/squeal_monitor/{brake.name}/{name}'
            assert any(path.startswith(f'{topic}.') for path in PATHS), topic
            assert any(curve.startswith(f'{topic}/') for curve in CURVES), topic


def test_foxglove_looks_at_the_frame_of_the_markers(said: Said) -> None:
    panel = FOXGLOVE['configById']['3D!shape']
    (topic,) = panel['topics']
    markers = said[topic].markers
    assert markers
    assert {marker.header.frame_id for marker in markers} == {panel['followTf']}


def test_every_foxglove_panel_is_on_the_screen_once() -> None:
    def panels(place: Any) -> list[str]:
        if isinstance(place, str):
            return [place]
        return panels(place['first']) + panels(place['second'])

    assert sorted(panels(FOXGLOVE['layout'])) == sorted(FOXGLOVE['configById'])


def test_plotjuggler_counts_its_own_plots() -> None:
    for splitter in PLOTJUGGLER.iter('DockSplitter'):
        sizes = [float(size) for size in splitter.attrib['sizes'].split(';')]
        assert len(list(splitter)) == len(sizes) == int(splitter.attrib['count'])
        assert sum(sizes) == pytest.approx(1.0, abs=1e-5)  # they are written with six digits

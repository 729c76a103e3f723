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

"""The security policy lists what the running node has in the graph, no more and no less."""

from collections.abc import Iterator
import re
import subprocess
import sys
from typing import Any, NamedTuple
from xml.etree import ElementTree

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from squeal_core.common.errors import ConfigurationError  # noqa: E402
from squeal_core.common.resources import config_folder  # noqa: E402
from squeal_core.monitor.settings import is_built_in, load_settings, read_settings  # noqa: E402
from squeal_ros.node.lifecycle_node import SquealMonitor  # noqa: E402
from squeal_ros.node.sros2_policy import policy_document  # noqa: E402
from support.node_runs import NO_STATE, vehicle  # noqa: E402, I100

SHIPPED = config_folder() / 'security' / 'squeal_monitor.policy.xml'
SETTINGS = load_settings(config_folder() / 'monitor.yaml')
# what differs from the shipped: names, a namespace, absolute topics, inputs and outputs more
OTHER: dict[str, Any] = {
    'brakes': ['left', 'right'], 'mode_shapes': True, 'left.rotor_speed.topic': '/wheels',
    'right.temperature.topic': 'hot/disc'}


class Case(NamedTuple):
    """A policy, and the node it is for."""

    policy: ElementTree.Element
    monitor: SquealMonitor

    def allowed(self, permission: str, kind: str) -> set[str]:
        """Return absolute names by SROS2's rules: `~` is the node, relative the namespace."""
        (profile,) = self.policy.iter('profile')
        namespace, node = profile.attrib['ns'].rstrip('/') + '/', profile.attrib['node']
        names = [item.text or '' for block in profile if block.get(permission) == 'ALLOW'
                 for item in block.iter(kind)]
        assert len(names) == len(set(names)), f'{permission}: a name is listed twice'
        return {name if name.startswith('/') else
                f'{namespace}{node}{name[1:]}' if name.startswith('~') else
                f'{namespace}{name}' for name in names}


@pytest.fixture(scope='module', params=['shipped', 'other'])
def case(request: pytest.FixtureRequest) -> Iterator[Case]:
    """Return a running node, and the policy for its settings."""
    if request.param == 'shipped':
        policy = ElementTree.parse(SHIPPED).getroot()
        namespace, values = '', {'brakes': [brake.name for brake in SETTINGS.brakes]}
    else:
        namespace, values = '/fleet/car_1', OTHER
        policy = ElementTree.fromstring(policy_document(read_settings(OTHER), namespace))
    named = {name.replace('.', '__'): value for name, value in values.items()}
    with vehicle(brake=values['brakes'][0], namespace=namespace, **named) as car:
        yield Case(policy, car.monitor)


def agree(listed: set[str], live: set[str]) -> None:
    """Fail with what would mend the policy."""
    assert not live - listed, f'not in the policy: {sorted(live - listed)}'
    assert not listed - live, f'not in the graph: {sorted(listed - live)}'


@pytest.mark.parametrize(('permission', 'kind', 'graph'), [
    ('publish', 'topic', SquealMonitor.get_publisher_names_and_types_by_node),
    ('subscribe', 'topic', SquealMonitor.get_subscriber_names_and_types_by_node),
    ('reply', 'service', SquealMonitor.get_service_names_and_types_by_node),
    ('request', 'service', SquealMonitor.get_client_names_and_types_by_node)])
def test_policy_is_the_live_graph(case: Case, permission: str, kind: str, graph: Any) -> None:
    node = case.monitor
    live = {name for name, _ in graph(node, node.get_name(), node.get_namespace())}
    listed = case.allowed(permission, kind)
    if NO_STATE:  # they are listed all the same
        listed -= {name for name in listed if name.endswith('/state')}
    # tests tell the node their time, a vehicle does not (docs/howto/security.md)
    agree(listed, live - {'/clock'})


def test_parameters_are_the_nodes(case: Case) -> None:
    listed = [f'{block.get("of")}.{name}' if block.get('of') else name
              for block in case.policy.iter('parameters') for name in (block.text or '').split()]
    assert len(listed) == len(set(listed))
    live = set(case.monitor.list_parameters([], 0).names)
    overrides = {name for name in live if name.startswith('qos_overrides.')}
    agree(set(listed), live - overrides)
    assert {name for name in listed if is_built_in(name)} == {
        'use_sim_time', 'start_type_description_service'}
    topics = case.allowed('publish', 'topic') | case.allowed('subscribe', 'topic')
    assert all(any(name.startswith(f'qos_overrides.{topic}.') for topic in topics)
               for name in overrides)


class Element(NamedTuple):
    """
    What sros2's policy.xsd 0.2.0 says of an element: attributes, and children in their order.

    Attributes and the numbers of children are regular expressions; a child that ends in * may be
    there any number of times.
    """

    required: dict[str, str] = {}
    optional: dict[str, str] = {}
    children: str = ''
    text: bool = False


RULE = 'ALLOW|DENY'
# written from the published schema: root, what may stand in each element, and in which order
SCHEMA = {
    'policy': Element({'version': '0\\.2\\.0'}, children='enclaves '),
    'enclaves': Element(children='(enclave )+'),
    'enclave': Element({'path': '.*'}, children='(profiles )+'),
    'profiles': Element(optional={'type': '.*'}, children='(profile )+(metadata )?'),
    'profile': Element({'ns': '.*', 'node': '.*'}, children='(topics |services |actions )*'),
    'topics': Element(optional={'publish': RULE, 'subscribe': RULE}, children='(topic )+'),
    'services': Element(optional={'reply': RULE, 'request': RULE}, children='(service )+'),
    'actions': Element(optional={'call': RULE, 'execute': RULE}, children='(action )+'),
    **dict.fromkeys(('topic', 'service', 'action'), Element(text=True))}


def faults(element: ElementTree.Element) -> Iterator[str]:
    """Yield what the schema does not allow in an element and below."""
    rule = SCHEMA[element.tag]
    for name, value in element.attrib.items():
        pattern = {**rule.required, **rule.optional}.get(name)
        if pattern is None or not re.fullmatch(pattern, value):
            yield f'{element.tag}: attribute {name}="{value}"'
    for name in rule.required.keys() - element.attrib.keys():
        yield f'{element.tag}: no attribute {name}'
    if not re.fullmatch(rule.children, ''.join(f'{child.tag} ' for child in element)):
        yield f'{element.tag}: children {[child.tag for child in element]}'
    if (element.text or '').strip() and not rule.text:
        yield f'{element.tag}: text {element.text}'
    for child in element:
        if child.tag in SCHEMA:
            yield from faults(child)  # metadata may hold anything
        elif child.tag != 'metadata':
            yield f'{child.tag}: no such element'


def test_structure_is_that_of_the_schema(case: Case) -> None:
    assert case.policy.tag == 'policy'
    assert list(faults(case.policy)) == []
    (enclave,) = case.policy.iter('enclave')
    assert enclave.get('path') == f'{case.monitor.get_namespace().rstrip("/")}/squeal_monitor'
    (profile,) = case.policy.iter('profile')
    assert profile.attrib == {'ns': case.monitor.get_namespace(), 'node': 'squeal_monitor'}


@pytest.mark.parametrize(('old', 'new'), [
    ('enclaves', 'contexts'), ('<enclave ', '<context '), ('version="0.2.0"', 'version="0.1.0"'),
    ('version="0.2.0"', ''), ('publish="ALLOW"', 'publish="YES"'), ('<topic>', '<service>'),
    ('<services reply="ALLOW">', '<services publish="ALLOW">'), (' node="squeal_monitor"', ''),
    ('<metadata>', '<topics/><metadata>'), ('path=', 'name=')])
def test_the_check_of_the_structure_finds_faults(old: str, new: str) -> None:
    text = SHIPPED.read_text(encoding='utf-8')
    assert old in text
    word, other = old.strip('<>= '), new.strip('<>= ')
    changed = text.replace(old, new)
    if word.isidentifier() and other.isidentifier():
        changed = changed.replace(f'</{word}>', f'</{other}>')
    assert list(faults(ElementTree.fromstring(changed)))


def test_shipped_policy_is_what_the_command_prints() -> None:
    done = subprocess.run([sys.executable, '-m', 'squeal_ros.cli', 'policy'], check=True,
                          capture_output=True, text=True)
    assert done.stdout == SHIPPED.read_text(encoding='utf-8')


@pytest.mark.parametrize('namespace', ['', 'car', '//', '/1', '/a b', '/a"b', '/a/b//'])
def test_bad_namespace_is_refused(namespace: str) -> None:
    with pytest.raises(ConfigurationError, match='namespace'):
        policy_document(SETTINGS, namespace)


def test_names_cannot_break_out_of_the_file() -> None:
    settings = read_settings({'left.pressure.topic': '</topic><topic>*', 'brakes': ['left']})
    policy = ElementTree.fromstring(policy_document(settings))
    topics = [item.text for item in policy.iter('topic')]
    assert '</topic><topic>*' in topics
    assert '*' not in topics

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

"""The SROS2 policy of the node for given settings: its permitted topics and services."""

from collections.abc import Iterable, Iterator
from itertools import groupby
import re
import textwrap
from xml.sax.saxutils import escape

from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.settings import MonitorSettings, NODE_NAME, settings_keys
from squeal_ros.node import messages, state_message
from squeal_ros.node.field_paths import Router

# of every rclpy node, and of every managed one
_TOPICS = ('/parameter_events', '/rosout', '~/transition_event')
_SERVICES = (
    'change_state', 'describe_parameters', 'get_available_states', 'get_available_transitions',
    'get_parameter_types', 'get_parameters', 'get_state', 'get_transition_graph',
    'get_type_description', 'list_parameters', 'set_parameters', 'set_parameters_atomically')
_PARAMETERS = ('start_type_description_service', 'use_sim_time')
_NAMESPACE = re.compile(r'/|(/[A-Za-z_][A-Za-z0-9_]*)+/?')
_WIDTH = 95


def policy_document(settings: MonitorSettings, namespace: str = '/') -> str:
    """
    Return a policy file (sros2's policy.xsd, version 0.2.0) that permits the node's work.

    Parameters
    ----------
    settings : MonitorSettings
        Of the monitor.
    namespace : str
        Of the node, absolute.

    Raises
    ------
    ConfigurationError
        For what is no absolute namespace.

    """
    if not _NAMESPACE.fullmatch(namespace):
        raise ConfigurationError('namespace', f'{namespace!r} is no absolute namespace',
                                 'write it as in /car or /fleet/car_1')
    namespace = namespace.rstrip('/')
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<!-- SROS2 policy of {NODE_NAME}, as `squeal policy` writes it; see '
        'docs/howto/security.md.',
        '     What is not listed is denied. The node requests no service. -->',
        '<policy version="0.2.0">', '  <enclaves>',
        f'    <enclave path="{namespace}/{NODE_NAME}">', '      <profiles>',
        f'        <profile ns="{namespace or "/"}" node="{NODE_NAME}">',
        *_block('topics publish', 'topic', _published(settings)),
        *_block('topics subscribe', 'topic', Router.of(settings).types),
        *_block('services reply', 'service', (f'~/{name}' for name in _SERVICES)),
        '        </profile>', '        <metadata>', *_parameters(settings), '        </metadata>',
        '      </profiles>', '    </enclave>', '  </enclaves>', '</policy>']
    return '\n'.join(lines) + '\n'


def _published(settings: MonitorSettings) -> Iterator[str]:
    yield from ('/diagnostics', f'~/{messages.EVENTS}', f'~/{messages.FRONT_SHARE}', *_TOPICS)
    # the state where squeal_msgs is installed
    outputs = [*messages.TYPES, *messages.ADVICE, state_message.NAME]
    if settings.mode_shapes:
        outputs.append('mode_shape')
    for brake in settings.brakes:
        yield from (f'~/{brake.name}/{name}' for name in outputs)


def _block(kind: str, item: str, names: Iterable[str]) -> list[str]:
    return [f'          <{kind}="ALLOW">',
            *(f'            <{item}>{escape(name)}</{item}>' for name in sorted(set(names))),
            f'          </{kind.partition(" ")[0]}>']


def _parameters(settings: MonitorSettings) -> Iterator[str]:
    """Parameters are beyond DDS permissions: listed for the reader, and for a test."""
    yield '          <!-- what the parameter services above give access to; and of each topic,'
    yield '               qos_overrides.TOPIC.{publisher|subscription}.POLICY -->'
    brakes = tuple(brake.name for brake in settings.brakes)
    names = sorted((*_PARAMETERS, *(key.name for key in settings_keys(brakes))), key=_place)
    for (_, group), members in groupby(names, _place):
        short = ' '.join(name.removeprefix(f'{group}.') for name in members)
        place = f' of="{group}"' if group else ''
        yield f'          <parameters{place}>'
        yield from textwrap.wrap(short, _WIDTH, initial_indent=' ' * 12,
                                 subsequent_indent=' ' * 12, break_on_hyphens=False)
        yield '          </parameters>'


def _place(name: str) -> tuple[int, str]:
    """Return the sorting key of a parameter: first those of the node, then those of each input."""
    group = name.rpartition('.')[0]
    return group.count('.') + bool(group), group

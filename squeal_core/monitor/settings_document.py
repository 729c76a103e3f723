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

"""The documented settings file: every key with meaning, unit, range and default."""

import json
import math
from typing import Any

from squeal_core.monitor.setting_specs import input_keys, MONITOR_KEYS, SettingSpec, SIGNALS
from squeal_core.monitor.settings import check_names

_HEADING = (
    '# Settings of the node squeal_monitor and of `squeal replay`: a ROS parameter file.',
    '# Each key: meaning [unit], range; default. Keys left out have their default.',
    '# Relative topics are taken in the namespace of the node.',
    '# Field paths: a.b   a[2]   velocity[name=front_left_wheel_joint], which looks the index up',
    '# in the list `name` of the message.',
    '# `squeal settings BRAKE ...` writes this file for brakes of your own.')


def settings_document(brakes: tuple[str, ...] = ()) -> str:
    """Return a ROS parameter file for these brakes (default: a car's four)."""
    default = MONITOR_KEYS[0].default
    assert isinstance(default, tuple)
    brakes = brakes or default
    check_names(brakes)
    lines = [*_HEADING, '/**:', '  ros__parameters:']
    for key in MONITOR_KEYS:
        value = list(brakes) if key.name == 'brakes' else key.default
        lines += _explained(key, '    ') + [f'    {key.name}: {json.dumps(value)}']
    for number, brake in enumerate(brakes):
        lines += ['', f'    # the inputs of {brake}' + (', keys as above' if number else ''),
                  f'    {brake}:']
        for signal in SIGNALS:
            lines.append(f'      {signal}:')
            for key in input_keys(brake, signal):
                note = [] if number else _explained(key, '        ')
                name = key.name.rpartition('.')[2]
                lines += [*note, f'        {name}: {json.dumps(key.default)}']
    return '\n'.join(lines) + '\n'


def _explained(key: SettingSpec, indent: str) -> list[str]:
    notes = [f'{key.meaning}{_unit(key)}{_range(key)};', f'default {_short(key.default)}']
    one = f'{indent}# {" ".join(notes)}'
    return [one] if len(one) <= 99 else [f'{indent}# {note}' for note in notes]


def _unit(key: SettingSpec) -> str:
    return f' [{key.unit}]' if isinstance(key.default, float) else ''


def _range(key: SettingSpec) -> str:
    if isinstance(key.default, bool):
        return ', true or false'
    if not isinstance(key.default, float):
        return ''
    if math.isinf(key.minimum):
        return ', any finite number'
    return f', {key.minimum:g} to {key.maximum:g}'


def _short(value: Any) -> str:
    return json.dumps(list(value) if isinstance(value, tuple) else value)

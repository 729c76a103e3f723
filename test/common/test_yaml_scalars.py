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

"""Plain scalars in our reader of YAML, against ROS's own reader of parameter files."""

import math
from pathlib import Path
from typing import Any

import pytest
from squeal_core.common.errors import ConfigurationError
from squeal_core.common.yaml_reader import read_yaml
from squeal_core.monitor.settings import load_settings

SCALARS = (
    '1e5 1.0e5 1e+5 1.e5 1E5 -1e-5 +1e5 .5 -.5 +.5 5. 0e0 -0 -0.0 0x0 0x0p4 .0e9 1.5e3 1. . '
    'e5 .e5 1.e 1e 1.0f +5 -5 017 08 0o17 0 00 -017 0x1F -0x1F 0X1f 0x 0x1p3 0x.8 0x1e5 0b11 '
    '1_000 1_000.5 1,5 190:20:30 190:20:30.15 2001-01-01 1e308 1e400 -1e400 1e-400 1e-310 '
    '0x1p9999 9223372036854775807 9223372036854775808 -9223372036854775808 '
    '-9223372036854775809 99999999999999999999 0xFFFFFFFFFFFFFFFFFF .inf -.inf +.inf .Inf '
    '.INF .iNF inf -inf INF infinity +Infinity .nan .NaN .NAN nan -nan NaN nano y Y n N yes '
    'Yes YES yEs no No NO on On ON off Off OFF true True TRUE tRUE false False FALSE "1e5" '
    '\'yes\' "" m 1m l0')


def same(ours: object, theirs: object) -> bool:
    if isinstance(ours, float) and math.isnan(ours):
        return isinstance(theirs, float) and math.isnan(theirs)
    return type(ours) is type(theirs) and repr(ours) == repr(theirs)


@pytest.mark.usefixtures('own_domain')
def test_scalars_of_parameter_files_are_read_as_by_the_node(tmp_path: Path) -> None:
    rclpy = pytest.importorskip('rclpy', reason='needs rclpy')
    path = tmp_path / 'x.yaml'
    path.write_text('/**:\n  ros__parameters:\n' + ''.join(
        f'    p{place}: {text}\n' for place, text in enumerate(SCALARS.split())))
    ours = read_yaml(path, ConfigurationError, ros=True)['/**']['ros__parameters']
    context = rclpy.Context()
    rclpy.init(args=['--ros-args', '--params-file', str(path)], context=context)
    try:
        node = rclpy.create_node('reader', context=context,
                                 automatically_declare_parameters_from_overrides=True)
        theirs = {name: node.get_parameter(name).value for name in ours}
        node.destroy_node()
    finally:
        context.try_shutdown()
    read = zip(SCALARS.split(), ours.values(), theirs.values(), strict=True)
    different = {text: (a, b) for text, a, b in read if not same(a, b)}
    assert not different


@pytest.mark.parametrize(('text', 'value'), [
    ('{a: 1e5}', {'a': 1e5}), ('[y, n, on]', ['y', 'n', True]), ('{a: 2001-01-01}',
                                                                 {'a': '2001-01-01'}),
    ('{1: 2, 1e2: 3}', {1: 2, 100.0: 3}), ('[~, null]', [None, None])])
def test_other_files_have_the_same_numbers(text: str, value: Any, tmp_path: Path) -> None:
    (tmp_path / 'x.yaml').write_text(text)
    assert read_yaml(tmp_path / 'x.yaml', ConfigurationError) == value


def test_keys_of_parameter_files_are_texts(tmp_path: Path) -> None:
    (tmp_path / 'x.yaml').write_text('{on: {y: y, 017: 017}}')
    assert read_yaml(tmp_path / 'x.yaml', ConfigurationError, ros=True) == {
        'on': {'y': True, '017': 15}}


def test_settings_take_a_scale_as_people_write_it(tmp_path: Path) -> None:
    (tmp_path / 'x.yaml').write_text(
        '/**: {ros__parameters: {brakes: [fl], fl: {pressure: {topic: p, scale: 1e5}}}}')
    (brake,) = load_settings(tmp_path / 'x.yaml').brakes
    assert (brake.name, brake.inputs['pressure'].scale) == ('fl', 1e5)


def test_what_is_tagged_as_a_number_and_is_none(tmp_path: Path) -> None:
    (tmp_path / 'x.yaml').write_text('a: !!float five')
    with pytest.raises(ConfigurationError, match="'five' in line 1 is no number"):
        read_yaml(tmp_path / 'x.yaml', ConfigurationError)

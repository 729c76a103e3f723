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

"""Parameter files of the monitor: nested keys, the shipped one, and wrong ones."""

from pathlib import Path

from squeal_core.monitor.settings import flatten, load_settings, read_settings
from support.rows import each
from support.setting_refusals import read, refusal


def test_flatten() -> None:
    assert flatten({}) == {}
    assert flatten({'a': {'b': {'c': 1}, 'd.e': [2]}, 'f': None, 'g': {}}) == {
        'a.b.c': 1, 'a.d.e': [2], 'f': None}


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding='utf-8')
    return path


@each('node', ['/**', 'squeal_monitor', '/squeal_monitor'])
@each('body', [
    '{brakes: [a], rate: 20, use_sim_time: true, a: {pressure: {topic: /p, max_age: 1}}}',
    '{brakes: [a], rate: 20.0, a.pressure.topic: /p, a.pressure: {max_age: 1.0}}'])
def test_load_a_parameter_file(tmp_path: Path, node: str, body: str) -> None:
    path = write(tmp_path / 'p.yaml', f'{node}:\n  ros__parameters: {body}\n')
    assert load_settings(path) == load_settings(str(path)) == read(
        rate=20.0, a__pressure__topic='/p', a__pressure__max_age=1.0)


def test_the_shipped_settings_are_the_defaults() -> None:
    shipped = Path(__file__).parents[2] / 'config' / 'monitor.yaml'
    assert load_settings(shipped) == read_settings({})


@each(('text', 'part'), [
    ('', 'has no ros__parameters'), ('- 1', 'has no ros__parameters'),
    ('rate: 10', 'has no ros__parameters'), ('/**: {rate: 10}', 'has no ros__parameters'),
    ('/**: {ros__parameters: [1]}', 'has no ros__parameters'), ('a: [', 'is not YAML'),
    ('a: \x00', 'is not YAML'), ('!!python/object/apply:os.getcwd []', 'is not YAML'),
    ('/**: {ros__parameters: {rate: fast}}', "rate: is 'fast'"),
    ('/**: {ros__parameters: {rate: }}', 'rate: is None'),
    ('/**: {ros__parameters: {rats: 1}}', 'rats: unknown key'),
    ('a: !!timestamp 2024-13-45', 'is not YAML'), ('a: !!int x', 'is not YAML'),
    ('a: !!bool x', 'is not YAML'), ('[' * 5000, 'is not YAML'),
    ('/**: {ros__parameters: &x {rate: 9}}\n/a: *x', 'is not YAML this can read (an alias (*)'),
    ('/**: {ros__parameters: {rate: 9, rate: 9}}', "'rate' twice in the mapping at line 1"),
    ('/**:\n  ros__parameters:\n    rate: 9\n  ros__parameters:', "'ros__parameters' twice in"),
    ('- ' * 100, 'more than 20000 keys and values, or nested more than 30 deep, in line 1'),
    ('\n'.join(f'a{i}: 1' for i in range(60000)), 'more than 20000 keys'),
    ('a: ' + ':'.join(['1'] * 6000), 'a text of 11999 characters'),
    ('a: ' + 'x' * 10**6, 'has 1000003 bytes, more than the 1000000')])
def test_wrong_parameter_files(tmp_path: Path, text: str, part: str) -> None:
    assert part in refusal(write(tmp_path / 'p.yaml', text), load_settings)


def test_files_that_hold_no_text(tmp_path: Path) -> None:
    assert 'is a folder, no regular file' in refusal(tmp_path, load_settings)
    assert 'none.yaml: cannot be read' in refusal(tmp_path / 'none.yaml', load_settings)
    (tmp_path / 'binary.yaml').write_bytes(b'\xff\xfe\x9d')
    assert 'binary.yaml: is not YAML' in refusal(tmp_path / 'binary.yaml', load_settings)


@each('text', [
    '/camera: {ros__parameters: {fps: 30}}\n/**: {ros__parameters: {rate: 20}}',
    '/car: {squeal_monitor: {ros__parameters: {rate: 20}}}',
    '/**: {ros__parameters: {rate: 20, start_type_description_service: false}}'])
def test_files_that_ros_accepts(tmp_path: Path, text: str) -> None:
    assert load_settings(write(tmp_path / 'p.yaml', text)).rate == 20.0

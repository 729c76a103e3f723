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

"""Files that are no brake description: not YAML, too large, unreadable, hostile."""

from pathlib import Path

from squeal_core.brake.brake_yaml import read_brake
from squeal_core.brake.dimensions import Brake
from support.brake_descriptions import check, refusal, SHIPPED
from support.rows import each


@each(('text', 'part'), [
    ('', 'is None; write a mapping'), ('- 1', 'is [1]; write a mapping'), ('3', 'is 3; write'),
    ('a: [', 'is not YAML'), ('a: b: c', 'is not YAML'), ('a: \x00', 'is not YAML'),
    ('a: 1\n---\nb: 2', 'is not YAML'), ('? [1]\n: 2', 'is not YAML'), ('<<: 3', 'is not YAML'),
    *((f'name: {value}', 'is not YAML') for value in (
        '!!int x', '!!bool x', '!!timestamp x')),
    *((t, 'is not YAML') for t in (f'name: {"1" * 5000}', '[' * 5000)),
    ('a: &x [1]\nb: *x', 'an alias (*) in line 2'), ('a: *x', 'an alias (*) in line 1'),
    ('name: a\n"name": b', "'name' twice in the mapping at line 1"),
    ('a: 1\nb:\n  c: [{3: 1, 3: 1}]', "'3' twice in the mapping at line 3")])
def test_wrong_file(tmp_path: Path, text: str, part: str) -> None:
    bad = tmp_path / 'bad.yaml'
    bad.write_text(text, encoding='utf-8')
    check(refusal(bad, read_brake), 'bad.yaml: ', part)


def test_one_key_or_byte_too_many(tmp_path: Path, brake: Brake) -> None:
    bad = tmp_path / 'bad.yaml'
    for text, part in ((b'name: b\n', ": is not YAML this can read ('name' twice in the mapping"),
                       (b'"a\\nb": 1\n', '.a b: unknown key (value 1); remove')):
        bad.write_bytes(text + SHIPPED.read_bytes())
        check(refusal(bad, read_brake), f'bad.yaml{part}')
    bad.write_bytes(SHIPPED.read_bytes().ljust(10**6, b'#'))
    assert read_brake(bad) == brake
    bad.write_bytes(SHIPPED.read_bytes().ljust(10**6 + 1, b'#'))
    check(refusal(bad, read_brake), 'more than the 1000000 that are read')


def test_files_that_hold_no_text(tmp_path: Path) -> None:
    (tmp_path / 'bad.yaml').write_bytes(b'\xff\xfe\x00\x9d')
    check(refusal(tmp_path / 'bad.yaml', read_brake), 'bad.yaml: is not YAML', 'mend it')
    check(refusal(tmp_path / 'none.yaml', read_brake), 'none.yaml: cannot', 'check the path')
    check(refusal(tmp_path, read_brake), str(tmp_path), 'is a folder', 'give the path')


@each('tag', ['python/object/apply:os.mkdir', 'python/object/new:os.mkdir'])
def test_tags_are_not_executed(tmp_path: Path, tag: str) -> None:
    bad, trap = tmp_path / 'bad.yaml', tmp_path / 'executed'
    bad.write_text(f'name: !!{tag} [{trap}]')
    check(refusal(bad, read_brake), 'is not YAML', tag)
    assert not trap.exists()

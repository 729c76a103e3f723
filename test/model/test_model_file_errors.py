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

"""Model files that were damaged, or hold anything else, are refused in one line."""

import io
import math
from pathlib import Path
import pickle
import re
import sys
import tracemalloc
from typing import Any
import zipfile

from hypothesis import given, HealthCheck, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core.common.errors import ModelFileError
from squeal_core.model.brake_model import BrakeModel
from support.archives import parts, rewrite
from support.model_files import content, SMALL
from support.processes import short_and_long

NAN = math.nan


def refusal(path: Path | str) -> str:
    with pytest.raises(ModelFileError) as caught:
        BrakeModel.load(path)
    assert re.fullmatch(f'{re.escape(str(path))}: .+; .+', str(caught.value))  # . is no newline
    return str(caught.value)


def npy(shape: str, data: bytes, kind: str = '<f8') -> bytes:
    """Return a .npy file that declares a shape, whatever its data are."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}}}".ljust(117) + '\n'
    return b'\x93NUMPY\x01\x00\x76\x00' + text.encode() + data


@pytest.mark.parametrize('data', [
    b'', b'a brake\n', bytes(5000), pickle.dumps({'a': 1}), npy('(2,)', data=bytes(16))])
def test_what_is_no_model_file(tmp_path: Path, data: bytes) -> None:
    (tmp_path / 'model.npz').write_bytes(data)
    assert 'damaged or no model file' in refusal(tmp_path / 'model.npz')


def test_a_brake_description(tmp_path: Path) -> None:
    (tmp_path / 'mine.yaml').write_text('name: mine')
    assert 'squeal build' in refusal(tmp_path / 'mine.yaml')


@pytest.mark.parametrize('name', ['kang2010', 'none/such', '/no.npz'])
def test_no_such_file(name: str) -> None:
    assert 'does not exist; give the path of a model file or the name' in refusal(name)


def test_a_name_no_file_can_have() -> None:
    assert refusal('x' * 300).endswith(': cannot be read (File name too long); check path and '
                                       'rights')


def test_a_folder_and_an_archive_of_something_else(tmp_path: Path) -> None:
    assert 'is a folder, no regular file' in refusal(tmp_path)
    np.savez(tmp_path / 'other.npz', a=np.ones(3))
    assert 'has no header' in refusal(tmp_path / 'other.npz')


def test_truncated_at_any_length(path: Path, tmp_path: Path) -> None:
    data = path.read_bytes()
    for length in (*range(0, len(data), 7), len(data) - 1):
        (tmp_path / 'cut.npz').write_bytes(data[:length])
        refusal(tmp_path / 'cut.npz')


def refused_or_same(path: Path, data: bytes, original: Any) -> None:
    path = path.with_name('changed.npz')
    path.write_bytes(data)
    try:
        assert content(BrakeModel.load(path)) == original
    except ModelFileError:
        refusal(path)


@short_and_long('stride', 6, 1)
@pytest.mark.parametrize('flip', [0x01, 0x80, 0xff])
def test_any_byte_flipped(path: Path, flip: int, stride: int) -> None:
    """One byte at a time: each in the long form, each sixth by chance in the short one."""
    data, original = path.read_bytes(), content(BrakeModel.load(path))
    for at in np.random.default_rng(flip).permutation(len(data))[::stride].tolist():
        refused_or_same(path, data[:at] + bytes([data[at] ^ flip]) + data[at + 1:], original)


@settings(max_examples=100, deadline=None,
          suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(0, 40), st.binary(max_size=40)),
                min_size=1, max_size=5))
def test_any_splices(path: Path, splices: list[tuple[float, int, bytes]]) -> None:
    data = path.read_bytes()
    for where, removed, added in splices:
        at = int(where * len(data))
        data = data[:at] + added + data[at + removed:]
    refused_or_same(path, data, content(BrakeModel.load(path)))


@pytest.mark.parametrize(('header', 'arrays'), [
    ({'contact_area': 1.0}, {}), ({'caliper': {'piston_area': 2.5e-3, 'efficiency': 0.8}}, {}),
    ({'names': ['a', 'b', 'c']}, {}), ({'hash': '0' * 64}, {}), ({}, {'follower': SMALL}),
    ({}, {'friction_couple': np.nextafter(SMALL, 9.0)})])
def test_contents_that_do_not_match_the_hash(path: Path, header: Any, arrays: Any) -> None:
    rewrite(path, header, arrays, with_right_hash=False)
    assert 'do not match its hash' in refusal(path)


@pytest.mark.parametrize('schema', [
    4, 10**30, 0, -1, '1', None, 1.0, False, True, [1]])
def test_other_schemas(path: Path, schema: Any) -> None:
    assert f'version (format {schema!r}; this one' in refusal(rewrite(path, {'schema': schema}))


@pytest.mark.parametrize(('header', 'part'), [
    ('{', 'damaged'), ('a brake', 'damaged'), ('[' * 10**5, 'damaged'),
    ('[1]', 'is no model file'), ('3', 'is no model file'), ('{}', 'is no model file'),
    ('{"format": "zip"}', 'is no model file'),
    ('{"format": "squeal_ros brake model"}', '(format None'),
    ('{"format": "squeal_ros brake model", "schema": 1}', 'has no hash')])
def test_headers_that_say_nothing(path: Path, header: str, part: str) -> None:
    np.savez(path, header=np.array(header), **parts(path)[1])
    assert part in refusal(path)


@pytest.mark.parametrize(('key', 'value'), [
    *((key, value) for key in ('contact_area', 'contact_radius', 'nominal_contact_stiffness')
      for value in (NAN, math.inf, 0.0, -1.0, '1', None, [1.0])),
    *(('caliper', value) for value in ([1], 'x', 3, {'piston_area': 1.0, 'x': 1})),
    *(('friction_law', value) for value in ([1], 'x', {'x': 1})), ('names', ['a']), ('names', 3),
    ('provenance', None), ('provenance', 3), ('friction_table', {'temperature': [1]}),
    ('friction_table', {'temperature': [300, 200], 'friction': [0.4, 0.5]}),
    ('caliper', {'piston_area': -1.0}), ('caliper', {'piston_area': NAN}),
    ('caliper', {'piston_area': 'x'}), ('caliper', {'a\nb': 1}),
    pytest.param('contact_area', 10**400, id='integer'),
    ('friction_law', {'static': 'x'}), ('friction_law', {'decay': NAN}),
    ('friction_table', {'temperature': [NAN, 1], 'friction': [0.4, 0.5]}),
    ('friction_table', {'temperature': ['a', 1], 'friction': [0.4, 0.5]}),
    ('names', [1, 2, 3]), ('names', 'abc'), ('stiffness_table', 3),
    ('stiffness_table', {'pressure': [2.0, 1.0], 'stiffness': [1e10, 1e10]}),
    ('stiffness_table', {'pressure': [1.0], 'stiffness': [NAN]})])
def test_wrong_header_values_with_a_right_hash(path: Path, key: str, value: Any) -> None:
    assert 'holds no usable model' in refusal(rewrite(path, {key: value}))


@pytest.mark.parametrize(('name', 'array'), [
    *((name, np.full(shape, wrong)) for wrong in (NAN, -np.inf) for name, shape in (
        ('angular_frequencies', 3), ('damping_ratios', 3), ('contact_stiffness', (3, 3)))),
    ('angular_frequencies', np.ones((3, 1))), ('angular_frequencies', np.ones(())),
    ('angular_frequencies', np.ones(0)), ('angular_frequencies', -np.ones(3)),
    ('damping_ratios', np.ones(2)), ('friction_couple', np.ones((2, 2))), ('follower', np.ones(9)),
    ('gyroscopic', SMALL), ('contact_stiffness', SMALL), ('negative_slope', np.ones((1, 3, 3)))])
def test_wrong_arrays_with_a_right_hash(path: Path, name: str, array: Any) -> None:
    assert f'holds no usable model ({name}' in refusal(rewrite(path, arrays={name: array}))


@pytest.mark.parametrize('array', [
    np.array([object()] * 3), np.array(['a', 'b', 'c']), np.zeros(3, 'V8'), np.array([1j, 2, 3]),
    np.ones(3, 'f4'), np.ones(3, 'f2'), np.ones(3, int), np.ones(3, bool)],
    ids=lambda array: array.dtype.name)
def test_arrays_of_something_else(path: Path, array: Any) -> None:
    rewrite(path, arrays={'angular_frequencies': array}, with_right_hash=False)
    assert f'angular_frequencies is an array (3,) of {array.dtype} and 0.0 MB' in refusal(path)


class Trap:

    def __reduce__(self) -> Any:
        return sys.exit, ('a pickle was executed',)


@pytest.mark.parametrize('name', ['header', 'follower'])
def test_pickles_inside_are_not_executed(path: Path, name: str) -> None:
    file = io.BytesIO()
    np.save(file, np.array([Trap()], dtype=object))
    replace_member(path, f'{name}.npy', file.getvalue())
    assert f'{name} is an array (1,) of object and 0.0 MB, which no' in refusal(path)


def replace_member(path: Path, name: str, data: bytes) -> None:
    with zipfile.ZipFile(path) as old:
        members = {**{item: old.read(item) for item in old.namelist()}, name: data}
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED) as new:
        for item, value in members.items():
            new.writestr(item, value)


@pytest.mark.parametrize(('name', 'kind', 'size'), [
    ('follower', '<f8', 288_000_000), ('follower', '<f8', 8), ('header', '<f8', 8),
    ('header', '<U2', 288_000_000), ('header', '<U2', 8)])
def test_a_bomb_is_refused_before_allocation(path: Path, name: str, kind: str, size: int) -> None:
    replace_member(path, f'{name}.npy', npy('(6000, 6000)', data=bytes(size), kind=kind))
    tracemalloc.start()
    text = refusal(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert f'{name} is an array (6000, 6000) of {np.dtype(kind)} and 288.0 MB' in text
    assert peak < 10**6

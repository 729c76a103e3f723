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

"""The table file: what was written comes back, and damaged files are refused in one line."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
import pickle
import re
from typing import Any
import zipfile

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.errors import TableFileError
from squeal_core.common.output import OutputError
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_file import model_hash, read_table, read_table_header, write_table
from support.archives import parts, rewrite
from support.engine_models import random_model

MODEL = random_model(5, seed=6, friction_law=FrictionLaw())
DOMAIN = TableDomain.usual(MODEL, rotor_speed=(8.0, 12.0), preload=(1000.0, 1400.0),
                           friction=(0.3, 0.4))
TABLE = build_table(MODEL, DOMAIN)


def refusal(path: Path, model: BrakeModel = MODEL) -> str:
    with pytest.raises(TableFileError) as caught:
        read_table(path, model)
    assert re.fullmatch(f'{re.escape(str(path))}: .+; .+', str(caught.value))  # . is no newline
    return str(caught.value)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    write_table(TABLE, MODEL, tmp_path / 'table.npz')
    return tmp_path / 'table.npz'


def same(ours: ExpansionTable, theirs: ExpansionTable) -> bool:
    """Whether two tables give the same numbers, bit for bit, inside and outside."""
    places = DOMAIN.low + DOMAIN.width * np.random.default_rng(0).uniform(-0.1, 1.1, (40, 3))
    first, second = (table.evaluate(places, Tolerances.of(MODEL)) for table in (ours, theirs))
    return all(np.array_equal(getattr(first, name), getattr(second, name), equal_nan=True)
               for name in ('eigenvalues', 'errors', 'numbers', 'cells', 'omitted_below'))


# ---------------------------------------------------------------- what comes back

def test_a_table_comes_back_bit_for_bit(path: Path) -> None:
    read = read_table(path, MODEL)
    assert same(TABLE, read)
    assert (read.domain, read.tolerances, dict(read.about)) == (
        TABLE.domain, TABLE.tolerances, dict(TABLE.about))
    assert not read.cells[0].series.flags.writeable
    assert [file.name for file in path.parent.iterdir()] == ['table.npz']


def test_header(path: Path) -> None:
    header = read_table_header(path)
    assert (header['schema'], header['degree']) == (5, 4)
    assert header['about'] == dict(TABLE.about)
    assert header['model'] == model_hash(MODEL)


def test_only_what_eigenvalues_depend_on_makes_another_model(path: Path) -> None:
    renamed = replace(MODEL, provenance={'brake': 'b'}, names=tuple('abcde'))
    assert same(read_table(path, renamed), TABLE)
    for changes in ({'damping_ratios': 0.003}, {'gyroscopic': None}, {'friction_law': None},
                    {'contact_stiffness': MODEL.contact_stiffness * (1.0 + 1e-15)}):
        other = replace(MODEL, **changes)  # type: ignore[arg-type]
        assert 'is the table of another model' in refusal(path, other)


# ---------------------------------------------------------------- what is refused

@pytest.mark.parametrize('data', [b'', b'a table\n', bytes(5000), pickle.dumps({'a': 1})])
def test_what_is_no_table(tmp_path: Path, data: bytes) -> None:
    (tmp_path / 'table.npz').write_bytes(data)
    assert 'damaged or no table file' in refusal(tmp_path / 'table.npz')


def test_no_such_file(tmp_path: Path) -> None:
    assert 'does not exist' in refusal(tmp_path / 'none.npz')
    assert 'is a folder, no regular file' in refusal(tmp_path)
    np.savez(tmp_path / 'other.npz', a=np.ones(3))
    assert 'has no header' in refusal(tmp_path / 'other.npz')
    MODEL.save(tmp_path / 'model.npz')
    assert 'is no table file' in refusal(tmp_path / 'model.npz')


def test_truncated_at_any_length(path: Path) -> None:
    data = path.read_bytes()
    for length in (*range(0, len(data), 101), len(data) - 1):
        path.write_bytes(data[:length])
        refusal(path)


def test_any_byte_flipped(path: Path) -> None:
    data = path.read_bytes()
    for at in range(0, len(data), 23):
        path.write_bytes(data[:at] + bytes([data[at] ^ 0x55]) + data[at + 1:])
        try:
            assert same(TABLE, read_table(path, MODEL))
        except TableFileError:
            refusal(path)


@pytest.mark.parametrize(('header', 'arrays'), [
    ({'about': {}}, {}), ({'degree': 3}, {}), ({'hash': '0' * 64}, {}),
    ({}, {'series': np.ones(3, np.float32)})])
def test_contents_that_do_not_match_the_hash(path: Path, header: Any, arrays: Any) -> None:
    rewrite(path, header, arrays, with_right_hash=False)
    assert 'do not match its hash' in refusal(path)


@pytest.mark.parametrize('schema', [6, 4, 1, 0, -1, '5', None, 5.0, True])
def test_other_schemas(path: Path, schema: Any) -> None:
    assert f'version (format {schema!r}; this one' in refusal(rewrite(path, {'schema': schema}))


def _first_of(name: str, value: float) -> Callable[[dict[str, Any]], dict[str, Any]]:
    def changed(arrays: dict[str, Any]) -> dict[str, Any]:
        array = arrays[name].copy()
        array.flat[0] = value
        return {name: array}
    return changed


def _shorter(name: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    return lambda arrays: {name: arrays[name][:-1]}


@pytest.mark.parametrize('change', [
    *(pytest.param(_shorter(name), id=f'{name} shorter') for name in (
        'sizes', 'series', 'bounds', 'mirrored', 'omitted')),
    *(pytest.param(_first_of(name, value), id=f'{name} {value}') for name, value in (
        ('grid', 10**6), ('grid', -2), ('halves', 0.0), ('halves', np.nan), ('blocks', -1),
        ('blocks', 2**31 - 1), ('sizes', 0), ('sizes', 200), ('series', np.nan),
        ('bounds', np.inf), ('omitted_modes', -1), ('omitted_modes', 10**6)))])
def test_arrays_that_make_no_table_with_a_right_hash(path: Path, change: Any) -> None:
    assert 'holds no usable table' in refusal(rewrite(path, arrays=change(parts(path)[1])))


@pytest.mark.parametrize('header', [
    {'degree': 3}, {'degree': None}, {'domain': None}, {'domain': {}}, {'tolerances': {}},
    {'domain': {'rotor_speed': [2.0, 1.0]}}, {'about': 1},
    {'tolerances': {'growth': {}, 'decay': 0.02, 'matters': -5.0, 'band': [1250.0, 16000.0]}},
    {'tolerances': {'growth': 0.1, 'decay': 0.02, 'matters': -5.0, 'band': [9.0, 'x']}}])
def test_headers_that_make_no_table_with_a_right_hash(path: Path, header: Any) -> None:
    assert 'holds no usable table' in refusal(rewrite(path, header))


@pytest.mark.parametrize('name', ['header', 'series', 'grid'])
def test_a_missing_array(path: Path, name: str) -> None:
    with zipfile.ZipFile(path) as old:
        members = {item: old.read(item) for item in old.namelist() if item != f'{name}.npy'}
    with zipfile.ZipFile(path, 'w') as new:
        for item, value in members.items():
            new.writestr(item, value)
    assert f'has no {name}, so it is no table file' in refusal(path)


def test_what_cannot_be_written(tmp_path: Path) -> None:
    for path, words in ((tmp_path / 'none' / 'table.npz', 'does not exist'),
                        (tmp_path, 'is a folder')):
        with pytest.raises(OutputError, match=words):
            write_table(TABLE, MODEL, path)
    assert not list(tmp_path.iterdir())

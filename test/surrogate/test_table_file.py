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

"""Table files: anchors come back bit for bit; what was damaged is refused in one line."""

from collections.abc import Callable
from dataclasses import replace
import io
import json
from pathlib import Path
import pickle
import re
import sys
import tracemalloc
from typing import Any
import zipfile

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.errors import TableFileError
from squeal_core.common.npz_archive import content_hash
from squeal_core.common.output import OutputError
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.table_file import model_hash, read_table, read_table_header, write_table
from squeal_core.surrogate.tabulated_solver import TabulatedSolver
from support.engine_models import near, point, random_model

MODEL = random_model(5, seed=6)
ANCHORS = tuple(expand_spectrum(MODEL, point(rotor_speed=speed)) for speed in (5.0, 20.0, 80.0))


def refusal(path: Path, model: BrakeModel = MODEL) -> str:
    with pytest.raises(TableFileError) as caught:
        read_table(path, model)
    assert re.fullmatch(f'{re.escape(str(path))}: .+; .+', str(caught.value))  # . is no newline
    return str(caught.value)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    write_table(ANCHORS, MODEL, tmp_path / 'table.npz', about={'made': 'here'})
    return tmp_path / 'table.npz'


def parts(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    with np.load(path) as file:
        return json.loads(str(file['header'])), {k: file[k] for k in file.files if k != 'header'}


def rewrite(path: Path, header: Any = None, arrays: Any = None, *,
            with_right_hash: bool = True) -> Path:
    old, kept = parts(path)
    header, arrays = {**old, **(header or {})}, {**kept, **(arrays or {})}
    if with_right_hash:
        header['hash'] = content_hash(header, arrays)
    np.savez(path, header=np.array(json.dumps(header)), **arrays)
    return path


def same(ours: SpectralExpansion, theirs: SpectralExpansion) -> bool:
    """Whether two anchors give the same numbers, bit for bit, near and far."""
    generator = np.random.default_rng(0)
    points = [near(ours.point, step, generator) for step in (0.0, 1e-3, 0.03, 0.3, 2.0)]
    every = np.transpose([at.coefficients() for at in points])
    found = [[values for some in (every, every[:, 1:2], every[:, 2:3])
              for values in anchor.eigenvalues(some)] for anchor in (ours, theirs)]
    return ours.point == theirs.point and np.array_equal(ours.mirrored, theirs.mirrored) and all(
        np.array_equal(a, b) for a, b in zip(*found, strict=True)) and np.array_equal(
            ours.trust_radius, theirs.trust_radius)


# ---------------------------------------------------------------- what comes back

def test_anchors_come_back_bit_for_bit(path: Path) -> None:
    read = read_table(path, MODEL)
    assert len(read) == 3
    for ours, theirs in zip(ANCHORS, read, strict=True):
        assert same(ours, theirs)
        assert not theirs.series.flags.writeable
    assert [file.name for file in path.parent.iterdir()] == ['table.npz']


@pytest.mark.parametrize('degree', [3, 4])
@pytest.mark.parametrize('changes', [
    {}, {'gyroscopic': None, 'negative_slope': None}, {'follower': 1e-6 * np.ones((5, 5))},
    {'contact_stiffness': None, 'friction_couple': None, 'gyroscopic': None,
     'radial_dissipation': None, 'negative_slope': None}])
def test_of_any_model_and_degree(tmp_path: Path, degree: int, changes: dict[str, Any]) -> None:
    model = random_model(5, seed=7, **changes)
    anchors = [expand_spectrum(model, point(), degree=degree),
               expand_spectrum(model, point(rotor_speed=2.0), degree=degree)]
    write_table(anchors, model, tmp_path / 'table.npz')
    assert all(map(same, anchors, read_table(tmp_path / 'table.npz', model)))


def test_a_table_starts_warm_where_it_was_left(kang: BrakeModel, tmp_path: Path) -> None:
    cold = TabulatedSolver(kang, anchors=[expand_spectrum(kang, kang.operating_point(
        rotor_speed=10.5, pressure=8e5))])
    points = [kang.operating_point(rotor_speed=speed, pressure=8e5) for speed in (10.0, 11.0)]
    before = [cold.complex_modes(at) for at in points]
    write_table(cold.anchors, kang, tmp_path / 'table.npz')
    warm = TabulatedSolver(kang, anchors=read_table(tmp_path / 'table.npz', kang))
    for at, found in zip(points, before, strict=True):
        assert np.array_equal(warm.complex_modes(at).eigenvalues, found.eigenvalues)
    assert warm.statistics.tabulated == 2
    # what an anchor of 92 modes takes: 70 kB, less than half of it in memory
    size = (tmp_path / 'table.npz').stat().st_size / len(cold.anchors)
    assert size < 0.6 * cold.nbytes / len(cold.anchors)
    assert size < 120e3


def test_series_that_are_no_single_precision_are_kept_whole(tmp_path: Path) -> None:
    finer = replace(ANCHORS[0], series=ANCHORS[0].series * (1.0 + 1e-12))
    write_table([ANCHORS[1], finer], MODEL, tmp_path / 'table.npz')
    read = read_table(tmp_path / 'table.npz', MODEL)
    assert np.array_equal(read[1].series, finer.series)
    assert np.array_equal(read[0].series, ANCHORS[1].series)


def test_header(path: Path) -> None:
    header = read_table_header(path)
    assert (header['schema'], header['anchors'], header['degree']) == (3, 3, 3)
    assert header['about'] == {'made': 'here'}
    assert header['model'] == model_hash(MODEL)


def test_only_what_roots_depend_on_makes_another_model(path: Path) -> None:
    renamed = replace(MODEL, provenance={'brake': 'b'}, names=tuple('abcde'), contact_area=1.0)
    assert len(read_table(path, renamed)) == 3
    for changes in ({'damping_ratios': 0.003}, {'gyroscopic': None},
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
            assert all(map(same, ANCHORS, read_table(path, MODEL)))
        except TableFileError:
            refusal(path)


@pytest.mark.parametrize(('header', 'arrays'), [
    ({'about': {}}, {}), ({'degree': 4}, {}), ({'hash': '0' * 64}, {}),
    ({}, {'scales': np.ones(15)})])
def test_contents_that_do_not_match_the_hash(path: Path, header: Any, arrays: Any) -> None:
    rewrite(path, header, arrays, with_right_hash=False)
    assert 'do not match its hash' in refusal(path)


@pytest.mark.parametrize('schema', [4, 2, 1, 0, -1, '2', None, 2.0, True])
def test_other_schemas(path: Path, schema: Any) -> None:
    assert f'has schema {schema!r}; this version' in refusal(rewrite(path, {'schema': schema}))


def _first_of(name: str, value: float) -> Callable[[dict[str, Any]], dict[str, Any]]:
    def changed(arrays: dict[str, Any]) -> dict[str, Any]:
        array = arrays[name].copy()
        array[0] = value
        return {name: array}
    return changed


def _shorter(name: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    return lambda arrays: {name: arrays[name][:-1]}


@pytest.mark.parametrize('change', [
    *(pytest.param(_shorter(name), id=f'{name} shorter') for name in (
        'points', 'scales', 'blocks', 'sizes', 'first_terms', 'terms', 'nearness', 'rounding',
        'mirrored', 'pairs', 'rates', 'weights', 'order', 'owners')),
    *(pytest.param(_first_of(name, value), id=f'{name} {value}') for name, value in (
        ('points', 0.0), ('points', np.nan), ('scales', 0.0), ('scales', np.inf), ('blocks', -1),
        ('blocks', 2**31 - 1), ('sizes', 0), ('sizes', -3), ('sizes', 10**9), ('terms', np.nan),
        ('rounding', np.inf), ('mirrored', 0), ('pairs', -1), ('pairs', 10**9), ('rates', np.nan),
        ('order', -1), ('order', 10**6), ('owners', -1), ('owners', 10**6),
        ('weights', np.nan)))])
def test_arrays_that_make_no_anchors_with_a_right_hash(path: Path, change: Any) -> None:
    assert 'holds no usable anchors' in refusal(rewrite(path, arrays=change(parts(path)[1])))


@pytest.mark.parametrize('header', [
    {'anchors': 0}, {'anchors': 2}, {'anchors': 4}, {'anchors': '3'}, {'anchors': 10**12},
    {'degree': 4}, {'degree': 30}, {'degree': None}, {'degree': 3.0}, {'rows': [0, 1]},
    {'rows': None}, {'rows': [9] * 5}])
def test_headers_that_make_no_anchors_with_a_right_hash(path: Path, header: Any) -> None:
    assert 'holds no usable anchors' in refusal(rewrite(path, header))


@pytest.mark.parametrize('name', ['header', 'terms', 'order'])
def test_a_missing_array(path: Path, name: str) -> None:
    with zipfile.ZipFile(path) as old:
        members = {item: old.read(item) for item in old.namelist() if item != f'{name}.npy'}
    with zipfile.ZipFile(path, 'w') as new:
        for item, value in members.items():
            new.writestr(item, value)
    assert f'has no {name}, so it is no table file' in refusal(path)


class Trap:

    def __reduce__(self) -> Any:
        return sys.exit, ('a pickle was executed',)


def _member(path: Path, name: str, data: bytes) -> None:
    with zipfile.ZipFile(path) as old:
        members = {**{item: old.read(item) for item in old.namelist()}, f'{name}.npy': data}
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED) as new:
        for item, value in members.items():
            new.writestr(item, value)


@pytest.mark.parametrize('name', ['header', 'terms'])
def test_pickles_inside_are_not_executed(path: Path, name: str) -> None:
    file = io.BytesIO()
    np.save(file, np.array([Trap()], dtype=object))
    _member(path, name, file.getvalue())
    assert f'{name} is an array (1,) of object' in refusal(path)


@pytest.mark.parametrize(('name', 'kind', 'shape', 'data'), [
    ('terms', '<f4', '(200000000,)', b''), ('terms', '<f4', '(200000000,)', bytes(4000)),
    ('terms', '<f4', '(900000000,)', bytes(10**6)), ('terms', '<f8', '(2,)', bytes(16)),
    ('header', '<U200000000', '()', b'')])
def test_a_bomb_is_refused_before_allocation(path: Path, name: str, kind: str, shape: str,
                                             data: bytes) -> None:
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}}}".ljust(117) + '\n'
    _member(path, name, b'\x93NUMPY\x01\x00\x76\x00' + text.encode() + data)
    tracemalloc.start()
    refused = refusal(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert f'{name} is an array {shape} of' in refused
    assert peak < 3 * 10**6


def test_what_cannot_be_written(tmp_path: Path) -> None:
    fourth = expand_spectrum(MODEL, point(), degree=4)
    for anchors in ((), (ANCHORS[0], fourth)):
        with pytest.raises(TableFileError, match='cannot hold'):
            write_table(anchors, MODEL, tmp_path / 'table.npz')
    for path, words in ((tmp_path / 'none' / 'table.npz', 'does not exist'),
                        (tmp_path, 'is a folder')):
        with pytest.raises(OutputError, match=words):
            write_table(ANCHORS, MODEL, path)
    assert not list(tmp_path.iterdir())

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

"""Files of sweeps: what is saved comes back, what is damaged is refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core.common.output import OutputError
from squeal_core.studies.sweep import sweep
from squeal_core.studies.sweep_file import load_sweep, RECORDS, save_sweep, SweepFileError
from squeal_core.studies.sweep_record import make_sweep, Sweep
from support.sweeps import FRICTIONS, interrupted, PAIR, POINT, same


@pytest.fixture(scope='module', params=['whole', 'partial', 'grid'])
def record(request: pytest.FixtureRequest) -> Sweep:
    if request.param == 'grid':
        return sweep(PAIR, POINT, {'rotor_speed': [2.0, 8.0], 'friction': FRICTIONS})
    return interrupted(20 if request.param == 'whole' else 5, tracked=True)


@pytest.mark.parametrize('suffix', ['.npz', '.json', '.csv'])
def test_a_file_holds_the_record(suffix: str, record: Sweep, tmp_path: Path) -> None:
    path = tmp_path / f'sweep{suffix}'
    save_sweep(record, path)
    again = load_sweep(path)
    assert same(again, record)
    assert again.complete == record.complete
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    with pytest.raises(ValueError, match='read-only'):
        again.eigenvalues[0, 0] = 0.0


def test_files_are_plain(tmp_path: Path) -> None:
    record = interrupted(5)
    for suffix in ('.npz', '.json', '.csv'):
        save_sweep(record, tmp_path / f'a{suffix}')
    with np.load(tmp_path / 'a.npz', allow_pickle=False) as archive:
        assert archive['points'].shape == (20, 5)
    whole = json.loads((tmp_path / 'a.json').read_text(), parse_constant=pytest.fail)
    assert whole['schema'] == 1
    assert whole['growth_rates'][19] == [None, None]
    lines = (tmp_path / 'a.csv').read_text().splitlines()
    assert lines[0].startswith('# {"format": "squeal_ros sweep"')
    assert lines[1].split(',')[:2] == ['rotor_speed', 'friction']
    assert len(lines) == 2 + 20 * 2
    assert float(lines[2].split(',')[8]) == record.eigenvalues[0, 0].real


@pytest.mark.parametrize('suffix', ['.npz', '.json', '.csv'])
def test_damaged_files_are_refused_in_one_line(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f'sweep{suffix}'
    save_sweep(interrupted(20), path)
    whole = path.read_bytes()
    for content in (whole[:len(whole) // 2], b'', b'\x00\xff' * 40, b'[]', b'{}'):
        path.write_bytes(content)
        with pytest.raises(SweepFileError, match='is damaged or no sweep') as caught:
            load_sweep(path)
        assert str(path) in str(caught.value)
        assert '\n' not in str(caught.value)


@pytest.mark.parametrize(('changes', 'text'), [
    ({'schema': 2}, 'has schema 2; this version reads up to 1'), ({'schema': True}, 'schema True'),
    ({'format': 'other'}, 'no record of a sweep'), ({'kinds': [['odd', 'odd']] * 4}, 'kinds are'),
    ({'points': [[1.0] * 5] * 3}, '4 points by the axes'), ({'axes': {'mu': [1.0]}}, 'axes are'),
    ({'identities': [['1'] * 3] * 4}, '4 points by the axes'), ({'axes': None}, 'damaged')])
def test_contents_that_do_not_fit(changes: dict[str, Any], text: str, tmp_path: Path) -> None:
    path = tmp_path / 'sweep.json'
    save_sweep(sweep(PAIR, POINT, {'friction': FRICTIONS}), path)
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))
    with pytest.raises(SweepFileError, match=text):
        load_sweep(path)


def test_no_pickle_is_read(tmp_path: Path) -> None:
    path = tmp_path / 'sweep.npz'
    save_sweep(sweep(PAIR, POINT, {'friction': FRICTIONS}), path)
    with np.load(path) as archive:
        arrays = dict(archive)
    arrays['kinds'] = arrays['kinds'].astype(object)
    np.savez(path, **arrays)
    with pytest.raises(SweepFileError, match='array .* of object'):
        load_sweep(path)


def test_paths_that_cannot_be_meant(tmp_path: Path) -> None:
    record = sweep(PAIR, POINT, {'friction': FRICTIONS})
    with pytest.raises(SweepFileError, match='end it in .npz, .json or .csv'):
        save_sweep(record, tmp_path / 'sweep.pkl')
    with pytest.raises(SweepFileError, match=r'give a \.npz'):
        load_sweep(tmp_path / 'sweep')
    for suffix in RECORDS:
        with pytest.raises(OutputError, match='in a folder that does not exist'):
            save_sweep(record, tmp_path / 'no' / f'sweep{suffix}')
        save_sweep(record, tmp_path / f'sweep{suffix}', overwrite=False)
        with pytest.raises(OutputError, match='exists; give --force'):
            save_sweep(record, tmp_path / f'sweep{suffix}', overwrite=False)
        with pytest.raises(SweepFileError, match='does not exist|cannot be read'):
            load_sweep(tmp_path / f'none{suffix}')


def test_records_are_frozen() -> None:
    record = sweep(PAIR, POINT, {'friction': FRICTIONS})
    for array in (record.points, record.eigenvalues, record.kinds, record.axes['friction']):
        assert not array.flags.writeable
    with pytest.raises(ValueError, match='points by the axes'):
        make_sweep(axes=record.axes, points=record.points[:3], about={},
                   growth_rates=record.eigenvalues.real, kinds=record.kinds,
                   angular_frequencies=record.eigenvalues.imag, identities=record.identities)

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

"""The cache of modes of solids: what is in its keys, damaged entries, its folder."""

from pathlib import Path

import numpy as np
import pytest
import skfem
from squeal_core.brake.dimensions import Material
from squeal_core.common.resources import cache_folder
from squeal_core.modes.fe.meshes import sector_mesh
from squeal_core.modes.fe.solid import at_radius, free_modes, solid_modes, SolidModes
from support.solids import SECTOR, STEEL


def bar(cache: Path | None, told: list[str], material: Material = STEEL,
        count: int = 3) -> SolidModes:
    return solid_modes(sector_mesh(SECTOR, 0.0, 0.02, (2, 3, 1)), material, count,
                       clamped=at_radius(0.1), cache=cache, progress=told.append)


def test_solved_once(tmp_path: Path) -> None:
    told: list[str] = []
    first = bar(tmp_path / 'new', told)
    assert told[0] == f'assembling {first.basis.N} unknowns'
    assert 'factorising' in told
    told.clear()
    second = bar(tmp_path / 'new', told)
    assert told == []
    assert np.array_equal(first.shapes, second.shapes)
    assert np.array_equal(first.angular_frequencies, second.angular_frequencies)
    assert len(list((tmp_path / 'new').iterdir())) == 1


@pytest.mark.parametrize('change', ['material', 'count', 'mesh', 'held', 'element'])
def test_whatever_modes_depend_on_is_in_the_key(change: str, tmp_path: Path) -> None:
    def solve(*changes: str) -> None:
        mesh = sector_mesh(SECTOR, 0.0, 0.021 if 'mesh' in changes else 0.02, (2, 2, 1))
        solid_modes(mesh, Material(210e9, 7851.0, 0.3) if 'material' in changes else STEEL,
                    4 if 'count' in changes else 3, cache=tmp_path,
                    clamped=at_radius(0.142 if 'held' in changes else 0.1),
                    element=skfem.ElementHexS2() if 'element' in changes else None)

    solve()
    solve(change)
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize('damage', ['empty', 'cut', 'flipped', 'text', 'pickle', 'other', 'nan'])
def test_damaged_entries_are_written_anew(damage: str, tmp_path: Path) -> None:
    told: list[str] = []
    first = bar(tmp_path, told)
    entry, = tmp_path.iterdir()
    sound = entry.read_bytes()
    with np.load(entry) as found:
        parts = dict(found)
    if damage in ('empty', 'cut', 'text'):
        entry.write_bytes({'empty': b'', 'cut': sound[:len(sound) // 2], 'text': b'modes'}[damage])
    elif damage == 'flipped':
        middle = len(sound) // 2
        entry.write_bytes(sound[:middle] + bytes([sound[middle] ^ 1]) + sound[middle + 1:])
    else:
        parts |= {'pickle': {'shapes': np.array([{}], object)}, 'other': {'key': np.array('x')},
                  'nan': {'shapes': parts['shapes'] * np.nan}}[damage]
        np.savez(entry, **parts)
    told.clear()
    again = bar(tmp_path, told)
    assert 'factorising' in told
    assert np.array_equal(first.shapes, again.shapes)
    told.clear()
    bar(tmp_path, told)
    assert told == []
    assert list(tmp_path.iterdir()) == [entry]


def test_a_cache_that_cannot_be_written_costs_nothing_but_itself(tmp_path: Path) -> None:
    (tmp_path / 'file').write_text('')
    with pytest.warns(RuntimeWarning, match='modes are not cached'):
        assert bar(tmp_path / 'file' / 'folder', []).angular_frequencies.size == 3


def test_free_modes_are_cached_too(tmp_path: Path) -> None:
    basis = skfem.CellBasis(sector_mesh(SECTOR, 0.0, 0.02, (2, 3, 1)),
                            skfem.ElementVector(skfem.ElementHex2()), intorder=1)
    told: list[str] = []
    first = free_modes(basis, STEEL, 8, cache=tmp_path, progress=told.append)
    assert told
    told.clear()
    assert np.array_equal(first.shapes, free_modes(
        basis, STEEL, 8, cache=tmp_path, progress=told.append).shapes)
    assert not told


def test_where_the_cache_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    assert cache_folder() == tmp_path / 'squeal_ros'
    monkeypatch.delenv('XDG_CACHE_HOME')
    monkeypatch.setenv('HOME', str(tmp_path))
    assert cache_folder() == tmp_path / '.cache' / 'squeal_ros'

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

"""The planar-mesh method from irregular nodes, against harmonics on the same section."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from squeal_core.brake.dimensions import Brake
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.fe.axisymmetric import disc_modes, HarmonicModes
from squeal_core.modes.fe.meshes import pad_mesh
from squeal_core.modes.fe.solid import pad_modes, solid_modes, SolidModes
from squeal_core.modes.planar_mesh import contact_grid, PlanarGrid, PlanarModes

ROOT = Path(__file__).parents[2]
KEPT = 36  # lowest disc modes, where the irregular mesh is
SIZE = 0.012  # of the section's elements, for both the irregular mesh and the harmonics [m]


@pytest.fixture(scope='session')
def harmonics(brake: Brake) -> HarmonicModes:
    """Modes on a plain section of quadratic rectangles: no angular error, but corners'."""
    return disc_modes(brake.disc, KEPT, order=2, element_size=SIZE, corner_layers=0)


@pytest.fixture(scope='session')
def irregular(example: ModuleType, solved_once: None, brake: Brake,
              harmonics: HarmonicModes) -> SolidModes:
    """Return the section turned to 27-node hexahedra, nodes moved at random: takes seconds."""
    return example.irregular_disc(  # type: ignore[no-any-return]
        brake, len(harmonics.names), 56, irregularity=0.3, element_size=SIZE)


@pytest.fixture(scope='session')
def planar(irregular: SolidModes) -> PlanarModes:
    """All that is kept of it are nodes: no elements."""
    return PlanarModes.from_nodal(replace(irregular.nodal(), elements=()))


@pytest.fixture(scope='session')
def of_planar(example: ModuleType, brake: Brake, planar: PlanarModes,
              pad: SolidModes) -> dict[str, FloatArray]:
    return example.planar_arrays(brake, planar, pad)  # type: ignore[no-any-return]


@pytest.fixture(scope='session')
def of_harmonics(example: ModuleType, brake: Brake, harmonics: HarmonicModes,
                 pad: SolidModes) -> dict[str, FloatArray]:
    return example.exact_arrays(  # type: ignore[no-any-return]
        brake, harmonics, pad, panels=(9, 18))


# ---------------------------------------------------------------- modes and arrays

def test_irregular_mesh_has_the_harmonics_modes(
        example: ModuleType, brake: Brake, harmonics: HarmonicModes, irregular: SolidModes,
        planar: PlanarModes) -> None:
    off = irregular.angular_frequencies / harmonics.angular_frequencies - 1.0
    assert np.all(np.abs(off) < 5e-3)
    assert example.aligned_assurance(harmonics, irregular, brake).min() > 0.995
    assert example.aligned_assurance(harmonics, planar, brake).min() > 0.995


def test_nodes_say_what_elements_say(example: ModuleType, brake: Brake, irregular: SolidModes,
                                     pad: SolidModes, of_planar: dict[str, FloatArray]) -> None:
    """Default grid from 112 nodes round the disc, against integrals over the elements."""
    off = example.errors(of_planar, example.exact_arrays(brake, irregular, pad, panels=(9, 18)))
    assert max(off.values()) < 2e-3, off  # 0.5 % is promised; 0.11 % is what it measures


def test_pad_from_irregular_nodes(example: ModuleType, brake: Brake, disc: HarmonicModes,
                                  pad: SolidModes) -> None:
    """Its sector interpolated from nodes, over the very rim of the contact: within 0.5 %."""
    mesh = pad_mesh(brake.contact, 0.0, brake.pads[0].thickness, (6, 12, 2), irregularity=0.5)
    own = solid_modes(mesh, brake.pads[0].material, brake.pad_modes)
    nodes = PlanarModes.from_nodal(replace(own.nodal(), elements=()))
    low, half = replace(disc, section_modes=disc.section_modes[:2]), 0.5 * (
        brake.disc.rotor_thickness)
    points = [contact_grid(brake.contact, z) for z in (half, -half)]
    elements, found = (example.arrays(brake, low, modes, points, low.volume_layers())
                       for modes in (own, nodes))
    off = example.errors(found, elements)
    assert max(off.values()) < 2e-3, off
    assert own.angular_frequencies == pytest.approx(pad.angular_frequencies, rel=1e-2)


@pytest.mark.parametrize('rotor_speed', [5.0, 20.0])
def test_same_modes_are_unstable(
        rotor_speed: float, example: ModuleType, brake: Brake, harmonics: HarmonicModes,
        planar: PlanarModes, pad: SolidModes, of_planar: dict[str, FloatArray],
        of_harmonics: dict[str, FloatArray]) -> None:
    """Nodes of an irregular mesh alone give the brake that harmonics give."""
    wanted = example.unstable(brake, harmonics, pad, of_harmonics, rotor_speed)
    found = example.unstable(brake, planar, pad, of_planar, rotor_speed)
    assert len(found) == len(wanted) >= (1 if rotor_speed < 10.0 else 6)
    for one, other in zip(*(sorted(modes, key=lambda m: m.frequency_hz)
                            for modes in (found, wanted)), strict=True):
        assert one.frequency_hz == pytest.approx(other.frequency_hz, rel=5e-3)
        assert one.growth_rate == pytest.approx(other.growth_rate, abs=1.0)


# ---------------------------------------------------------------- document and example

@pytest.fixture
def small(example: ModuleType, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """Return the example on grids and meshes of no accuracy, with no more than a few modes."""
    ladder = (((3, 6), 4, 24, 1), ((4, 8), 4, 28, 1))
    monkeypatch.setattr(example, 'RULES', {
        name: (ladder, settings, order) for name, (_, settings, order) in example.RULES.items()})
    monkeypatch.setattr(example, 'STEPS', (24,))
    monkeypatch.setattr(example, 'MESHES', (6, 8))
    monkeypatch.setattr(example, 'GRID', PlanarGrid(radial=4, around=24, contact=(4, 8)))
    monkeypatch.setattr(example, 'disc_modes', partial(disc_modes, order=2, corner_layers=0))
    monkeypatch.setattr(example, 'pad_modes', partial(pad_modes, elements=(3, 6, 1)))
    monkeypatch.setattr(example, 'exact_arrays', partial(example.exact_arrays, panels=(3, 6)))
    plain = example.read_brake
    monkeypatch.setattr(example, 'read_brake', lambda path: replace(
        plain(path), disc_modes=5, pad_modes=8))
    return example


def test_document_runs(example: ModuleType, brake: Brake, tmp_path: Path,
                       monkeypatch: pytest.MonkeyPatch) -> None:
    """The lines that the manual shows, on a table of nodes of a small mesh."""
    nodal = example.irregular_disc(brake, 3, 10, element_size=0.03).nodal()
    rows = [['frequency_hz', *nodal.angular_frequencies / 2.0 / np.pi],
            ['node', 'x', 'y', 'z', *['ux', 'uy', 'uz'] * 3],
            *([i + 1, *1e3 * where, *nodal.shapes[:, i].ravel()]
              for i, where in enumerate(nodal.coordinates))]
    (tmp_path / 'disc.csv').write_text('\n'.join(','.join(map(str, row)) for row in rows))
    monkeypatch.chdir(tmp_path)
    text = (ROOT / 'docs' / 'explanation' / 'planar_mesh.md').read_text()
    names: dict[str, Any] = {}
    exec(text.split('```python\n')[1].split('```')[0], names)
    patch = names['patch']
    assert names['points'].weight.sum() == pytest.approx(patch.area)
    assert patch.area == pytest.approx(brake.contact.area, rel=1e-4)
    assert names['shapes'].normal.shape == (3, names['points'].radius.size)
    assert names['gyroscopic'] == pytest.approx(-names['gyroscopic'].T)
    assert [names[n].grid.rule for n in ('disc', 'between', 'printed')] == [
        'gauss', 'midpoint', 'nodes']


def test_example_runs(small: ModuleType, tmp_path: Path,
                      capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / 'picture.png'
    small.main(['--quick', str(picture)])
    printed = capsys.readouterr().out
    assert printed.count('| as printed |') == 2
    assert printed.count('| midpoint |') == printed.count('| Gauss |') == 2
    assert picture.read_bytes().startswith(b'\x89PNG')

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

"""Modal masses by integration, and the checks of normalisation and placing."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core.modes.fe.mass import modal_masses, reference_nodes
from squeal_core.modes.nodal_modes import ElementBlock, ModesError, NodalModes
from squeal_core.modes.readers import read_modes, ReaderError
from squeal_core.modes.readers.normalising import rigid_mass
from support.reader_samples import FRD, HERTZ, PAD, write_table

VOLUMES = {'tet4': 1 / 6, 'tet10': 1 / 6, 'hex8': 1.0, 'hex20': 1.0, 'hex27': 1.0, 'wedge6': 1 / 2,
           'wedge15': 1 / 2}
SKEW = np.array([[2.0, 0.1, 0.2], [0.3, 0.9, 0.3], [0.1, 0.5, 1.1]])


def one(kind: str, shapes: np.ndarray, where: np.ndarray) -> NodalModes:
    block = ElementBlock(kind, np.arange(len(where))[None])
    return NodalModes(where, np.zeros(len(shapes)), shapes, (block,))


@pytest.mark.parametrize('kind', VOLUMES)
def test_masses_of_a_straight_element(kind: str) -> None:
    """Translations weigh what the element weighs; a linear field has a second moment."""
    local = reference_nodes(kind)
    where = local @ SKEW
    x = local[:, 0]
    shapes = np.zeros((4, len(where), 3))
    shapes[0, :, 0] = shapes[1, :, 2] = 1.0
    shapes[2, :, 1] = x
    quadratic = kind in ('tet10', 'hex20', 'hex27', 'wedge15')
    shapes[3, :, 2] = x**2 if quadratic else x
    mass = 7.0 * VOLUMES[kind] * np.linalg.det(SKEW)
    # integral of x^n over the unit cube, prism and tetrahedron, by its volume
    moments = {'hex': {2: 1 / 3, 4: 1 / 5}, 'wed': {2: 1 / 6, 4: 1 / 15},
               'tet': {2: 1 / 10, 4: 1 / 35}}[kind[:3]]
    found = modal_masses(one(kind, shapes, where), 7.0)
    want = mass * np.array([1.0, 1.0, moments[2], moments[4 if quadratic else 2]])
    np.testing.assert_allclose(found, want, rtol=1e-12)


@pytest.mark.parametrize('kind', ['hex20', 'hex27'])
def test_mass_of_a_curved_element(kind: str) -> None:
    """A sector of a ring: its mid-nodes lie on the arc, the mass converges to the sector's."""
    local = reference_nodes(kind)
    masses = []
    for angle in (0.4, 0.2):
        r, t = 1.0 + local[:, 0], angle * (local[:, 1] - 0.5)
        where = np.stack([r * np.cos(t), r * np.sin(t), local[:, 2]], axis=1)
        masses.append(modal_masses(one(kind, np.ones((1, len(where), 3)), where), 1.0)[0]
                      / (3 * 1.5 * angle) - 1.0)
    assert 0.0 < abs(masses[0]) < 1e-3
    assert abs(masses[0] / masses[1]) > 12.0  # fourth order


def test_elements_turned_inside_out() -> None:
    where = reference_nodes('hex8')[[0, 1, 2, 3, 4, 5, 7, 6]]
    with pytest.raises(ModesError, match='hex8 number 1 is flat or turned inside out'):
        modal_masses(one('hex8', np.ones((1, 8, 3)), where), 1.0)
    with pytest.raises(ModesError, match='no elements to integrate over'):
        modal_masses(NodalModes(where, np.zeros(1), np.ones((1, 8, 3))), 1.0)


def test_mass_of_a_mirrored_element() -> None:
    """VTK and others number wedges from either side: it is the same element."""
    where = reference_nodes('wedge6') * [1, 1, -1]
    assert modal_masses(one('wedge6', np.ones((1, 6, 3)), where), 2.0) == pytest.approx(3.0)


def test_shapes_are_restored_from_the_density(tmp_path: Path) -> None:
    """Scaled at will, each mode by itself, as packages do that make the largest shift one."""
    want = read_modes(FRD, **PAD)
    scale = np.linspace(0.1, 3.0, len(HERTZ))
    lines = FRD.read_bytes().split(b'\n')
    heads = [i for i, line in enumerate(lines) if line.startswith(b'  100CL')]
    for head, factor in zip(heads, scale, strict=True):
        for i in range(head, len(lines)):
            if lines[i][:3] == b' -3':
                break
            if lines[i][:3] == b' -1':
                values = [float(lines[i][k:k + 12]) * factor for k in (13, 25, 37)]
                lines[i] = lines[i][:13] + b''.join(b'%12.5E' % v for v in values)
    path = tmp_path / 'scaled.frd'
    text = b'\n'.join(lines)
    path.write_bytes(text.replace(b'PGM                1.0', b'PGM                0.0'))
    found = read_modes(path, length_unit='mm', density=7820.0)
    for modes in (found, read_modes(path, **PAD, modal_mass=scale**2)):
        np.testing.assert_allclose(modes.shapes, want.shapes,
                                   atol=2e-4 * float(np.abs(want.shapes).max()))
    with pytest.raises(ReaderError, match='does not say how its shapes are normalised; state'):
        read_modes(path, **PAD)


def test_density_is_held_against_the_stated_masses() -> None:
    read_modes(FRD, **PAD, density=7820.0 * 1.04)
    with pytest.raises(ReaderError, match=r'mode \d has a modal mass of 1100\.\d+ kg by'):
        read_modes(FRD, **PAD, density=7820.0 * 1.1)
    with pytest.raises(ReaderError, match=r'1000 kg by density .* 2e\+06 kg by what'):
        read_modes(FRD, **PAD, modal_mass=2000.0, density=7820.0)
    with pytest.raises(ReaderError, match='1000.05 kg by density'):
        read_modes(FRD, **PAD, density=7820.0, mass_tolerance=1e-6)


def test_the_masses_given_go_before_those_of_the_file() -> None:
    assert np.allclose(read_modes(FRD, **PAD, modal_mass=4.0).shapes,
                       0.5 * read_modes(FRD, **PAD).shapes)


def test_rigid_modes_weigh_the_component() -> None:
    modes = read_modes(FRD, **PAD)
    volume = 0.5 * (0.142**2 - 0.1**2) * np.deg2rad(62.0) * 0.011
    assert rigid_mass(modes) == pytest.approx(7820.0 * volume, rel=1e-4)
    apart = replace(modes, coordinates=modes.coordinates + [3.0, -2.0, 1.0])
    assert rigid_mass(apart) == pytest.approx(7820.0 * volume, rel=1e-4)
    assert rigid_mass(modes.keep(5)) is None
    with pytest.raises(ReaderError, match='weighs 0.473 kg by its rigid modes, 0.4 kg by total'):
        read_modes(FRD, **PAD, total_mass=0.4)


def test_total_mass_needs_a_free_component(tmp_path: Path) -> None:
    with pytest.raises(ReaderError, match='has not the six rigid modes'):
        read_modes(FRD, **PAD, total_mass=0.473, frequencies_hz=np.arange(9) + 1.0)


@pytest.mark.parametrize(('axis', 'back'), [('x', [2, 0, 1]), ('y', [1, 2, 0]), ('z', [0, 1, 2])])
def test_axis_and_origin(axis: Any, back: list[int], tmp_path: Path) -> None:
    """The pad turned so that the disc's axis is another, and moved away from it."""
    want = read_modes(FRD, **PAD)
    told = read_modes(FRD, **PAD, axis=axis, origin=(10.0, -20.0, 5.0))
    moved = want.coordinates - np.array([0.010, -0.020, 0.005])
    np.testing.assert_allclose(told.coordinates[:, back], moved, atol=1e-12)
    np.testing.assert_allclose(told.shapes[6:, :, back], want.shapes[6:])
    np.testing.assert_allclose(*(np.sum(modes.shapes[:6]**2, axis=(0, 2))  # whatever their turn
                                 for modes in (told, want)), rtol=1e-4)
    assert np.linalg.det(np.eye(3)[back]) == 1.0
    assert told.coordinates[0, 2] == pytest.approx(moved[0, 'xyz'.index(axis)])


@pytest.mark.parametrize(('told', 'message'), [
    ({'length_unit': 'm'}, r"spans 146 m with length_unit 'm', which no brake does; give the"),
    ({'length_unit': 'cm'}, "length_unit is 'cm'; give one of m, mm, inch"),
    ({'length_unit': 'mm'}, r'would weigh about 0.\d+ kg, [\d.]+ kg to a cubic metre .* mass_u'),
    ({**PAD, 'modal_mass': 1e-3}, 'kg to a cubic metre of the box around it'),
    ({**PAD, 'mass_unit': 'tonne'}, "mass_unit is 'tonne'; give one of kg, t, g, lb, slinch"),
    ({**PAD, 'axis': 'r'}, "axis is 'r'; give one of x, y, z"),
    ({**PAD, 'origin': (1.0, 2.0)}, r'origin is \(1.0, 2.0\); give x, y and z of a point on'),
    ({**PAD, 'origin': (1.0, 2.0, np.nan)}, r'origin is \(1.0, 2.0, nan\); give'),
    ({**PAD, 'modal_mass': 0.0}, 'modal_mass is 0.0; give positive numbers'),
    ({**PAD, 'modal_mass': [1.0, 1.0]}, 'has 9 modes but 2 modal masses; give one number, or one'),
    ({**PAD, 'modal_mass': np.nan}, 'modal_mass is nan; give positive numbers'),
    ({**PAD, 'density': -1.0}, 'density is -1.0; give a positive number'),
    ({**PAD, 'total_mass': np.inf}, 'total_mass is inf; give a positive number'),
    ({**PAD, 'frequencies_hz': [1.0]}, 'has 9 modes but 1 frequencies; give one each mode'),
    ({**PAD, 'frequencies_hz': [*range(8, -1, -1)]}, r'mode 2 has 7.0 Hz after 8.0 Hz; give the'),
    ({**PAD, 'frequencies_hz': [-5.0, *range(8)]}, r'mode 1 has -5.0 Hz; give real normal modes'),
    ({**PAD, 'frequencies_hz': [0.0] * 8 + [np.nan]}, r'mode 9 has nan Hz; give real'),
    ({**PAD, 'frequencies_hz': [0.0] * 8 + [3e6]}, r'mode 9 has 3000000.0 Hz; give real'),
    ({**PAD, 'frequencies_hz': [0.9] * 7 + [2, 3]}, r'has 7 modes below 1.0 Hz, but one free'),
    ({**PAD, 'format': 'odb'}, "format is 'odb'; give format: one of unv, frd, nastran_h5"),
], ids=str)
def test_confusions_are_refused_in_one_line(told: dict[str, Any], message: str) -> None:
    with pytest.raises(ReaderError, match=message) as caught:
        read_modes(FRD, **told)
    assert str(caught.value).startswith(str(FRD))
    assert '\n' not in str(caught.value)


def test_frequencies_near_zero_are_rigid(tmp_path: Path) -> None:
    found = read_modes(FRD, **PAD, frequencies_hz=[-0.3, 0.9, -0.1, 0.0, 0.5, 0.2, 1.0, 2.0, 3.0])
    np.testing.assert_allclose(found.angular_frequencies / (2 * np.pi), [0.0] * 6 + [1, 2, 3])


def test_a_face_alone_is_read(tmp_path: Path) -> None:
    """Nodes of the contact face only: no body to judge, so the plausibility of its mass rests."""
    write_table(tmp_path / 'pad.csv')
    lines = (tmp_path / 'pad.csv').read_text().split('\n')
    face = [line for line in lines if ', ' not in line or line.split(', ')[3] in ('0.0', 'z')
            or not line[0].isdigit()]
    (tmp_path / 'face.csv').write_text('\n'.join(face))
    modes = read_modes(tmp_path / 'face.csv', **PAD)
    assert np.ptp(modes.coordinates[:, 2]) == 0.0
    assert 10 < len(modes.coordinates) < 60

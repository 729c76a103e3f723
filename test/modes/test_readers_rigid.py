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

"""Rigid motions: what zero-frequency shapes must be, exact ones for them, and what is missing."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from squeal_core.brake.dimensions import Brake, ModalResults
from squeal_core.modes.component_modes import read_component
from squeal_core.modes.fe.mass import mass_matrix, mass_products
from squeal_core.modes.fe.solid import RIGID_NAMES
from squeal_core.modes.modal_basis import Quadrature
from squeal_core.modes.nodal_modes import NodalModes
from squeal_core.modes.readers import read_modes, ReaderError
from squeal_core.modes.readers.normalising import normalised
from squeal_core.modes.readers.rigid_modes import exact_rigid_modes, in_plane_first, rigid_fields
from support.reader_samples import FRD, HERTZ, PAD

DENSITY = 7820.0


@pytest.fixture(scope='module')
def pad() -> NodalModes:
    return read_modes(FRD, **PAD, density=DENSITY)


def mixed(modes: NodalModes, seed: int) -> NodalModes:
    """Return the same rigid modes, mixed as solvers do."""
    turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((6, 6)))[0]
    shapes = modes.shapes.copy()
    shapes[:6] = np.tensordot(turn, shapes[:6], axes=1)
    return replace(modes, shapes=shapes)


def stretched(modes: NodalModes, part: float) -> NodalModes:
    """Rigid modes that a part of a flexible one has leaked into, or that are inaccurate."""
    shapes = modes.shapes.copy()
    for k in range(6):
        flexible = shapes[6 + k % 3]
        shapes[k] += part * np.linalg.norm(shapes[k]) / np.linalg.norm(flexible) * flexible
    return replace(modes, shapes=shapes)


def test_inaccurate_rigid_modes_become_exact(pad: NodalModes) -> None:
    """To 1e-5 as solvers give them: no part is left that is no rigid motion, whatever mixture."""
    found = normalised(stretched(mixed(pad, 1), 1e-5), np.ones(9), DENSITY, None, 0.05)
    rigid = found.shapes[:6].reshape(6, -1)
    fields = rigid_fields(found.coordinates).reshape(6, -1).T
    fit = fields @ np.linalg.lstsq(fields, rigid.T, rcond=None)[0]
    np.testing.assert_allclose(fit.T, rigid, atol=1e-12 * np.abs(rigid).max())
    np.testing.assert_allclose(mass_products(found.shapes, mass_matrix(found, DENSITY)),
                               np.eye(9), atol=1e-3)
    np.testing.assert_allclose(rigid, pad.shapes[:6].reshape(6, -1),
                               atol=1e-3 * np.abs(rigid).max())


def test_the_motions_in_plane_press_nowhere(pad: NodalModes) -> None:
    """The first three of every mixture have no part along the axis, not even a rounded one."""
    for seed in range(3):
        turned = in_plane_first(mixed(pad, seed))
        assert np.all(turned.shapes[:3, :, 2] == 0.0)
        assert np.all(np.abs(turned.shapes[3:6, :, 2]).max(axis=1) > 0.1)
        np.testing.assert_allclose(turned.shapes, pad.shapes, atol=1e-9)


@pytest.mark.parametrize(('part', 'said'), [(9e-4, None), (2e-3, '0.20%'), (0.2, '19')])
def test_a_rigid_mode_that_is_none(pad: NodalModes, part: float, said: str | None) -> None:
    if said is None:
        exact_rigid_modes(stretched(pad, part))
        return
    with pytest.raises(ReaderError, match=f'mode . has a frequency near zero but .* {said}'):
        exact_rigid_modes(stretched(pad, part))


def test_rigid_modes_in_cylindrical_components(pad: NodalModes) -> None:
    """What CalculiX writes with GLOBAL=NO under *TRANSFORM: nothing else in the file says so."""
    angle = np.arctan2(pad.coordinates[:, 1], pad.coordinates[:, 0])
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = np.moveaxis(pad.shapes, 2, 0)
    local = replace(pad, shapes=np.stack([c * x + s * y, c * y - s * x, z], axis=2))
    with pytest.raises(ReaderError, match='no rigid motion: .*; export one free component, res'):
        exact_rigid_modes(local)


def test_a_mode_that_is_there_twice(pad: NodalModes) -> None:
    twice = pad.shapes.copy()
    twice[5] = twice[4]
    with pytest.raises(ReaderError, match='6 modes near zero frequency that are not as many'):
        exact_rigid_modes(replace(pad, shapes=twice))
    twice = pad.shapes.copy()
    twice[8] = twice[7]
    for density in (DENSITY, None):
        with pytest.raises(ReaderError, match='modes 8 and 9 are not orthogonal: they share 1 of'):
            normalised(replace(pad, shapes=twice), np.ones(9), density, None, 0.05)


@pytest.mark.parametrize('low', [[-3.0, -0.2, 0.0, 0.1, 2.0, 6.0], [1.5, 2.0, 3.0, 4.0, 5.0, 6.0]])
def test_rigid_modes_at_some_hertz(low: list[float]) -> None:
    """Prestress and rounding leave that much, below zero too."""
    found = read_modes(FRD, **PAD, frequencies_hz=[*low, *HERTZ[6:]])
    assert np.all(found.angular_frequencies[:6] == 0.0)
    with pytest.raises(ReaderError, match='7 modes below 9.2 Hz, but .* without mechanisms'):
        read_modes(FRD, **PAD, frequencies_hz=[*low, 7.0, *HERTZ[7:]])


def table(path: Path, where: np.ndarray, hertz: list[float], shapes: np.ndarray) -> Path:
    names = [f'u{axis}_{k + 1}' for k in range(len(hertz)) for axis in 'xyz']
    lines = [' '.join(['frequency_hz', *map(repr, hertz)]), ' '.join(['node', *'xyz', *names])]
    lines += [' '.join(map(repr, [k + 1, *point, *values])) for k, (point, values) in enumerate(
        zip(where.tolist(), np.hstack(shapes).tolist(), strict=True))]
    path.write_text('\n'.join(lines) + '\n')
    return path


def results(path: Path, density: float, thickness: float) -> ModalResults:
    return ModalResults(str(path), None, 'm', 'kg', 'z', (0.0, 0.0, 0.0), 1.0, density, thickness)


def test_pads_that_lack_a_rigid_mode(pad: NodalModes, brake: Brake, tmp_path: Path) -> None:
    where = pad.coordinates + [0.0, 0.0, 0.008]
    hertz = (pad.angular_frequencies / (2.0 * np.pi)).tolist()
    for away in ([0], [3], [0, 1, 2]):
        kept = [k for k in range(9) if k not in away]
        path = table(tmp_path / 'pad.csv', where, [hertz[k] for k in kept], pad.shapes[kept])
        with pytest.raises(ReaderError, match=f'has {6 - len(away)} rigid modes, and no mode car'):
            read_component(results(path, DENSITY, 0.011), len(kept), brake.contact, (0.008,))
    held = [300.0, 400.0, 500.0, 600.0, 700.0, 800.0, *hertz[6:]]  # on springs: none is missing
    path = table(tmp_path / 'pad.csv', where, held, pad.shapes)
    assert read_component(results(path, DENSITY, 0.011), 9, brake.contact, (0.008,)).mac


def test_rigid_modes_of_a_pad_are_named_as_those_of_dimensions(
        pad: NodalModes, brake: Brake, tmp_path: Path) -> None:
    """Whatever mixture of them a solver wrote."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(6, 6)))[0]
    mixed = np.concatenate([np.tensordot(turn, pad.shapes[:6], 1), pad.shapes[6:]])
    hertz = (pad.angular_frequencies / (2.0 * np.pi)).tolist()
    path = table(tmp_path / 'pad.csv', pad.coordinates + [0.0, 0.0, 0.008], hertz, mixed)
    basis = read_component(results(path, DENSITY, 0.011), 9, brake.contact, (0.008,)).basis
    assert basis.names == (*RIGID_NAMES, 'flexible 1', 'flexible 2', 'flexible 3')
    middle = basis.sample(Quadrature(np.array([pad.coordinates[:, 0].mean()]), np.zeros(1),
                                     np.array([0.0135]), np.ones(1)))
    parts = np.abs([middle.radial, middle.tangential, middle.normal])[..., 0]
    for direction, name in enumerate(('slide radial', 'slide tangential', 'lift')):
        own = parts[:, basis.names.index(name)]
        assert own[direction] > 5.0 * np.delete(own, direction).max()


def ring(brake: Brake, degrees: float = 360.0) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of a plate in two layers, and shapes with 2 and 3 nodal diameters, in polar parts."""
    count = round(72 * degrees / 360.0)
    r, t, z = (grid.ravel() for grid in np.meshgrid(
        np.linspace(0.095, 0.148, 8), np.radians(degrees) * np.arange(count) / count,
        [-0.008, 0.008], indexing='ij'))
    shapes = np.array([[0.3 * r * a, 0.3 * r * b, r * a] for n in (2, 3) for a, b in (
        (np.cos(n * t), np.sin(n * t)), (np.sin(n * t), -np.cos(n * t)))]).transpose(0, 2, 1)
    volume = np.pi * (0.148**2 - 0.095**2) * 0.016
    shapes /= np.sqrt(7150.0 * volume * np.mean(np.sum(shapes**2, axis=2), axis=1))[:, None, None]
    return np.stack([r * np.cos(t), r * np.sin(t), z], axis=1), shapes


@pytest.mark.parametrize('local', [False, True])
def test_discs_in_cylindrical_components(local: bool, brake: Brake, tmp_path: Path) -> None:
    where, polar = ring(brake)
    angle = np.arctan2(where[:, 1], where[:, 0])
    c, s = np.cos(angle), np.sin(angle)
    radial, tangential, normal = np.moveaxis(polar, 2, 0)
    shapes = polar if local else np.stack([
        c * radial - s * tangential, s * radial + c * tangential, normal], axis=2)
    path = table(tmp_path / 'disc.csv', where, [900.0, 900.0, 1600.0, 1600.0], shapes)
    told = results(path, 7150.0, 0.016), 4, brake.contact, (0.008, -0.008)
    if not local:
        assert len(read_component(*told).basis.names) == 4
        return
    with pytest.raises(ReaderError, match='moves in the plane of the disc in other waves'):
        read_component(*told)


def test_discs_that_are_sectors_or_free(brake: Brake, tmp_path: Path) -> None:
    where, shapes = ring(brake, 90.0)
    path = table(tmp_path / 'disc.csv', where, [900.0, 901.0, 1600.0, 1601.0], shapes)
    with pytest.raises(ReaderError, match='in 27. degrees of the ring .* a sector, as in a model'):
        read_component(results(path, 7150.0, 0.016), 4, brake.contact, (0.008, -0.008))
    where, shapes = ring(brake)
    spin = np.stack([-where[:, 1], where[:, 0], 0.0 * where[:, 0]], axis=1)
    shapes[0] = spin * np.linalg.norm(shapes[1]) / np.linalg.norm(spin)
    path = table(tmp_path / 'disc.csv', where, [0.0, 901.0, 1600.0, 1601.0], shapes)
    with pytest.raises(ReaderError, match='has 1 rigid modes: the disc is free; clamp the disc'):
        read_component(results(path, 7150.0, 0.016), 4, brake.contact, (0.008, -0.008))

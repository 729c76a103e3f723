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

"""Shapes for pictures: the model's own in order, scale and sign; and they survive a file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.errors import ModelError, ModelFileError
from squeal_core.model.surface_shapes import Patch, SurfaceShapes


def part(kang: BrakeModel, name: str) -> tuple[Patch, np.ndarray, np.ndarray]:
    """Patch, points and normal displacements (rows, columns, N) of a component."""
    assert kang.surface is not None
    start = 0
    for patch in kang.surface.patches:
        here = slice(start, start + patch.size)
        if patch.name == name:
            shape = (patch.rows, patch.columns, -1)
            return (patch, kang.surface.points[here].reshape(shape),
                    kang.surface.shapes[here].reshape(patch.rows, patch.columns, 3, -1))
        start = here.stop
    raise AssertionError(name)


def test_each_component_moves_in_its_own_modes_only(kang: BrakeModel) -> None:
    for name in ('pad 1', 'disc', 'pad 2'):
        _, _, shapes = part(kang, name)
        moves = np.abs(shapes).max(axis=(0, 1, 2)) > 0.0
        assert [n.startswith(name) for n in kang.names] == moves.tolist()


def test_nodal_diameters_are_those_of_the_names(kang: BrakeModel) -> None:
    _, points, shapes = part(kang, 'disc')
    angle = np.arctan2(points[..., 1], points[..., 0])
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    radial = c * shapes[:, :, 0] + s * shapes[:, :, 1]
    tangential = c * shapes[:, :, 1] - s * shapes[:, :, 0]
    for i, name in enumerate(kang.names):
        if name.startswith('disc ('):
            order = int(name.partition('(')[2].partition(',')[0])
            waves = sum(np.abs(np.fft.rfft(u[:, :, i], axis=1)).sum(axis=0)
                        for u in (radial, tangential, shapes[:, :, 2]))
            # one harmonic and nothing else, to single precision
            assert waves.argmax() == order
            assert np.delete(waves, order).max() < 1e-5 * waves[order]


@pytest.mark.parametrize(('pad', 'side'), [('pad 1', 1.0), ('pad 2', -1.0)])
def test_signs_and_scale_are_those_of_the_arrays(kang: BrakeModel, pad: str, side: float) -> None:
    """
    The contact array's block of pad and disc is minus the integral of both normal shapes.

    Integrated here over the picture's coarse points (trapezoids, 2 % inside the edges), so to
    some per cent only; a wrong sign or order of modes would leave no likeness at all.
    """
    _, pad_points, pad_shapes = part(kang, pad)
    _, disc_points, disc_shapes = part(kang, 'disc')
    angle = np.arctan2(pad_points[0, :, 1], pad_points[0, :, 0])
    radius = np.hypot(*pad_points[:, 0, :2].T)
    np.testing.assert_allclose(np.hypot(*disc_points[:, 0, :2].T), radius)
    # the disc's harmonics, at the pad's angles
    wave = np.fft.rfft(disc_shapes[:, :, 2], axis=1) / 48.0
    wave[:, 1:-1] *= 2.0
    phase = np.exp(1j * np.outer(angle, np.arange(25)))
    on_pad = np.einsum('ah,rhn->ran', phase, wave).real
    weight = np.outer(_trapezoid(radius) * radius, _trapezoid(angle))
    cross = -np.einsum('ra,ran,ram->nm', weight, pad_shapes[:, :, 2], on_pad)
    assert kang.contact_stiffness is not None
    pads = [i for i, name in enumerate(kang.names) if name.startswith(pad)]
    disc = [i for i, name in enumerate(kang.names) if name.startswith('disc')]
    given = kang.contact_stiffness[np.ix_(pads, disc)]
    found = cross[np.ix_(pads, disc)]
    # in plane modes and those of high order are poorly sampled: what matters is most of the block
    likeness = np.vdot(given, found) / np.linalg.norm(given) / np.linalg.norm(found)
    assert likeness > 0.98
    assert np.vdot(given, found) / np.vdot(given, given) == pytest.approx(0.92, abs=0.08)
    assert side * pad_points[0, 0, 2] > 0.0


def _trapezoid(x: np.ndarray) -> np.ndarray:
    steps = np.diff(x)
    return np.concatenate([[0.5 * steps[0]], 0.5 * (steps[1:] + steps[:-1]), [0.5 * steps[-1]]])


def test_triangles_cover_a_ring_and_a_sector() -> None:
    for closed, columns in ((True, 5), (False, 4)):
        patch = Patch('x', 3, 5, closed)
        triangles = list(patch.triangles())
        assert len(triangles) == 2 * 2 * columns
        edges = [tuple(sorted((t[i], t[(i + 1) % 3]))) for t in triangles for i in range(3)]
        shared = sum(edges.count(e) == 2 for e in set(edges))
        # Euler: V - E + F is 0 for a ring, 1 for a disc
        assert 15 - len(set(edges)) + len(triangles) == (0 if closed else 1)
        assert 2 * shared + (len(set(edges)) - shared) == len(edges)


def test_a_mode_is_drawn_at_its_extreme_whatever_its_phase(kang: BrakeModel) -> None:
    assert kang.surface is not None
    rng = np.random.default_rng(3)
    vector = rng.normal(size=92) + 1j * rng.normal(size=92)
    points, amplitude = kang.surface.displaced(vector, 0.01)
    moved = np.linalg.norm(points - kang.surface.points, axis=1)
    assert moved.max() == pytest.approx(0.01)
    np.testing.assert_allclose(moved, 0.01 * amplitude, atol=1e-12)
    for factor in (-3.0, 1j, np.exp(0.7j)):
        again, _ = kang.surface.displaced(factor * vector, 0.01)
        np.testing.assert_allclose(again, points, atol=1e-9)
    still, none = kang.surface.displaced(np.zeros(92, complex), 0.01)
    assert np.array_equal(still, kang.surface.points)
    assert not none.any()


def test_a_file_keeps_them_and_one_without_stays_valid(kang: BrakeModel, tmp_path: Path) -> None:
    kang.save(tmp_path / 'with.npz')
    found = BrakeModel.load(tmp_path / 'with.npz').surface
    assert found is not None
    assert kang.surface is not None
    assert found.patches == kang.surface.patches
    assert np.array_equal(found.shapes, kang.surface.shapes)
    replace(kang, surface=None).save(tmp_path / 'without.npz')
    assert BrakeModel.load(tmp_path / 'without.npz').surface is None


def test_what_does_not_fit_is_refused(kang: BrakeModel) -> None:
    found = kang.surface
    assert found is not None
    with pytest.raises(ModelError, match='surface: points'):
        SurfaceShapes(found.points[1:], found.shapes, found.patches)
    with pytest.raises(ModelError, match='not finite'):
        SurfaceShapes(found.points * np.nan, found.shapes, found.patches)
    with pytest.raises(ModelError, match='91 modes for 92'):
        replace(kang, surface=SurfaceShapes(found.points, found.shapes[..., 1:], found.patches))


@pytest.mark.parametrize('patches', [
    [{'name': 'disc', 'rows': 10**9, 'columns': 10**9, 'closed': True}], [{'name': 'disc'}],
    'disc', [3]])
def test_a_file_with_bad_patches_is_refused(kang: BrakeModel, tmp_path: Path, patches: object,
                                            monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SurfaceShapes, 'header', lambda self: patches)
    kang.save(tmp_path / 'bad.npz')
    with pytest.raises(ModelFileError, match='no usable model'):
        BrakeModel.load(tmp_path / 'bad.npz')

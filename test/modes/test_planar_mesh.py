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

"""Layers, grids and differences of the planar mesh."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from squeal_core.brake.dimensions import Brake, Contact
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.model import operators
from squeal_core.modes.modal_basis import Quadrature, SampledShapes
from squeal_core.modes.nodal_modes import ModesError, NodalModes
from squeal_core.modes.planar_mesh import (
    AS_PRINTED,
    contact_grid,
    Layer,
    LayeredBasis,
    LayeredNodes,
    PlanarGrid,
    PlanarModes,
    sector_quadrature,
)
from support.annulus import INNER, OUTER, scattered

PATCH = Contact(0.1, 0.142, np.deg2rad(62.0), 1e10)


# ---------------------------------------------------------------- layers

def stacked(heights: FloatArray, spacing: float = 6e-3,
            shape: Callable[..., FloatArray] | None = None) -> NodalModes:
    """Irregular layers of an annulus, with shapes (1, M, 3) of what `shape(x, y, z)` returns."""
    parts = [np.column_stack([r * np.cos(t), r * np.sin(t), np.full(r.size, z)])
             for i, z in enumerate(heights) for r, t in [scattered(spacing, seed=i)]]
    where = np.vstack(parts)
    shapes = np.ones_like(where) if shape is None else np.column_stack(shape(*where.T))
    return NodalModes(where, [1.0], shapes[None])


def test_layers_are_found() -> None:
    nodal = stacked(np.array([0.0, 4e-3, 1e-2]))
    rng = np.random.default_rng(0)
    order = rng.permutation(len(nodal.coordinates))
    shaken = nodal.coordinates[order] + rng.uniform(-1e-6, 1e-6, nodal.coordinates.shape)
    twice = np.vstack([shaken, shaken[:50]])  # as where meshes meet without being merged
    layered = LayeredNodes(NodalModes(twice, [1.0], np.ones((1, *twice.shape))))
    assert [layer.height for layer in layered.layers] == pytest.approx([0, 4e-3, 1e-2], abs=1e-7)
    assert [layer.inner for layer in layered.layers] == pytest.approx([INNER] * 3, abs=3e-6)
    assert [layer.outer for layer in layered.layers] == pytest.approx([OUTER] * 3, abs=3e-6)
    assert layered.span == (0.0, 2.0 * np.pi)
    points = contact_grid(PATCH, 4e-3)
    found = PlanarModes(layered).sample(points)
    assert np.allclose(found.normal, 1.0, atol=1e-9)


def test_no_layers_no_modes() -> None:
    rng = np.random.default_rng(0)
    for where, words in ((rng.uniform(0.1, 0.2, (20_000, 3)), 'nodes lie at'),
                         (rng.uniform(0.1, 0.2, (300, 3)), 'fewest'),
                         (rng.uniform(0.1, 0.2, (300, 3)) * [1, 1, 0], 'lie at 1 heights')):
        with pytest.raises(ModesError, match=words):
            PlanarModes.from_nodal(NodalModes(where, [1.0], np.ones((1, len(where), 3))))


@pytest.mark.parametrize('angle', [0.0, 3.0, -2.0])
def test_span_of_a_sector(angle: float) -> None:
    q = contact_grid(PATCH, 0.0, PlanarGrid(rule='nodes', contact=(5, 9)))
    where = np.vstack([np.column_stack([q.radius * np.cos(q.angle + angle),
                                        q.radius * np.sin(q.angle + angle),
                                        np.full(q.angle.shape, z)]) for z in (0.0, 0.01)])
    modes = PlanarModes.from_nodal(NodalModes(where, [1.0], np.ones((1, *where.shape))),
                                   PlanarGrid(rule='midpoint'))
    start, stop = modes.shapes.span
    assert stop - start == pytest.approx(PATCH.angle)
    assert np.exp(0.5j * (start + stop)) == pytest.approx(np.exp(1j * angle))
    volume = sum(s.points.weight.sum() for s in replace(modes, offset=0.5).volume_layers())
    assert volume == pytest.approx(PATCH.area * 0.01)
    assert next(modes.volume_layers()).radial_dtheta == pytest.approx(  # constant in x and y
        next(modes.volume_layers()).tangential, abs=1e-9)


def test_between_layers() -> None:
    """Cubic through four layers, with what the planes themselves say on them."""
    nodal = stacked(np.array([0.0, 3e-3, 4e-3, 8e-3, 1e-2]), shape=lambda x, y, z: (
        0.0 * z, 0.0 * z, 1.0 + z / 1e-3 - (z / 1e-3)**3))
    for z in (0.0, 1e-3, 3.4e-3, 9.9e-3, 1e-2):
        points = contact_grid(PATCH, z, PlanarGrid(contact=(4, 4)))
        expected = 1.0 + z / 1e-3 - (z / 1e-3)**3
        assert PlanarModes.from_nodal(nodal).sample(points).normal == pytest.approx(
            np.full((1, 16), expected), rel=1e-9)
    with pytest.raises(SquealError, match=r'z = 0\.011 m does not lie between layers'):
        PlanarModes.from_nodal(nodal).sample(contact_grid(PATCH, 1.1e-2))
    far = replace(PATCH, outer_radius=0.16)
    with pytest.raises(SquealError, match='reach so far'):
        PlanarModes.from_nodal(nodal).sample(contact_grid(far, 1e-3))


# ---------------------------------------------------------------- grids and rules

def test_sums_over_nodes_count_edges_whole() -> None:
    """K09 eq. (40): M points stand for M - 1 intervals; the other rules hold the area."""
    for rule in ('gauss', 'midpoint'):
        q = contact_grid(PATCH, 0.0, PlanarGrid(rule=rule, contact=(15, 43)))
        assert q.weight.sum() == pytest.approx(PATCH.area, rel=1e-12)
    q = contact_grid(PATCH, 0.008, AS_PRINTED)
    assert q.radius.size == 15 * 43
    assert np.ptp(q.angle) == pytest.approx(PATCH.angle)
    assert q.weight.sum() == pytest.approx(PATCH.area * 15 / 14 * 43 / 42, rel=1e-12)
    assert np.all(q.height == 0.008)


def test_default_grid_is_the_shipped_rule() -> None:
    one, other = contact_grid(PATCH, 0.0), sector_quadrature(PATCH, 0.0)
    assert np.array_equal(one.weight, other.weight)
    assert np.array_equal(one.angle, other.angle)


@pytest.mark.parametrize('changes', [{'radial': 1}, {'around': 3}, {'contact': (1, 9)}])
def test_grids_too_coarse(changes: dict[str, object]) -> None:
    with pytest.raises(SquealError, match='give 2 points or more'):
        PlanarGrid(**changes)


class Waves:
    """Transverse waves cos(n theta), sin(n theta) for n = 1..9, constant in r and z."""

    angular_frequencies = np.repeat(np.arange(1.0, 10.0), 2)
    names = tuple(f'{n}{half}' for n in range(1, 10) for half in 'cs')

    def sample(self, points: Quadrature) -> SampledShapes:
        n = self.angular_frequencies[:, None]
        half = np.tile([[0.0], [0.5 * np.pi]], (9, 1))
        none = np.zeros((18, points.radius.size))
        return SampledShapes(none, none, np.cos(n * points.angle - half), none, none,
                             -n * np.sin(n * points.angle - half), points)


RING = (Layer(0.0, INNER, OUTER), Layer(0.002, INNER, OUTER), Layer(0.01, INNER, OUTER))


@pytest.mark.parametrize('derivative', ['forward', 'central'])
@pytest.mark.parametrize('around', [24, 61, 244])
def test_differences_shrink_the_gyroscopic_matrix(derivative: str, around: int) -> None:
    """By sin(n d) / (n d) of transverse modes: forward and central differences agree in G."""
    grid = PlanarGrid(radial=4, around=around, derivative=derivative)
    exact, found = (operators.gyroscopic(PlanarModes(LayeredBasis(Waves(), RING), g)
                                         .volume_layers(), 1e3)
                    for g in (replace(grid, derivative='local'), grid))
    factor = np.sinc(np.arange(1, 10) * grid.step / np.pi)
    for i, expected in enumerate(factor):
        assert found[2 * i, 2 * i + 1] == pytest.approx(
            expected * exact[2 * i, 2 * i + 1], rel=1e-12)
    # two waves of n diameters: rho h (ro^2 - ri^2) / 2 times pi times 2 n
    assert exact[0, 1] == pytest.approx(1e3 * 0.01 * (OUTER**2 - INNER**2) * np.pi, rel=1e-12)


@pytest.mark.parametrize('around', [19, 20, 64])
def test_spectral_derivative_is_exact(around: int) -> None:
    """Up to the sampling theorem: ten diameters would take more than 20 points."""
    modes = PlanarModes(LayeredBasis(Waves(), RING), PlanarGrid(radial=4, around=around))
    for s in modes.volume_layers():
        exact = Waves().sample(s.points).normal_dtheta
        assert np.abs(s.normal_dtheta - exact).max() < 1e-12 * 9 * around


def test_differences_at_points_of_the_contact() -> None:
    points = contact_grid(PATCH, 0.001)
    exact = Waves().sample(points)
    n = np.repeat(np.arange(1, 10), 2)[:, None]
    d = PlanarGrid().step
    partner = np.vstack([[s, -c] for c, s in exact.normal.reshape(9, 2, -1)])  # shifted by pi / 2
    expected = {'local': exact.normal_dtheta, 'spectral': exact.normal_dtheta,
                'central': np.sinc(n * d / np.pi) * exact.normal_dtheta,
                'forward': (exact.normal * (np.cos(n * d) - 1.0) - partner * np.sin(n * d)) / d}
    for derivative, slope in expected.items():
        modes = PlanarModes(LayeredBasis(Waves(), RING), PlanarGrid(derivative=derivative))
        assert np.allclose(modes.sample(points).normal_dtheta, slope, rtol=0, atol=1e-11)


@pytest.mark.parametrize(('rule', 'excess'), [('gauss', 1.0), ('midpoint', 1.0),
                                              # rows 12 / 11, layers (2 + 8 + 8) / 10
                                              ('nodes', 12 / 11 * 18 / 10)])
def test_volume_of_a_ring(rule: str, excess: float) -> None:
    modes = PlanarModes(LayeredBasis(Waves(), RING), PlanarGrid(rule=rule))
    volume = sum(s.points.weight.sum() for s in modes.volume_layers())
    assert volume == pytest.approx(np.pi * (OUTER**2 - INNER**2) * 0.01 * excess, rel=1e-12)


def test_volume_of_a_hat(brake: Brake) -> None:
    """Where layers differ, what lies between them is what both fill."""
    disc = brake.disc
    half, inner, wall = 0.5 * disc.rotor_thickness, disc.hat_wall_inner_radius, (
        disc.hat_wall_outer_radius)
    top = half + disc.hat_height
    plate = top - disc.top_plate_thickness
    layers = (Layer(-half, inner, disc.rotor_outer_radius),
              Layer(half, inner, disc.rotor_outer_radius),
              Layer(plate, disc.clamp_radius, wall), Layer(top, disc.clamp_radius, wall))
    modes = PlanarModes(LayeredBasis(Waves(), layers))
    volume = sum(s.points.weight.sum() for s in modes.volume_layers())
    assert volume == pytest.approx(np.pi * (
        (disc.rotor_outer_radius**2 - inner**2) * 2.0 * half + (wall**2 - inner**2)
        * (plate - half) + (wall**2 - disc.clamp_radius**2) * (top - plate)), rel=1e-12)


# ---------------------------------------------------------------- all together

def test_rigid_motions_through_irregular_layers() -> None:
    """Roll and pitch of a ring: G = rho int (x^2 + y^2) dV between them, by K09 eq. (38)."""
    heights = np.linspace(-5e-3, 5e-3, 4)
    rolls = stacked(heights, shape=lambda x, y, z: (0.0 * x, -z, y))
    pitches = stacked(heights, shape=lambda x, y, z: (z, 0.0 * x, -x))
    modes = PlanarModes.from_nodal(replace(
        rolls, angular_frequencies=[1.0, 1.0], names=(),
        shapes=np.concatenate([rolls.shapes, pitches.shapes])))
    found = operators.gyroscopic(modes.volume_layers(), 7e3)
    expected = 7e3 * 0.5 * np.pi * (OUTER**4 - INNER**4) * 1e-2
    assert found[0, 1] == pytest.approx(expected, rel=1e-6)
    assert modes.names == ('mode 1', 'mode 2')


def test_gyroscopic_matrix_converges_with_the_nodes() -> None:
    """Seven diameters over layers of irregular nodes: with h^4 at least, the weights' own."""
    exact = 1e3 * 0.01 * 14.0 * np.pi * 0.015 * (  # rho h 2 n pi times int r exp(2 r / a) dr
        np.exp(OUTER / 0.015) * (OUTER - 0.015) - np.exp(INNER / 0.015) * (INNER - 0.015))
    off = []
    for spacing in (1e-2, 5e-3, 2.5e-3):
        halves = [stacked(np.array([0.0, 0.01]), spacing, lambda x, y, z, t=t: (
            0.0 * z, 0.0 * z, np.exp(np.hypot(x, y) / 0.03) * np.cos(
                7.0 * np.arctan2(y, x) - t))) for t in (0.0, 0.5 * np.pi)]
        modes = PlanarModes.from_nodal(replace(
            halves[0], angular_frequencies=[1.0, 1.0], names=(),
            shapes=np.concatenate([half.shapes for half in halves])))
        off.append(abs(operators.gyroscopic(modes.volume_layers(), 1e3)[0, 1] / exact - 1.0))
    rates = np.log2(np.divide(off[:-1], off[1:]))
    assert np.all(rates > 3.8), (off, rates)
    assert off[-1] < 1e-5
    assert np.array_equal(modes.angular_frequencies, [1.0, 1.0])

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

"""Interpolation from scattered nodes, layers, grids and differences of the planar mesh."""

from collections.abc import Callable
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st
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
    local_weights,
    PlanarGrid,
    PlanarModes,
    sector_quadrature,
)

PATCH = Contact(0.1, 0.142, np.deg2rad(62.0), 1e10)
INNER, OUTER = 0.09, 0.15
QUICK = settings(deadline=None, max_examples=15, derandomize=True)


def scattered(spacing: float, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """Nodes of an annulus a spacing apart, each moved at random, those on its edges along them."""
    rng = np.random.default_rng(seed)
    rows = np.linspace(INNER, OUTER, 1 + round((OUTER - INNER) / spacing))
    radius, angle = [], []
    for i, r in enumerate(rows):
        count = round(2.0 * np.pi * r / spacing)
        inside = 0 < i < rows.size - 1
        radius.append(r + inside * 0.3 * spacing * rng.uniform(-1, 1, count))
        angle.append((np.arange(count) + 0.3 * rng.uniform(-1, 1, count)) * 2.0 * np.pi / count)
    return np.concatenate(radius), np.concatenate(angle)


def anywhere(count: int, seed: int = 1) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(INNER, OUTER, count), rng.uniform(-np.pi, np.pi, count)


# ---------------------------------------------------------------- within a layer

def test_weights_converge_as_their_polynomials() -> None:
    """Degree 4 over irregular nodes: values with h^5, theta derivatives with h^4."""
    at_radius, at_angle = anywhere(600)
    off = []
    for spacing in (8e-3, 4e-3, 2e-3):
        radius, angle = scattered(spacing)
        values, slopes = local_weights(radius, angle, at_radius, at_angle)
        field = np.cos(7.0 * angle) * np.exp(radius / 0.03)
        scale = np.exp(at_radius / 0.03)
        off.append([np.std((values @ field) / scale - np.cos(7.0 * at_angle)),
                    np.std((slopes @ field) / scale + 7.0 * np.sin(7.0 * at_angle))])
    rates = np.log2(np.divide(off[:-1], off[1:]))
    # random nodes scatter the rates, and h^5 splines outrun their polynomials while coarse
    assert np.all(rates[-1] == pytest.approx([5.0, 4.0], abs=0.6))
    assert off[-1][0] < 1e-5


@QUICK
@given(seed=st.integers(0, 1000))
def test_weights_hold_polynomials(seed: int) -> None:
    """Products r^i theta^j of total degree four or less, and their derivatives, to rounding."""
    rng = np.random.default_rng(seed)
    radius, angle = rng.uniform(0.1, 0.14, 200), rng.uniform(-0.2, 0.2, 200)
    at_radius, at_angle = rng.uniform(0.11, 0.13, 30), rng.uniform(-0.15, 0.15, 30)
    values, slopes = local_weights(radius, angle, at_radius, at_angle)
    for i, j in ((0, 0), (1, 0), (0, 1), (2, 1), (1, 3), (4, 0), (0, 4)):
        def field(r: FloatArray, t: FloatArray, i: int = i, j: int = j) -> FloatArray:
            return ((r - 0.12) / 0.02)**i * (t / 0.2)**j

        slope = j * ((at_radius - 0.12) / 0.02)**i * (at_angle / 0.2)**max(j - 1, 0) / 0.2
        # weights reach some tens where nodes lie badly, derivatives thirty times that
        assert np.allclose(values @ field(radius, angle), field(at_radius, at_angle), atol=1e-9)
        assert np.allclose(slopes @ field(radius, angle), slope, atol=1e-7)


@pytest.mark.parametrize(('rows', 'power'), [(1, 0), (2, 1), (3, 2)])
def test_thin_walls_have_few_rows(rows: int, power: int) -> None:
    """Across the wall no more is known than the rows tell; along it, all of degree four."""
    rng = np.random.default_rng(rows)
    circles = np.linspace(0.082, 0.0895, rows) if rows > 1 else np.array([0.085])
    angle = (np.arange(60) + rng.uniform(-0.3, 0.3, (rows, 60))) * 2.0 * np.pi / 60
    radius = np.repeat(circles, 60)
    at_radius, at_angle = rng.uniform(circles[0], circles[-1], 200), rng.uniform(-3.0, 3.0, 200)
    values, slopes = local_weights(radius, angle.ravel(), at_radius, at_angle)
    field = np.cos(3.0 * angle.ravel()) * radius**power
    # 20 nodes a wave: h^5 / 5! of 1.5^5 each side of the point, and h^4 of its derivative
    assert np.allclose(values @ field, np.cos(3.0 * at_angle) * at_radius**power, atol=1e-3)
    assert np.allclose(slopes @ field, -3.0 * np.sin(3.0 * at_angle) * at_radius**power, atol=2e-2)


def test_weights_know_no_seam() -> None:
    """Turning nodes and points together changes nothing, also over theta = pi."""
    radius, angle = scattered(6e-3)
    at_radius, at_angle = anywhere(200)
    plain = local_weights(radius, angle, at_radius, at_angle)
    wrapped = np.angle(np.exp(1j * (angle + 2.5)))
    turned = local_weights(radius, wrapped, at_radius, at_angle + 2.5)
    for one, other in zip(plain, turned, strict=True):
        assert abs(one - other).max() < 1e-8 * abs(one).max()


def test_points_off_the_nodes_are_refused() -> None:
    radius, angle = scattered(6e-3)
    with pytest.raises(SquealError, match=r'r = 0\.19 m, theta = 0\.5 rad lies off the nodes'):
        local_weights(radius, angle, np.array([0.12, 0.19]), np.array([0.0, 0.5]))


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

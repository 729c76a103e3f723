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

"""Convergence rates of elements and quadrature against what theory says of each."""

from collections.abc import Callable, Iterable
from dataclasses import replace
import logging

import numpy as np
import pytest
import skfem
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.dimensions import Brake, Contact, Material, Pad
from squeal_core.common.arrays import FloatArray
from squeal_core.model import operators
from squeal_core.modes.fe import axisymmetric
from squeal_core.modes.fe.solid import pad_modes, sector_mesh
from squeal_core.modes.modal_basis import Quadrature
from squeal_core.modes.planar_mesh import sector_quadrature
from squeal_core.stability.eigensolution import complex_modes

STEEL = Material(young_modulus=210e9, density=7850.0, poisson_ratio=0.3)
NOTHING = np.array([], int)
ARRAYS = {'contact_stiffness': operators.contact_stiffness,
          'friction_couple': operators.friction_couple,
          'radial_dissipation': operators.radial_dissipation,
          'negative_slope': operators.negative_slope}


def rates(values: Iterable[FloatArray]) -> FloatArray:
    """Orders of convergence under halving of the mesh, one a triple of values."""
    steps = np.diff(np.array(list(values)), axis=0)
    return np.log2(steps[:-1] / steps[1:])


def section_frequencies(mesh: skfem.MeshQuad, order: int, material: Material, diameters: int,
                        clamp_radius: float | None = None) -> dict[str, FloatArray]:
    """Lowest frequencies [Hz] of one harmonic of a section, by half c and half s."""
    logging.getLogger('skfem').setLevel(logging.ERROR)  # it advises against P2 of ours
    basis = skfem.CellBasis(
        mesh, skfem.ElementVector(skfem.ElementQuadP(order), 3), intorder=2 * order)
    held = NOTHING if clamp_radius is None else basis.get_dofs(
        lambda x: np.isclose(x[0], clamp_radius)).all()
    found = axisymmetric._harmonic(
        basis, axisymmetric._stiffness_family(basis, material)(diameters),
        axisymmetric._mass(basis, material.density), held, diameters, 3)
    return {half: np.array([m.frequency for m in found if m.half == half]) for half in 'cs'}


# ---------------------------------------------------------------- disc

@pytest.mark.parametrize(('order', 'meshes'), [(1, 5), (2, 4)])
def test_smooth_ring(order: int, meshes: int) -> None:
    """
    A free ring of rectangular section, n = 2: frequencies converge like h^2p.

    Its free right-angled edges allow r^2 log r in u_theta and r^2.74 in the section plane, so
    orders one and two keep their full rates, 2 and 4.
    """
    found = [section_frequencies(
        skfem.MeshQuad.init_tensor(np.linspace(0.6, 1.0, 1 + 2 * 2**k),
                                   np.linspace(-0.1, 0.1, 1 + 2**k)),
        order, STEEL, 2)['c'][:2] for k in range(meshes)]
    # coarse meshes still climb to the rate (3.64 and 3.85 for order two)
    assert rates(found)[-1] == pytest.approx(2.0 * order, abs=0.4)
    assert np.all(np.diff(found, axis=0) < 0.0)  # Rayleigh: from above


def hat_frequencies(brake: Brake, order: int, meshes: int, half: str) -> list[FloatArray]:
    mesh = axisymmetric.hat_section(brake.disc, 0.03, 0)
    found = []
    for _ in range(meshes):
        found.append(section_frequencies(
            mesh, order, brake.disc.material, 0, brake.disc.clamp_radius)[half])
        mesh = mesh.refined()
    return found


def limit(values: FloatArray, order: float) -> float:
    """Where frequencies on halved meshes go."""
    return float(values[-1] - (values[-2] - values[-1]) / (2.0**order - 1.0))


def test_torsion_of_hat_feels_its_corners(  # type: ignore[no-untyped-def]  # noqa: E501
        brake: Brake, disc) -> None:
    """u_theta alone is a Laplace problem: r^(2/3) at a corner of 270 degrees, so h^(4/3)."""
    found = np.array(hat_frequencies(brake, 2, 5, 's'))[:, 0]
    assert rates(found)[1:] == pytest.approx(4.0 / 3.0, abs=0.04)
    torsion = disc.angular_frequencies[disc.names.index('disc (0,0)s')] / 2.0 / np.pi
    # layers towards the corners leave 4e-6; without them the finest mesh here is 9e-5 off
    assert torsion == pytest.approx(limit(found, 4.0 / 3.0), rel=1e-5)


def test_umbrella_of_hat_feels_its_corners(  # type: ignore[no-untyped-def]  # noqa: E501
        brake: Brake, disc) -> None:
    """Williams' r^0.5445 of an elastic corner of 270 degrees: h^1.089, whatever the order."""
    found = np.array(hat_frequencies(brake, 3, 4, 'c'))[:, 0]
    # the next term, h^1.5 of the clamped edge's right angles, and smooth h^6 raise it a little
    assert rates(found) == pytest.approx(1.089, abs=0.06)
    umbrella = disc.angular_frequencies[disc.names.index('disc (0,0)c')] / 2.0 / np.pi
    # 1.5e-3 are left, of the clamped edge's corners: no layers lead to them
    assert 0.0 < umbrella / limit(found, 1.089) - 1.0 < 2e-3


def test_grading_beats_even_refinement(brake: Brake) -> None:
    """Layers towards the corners: with fewer unknowns, lower, so nearer, frequencies."""
    def umbrella(mesh: skfem.MeshQuad) -> float:
        return float(section_frequencies(
            mesh, 3, brake.disc.material, 0, brake.disc.clamp_radius)['s'][0])

    even = axisymmetric.hat_section(brake.disc, 0.03, 0).refined(2)
    graded = axisymmetric.hat_section(brake.disc, 0.03, 2)
    assert graded.nelements < even.nelements
    assert umbrella(graded) - 1363.76 < 0.2 * (umbrella(even) - 1363.76)


# ---------------------------------------------------------------- pad

def test_pad_frequencies() -> None:
    """Quadratic hexahedra: h^4, on a block so stout that coarse meshes see it."""
    block = Contact(0.1, 0.142, np.deg2rad(24.0), 1e10)
    found = [pad_modes(Pad(STEEL, 0.02), block, 9, elements=n).angular_frequencies[6:]
             for n in ((2, 2, 1), (4, 4, 2), (8, 8, 4))]
    assert np.all(np.diff(found, axis=0) < 0.0)  # from above, though the curve is approximate
    # 3.2 to 3.7 on these meshes, still climbing
    assert np.all((rates(found) > 3.0) & (rates(found) < 4.3))


def test_pad_geometry(brake: Brake) -> None:
    """Mid-nodes on the true curve: the volume, hence the mass, converges like h^4."""
    def volume(n: int) -> float:
        mesh = sector_mesh(brake.contact, 0.0, brake.pad.thickness, (1, n, 1))
        return float(skfem.CellBasis(mesh, skfem.ElementHex2(), intorder=6).dx.sum())

    off = 1.0 - np.array([volume(n) for n in (3, 6, 12)]) / (
        brake.contact.area * brake.pad.thickness)
    assert np.log2(off[:-1] / off[1:]) == pytest.approx(4.0, abs=0.02)
    assert 0.0 < off[-1] < 2e-7


# ---------------------------------------------------------------- contact

def angular_error(rule: Callable[[int], tuple[FloatArray, FloatArray]], diameters: int,
                  points: Iterable[int], angle: float) -> FloatArray:
    """Relative errors of rules (angles, weights) for cos(diameters theta) over the sector."""
    exact = 2.0 * np.sin(0.5 * diameters * angle) / diameters
    return np.array([abs(w @ np.cos(diameters * t) / exact - 1.0) for t, w in map(rule, points)])


def test_contact_rule_is_spectral(brake: Brake) -> None:
    """Gauss, as used, against the midpoint rule (h^2) and K09's sums over nodes (h), eq. (40)."""
    angle, start = brake.contact.angle, -0.5 * brake.contact.angle

    def gauss(n: int) -> tuple[FloatArray, FloatArray]:
        q = sector_quadrature(brake.contact, 0.0, panels=(1, 1), points=n)
        return q.angle, q.weight / brake.contact.area * angle

    def midpoint(n: int) -> tuple[FloatArray, FloatArray]:
        return start + angle * (np.arange(n) + 0.5) / n, np.full(n, angle / n)

    def nodes(n: int) -> tuple[FloatArray, FloatArray]:
        return start + angle * np.arange(n + 1) / n, np.full(n + 1, angle / n)

    points = (8, 16, 32, 64)
    found = {rule: angular_error(rule, 11, points, angle) for rule in (gauss, midpoint, nodes)}
    order = {rule: np.log2(e[:-1] / e[1:]) for rule, e in found.items()}
    assert order[midpoint][1:] == pytest.approx(2.0, abs=0.02)
    assert order[nodes][1:] == pytest.approx(1.0, abs=0.1)
    d = 11.0 * angle / np.array(points)  # midpoint sums are exact but for (d/2) / sin(d/2)
    assert found[midpoint] == pytest.approx(0.5 * d / np.sin(0.5 * d) - 1.0, rel=1e-9)
    small = angular_error(gauss, 11, (4, 6, 8, 10, 12), angle)
    assert np.all(small[1:] < np.array([0.1, 0.05, 0.02, 0.01]) * small[:-1])  # ever faster
    # more panels of four points: h^8; the default resolves two modes with nine diameters
    default = sector_quadrature(brake.contact, 0.0)
    assert default.weight @ np.cos(18.0 * default.angle) == pytest.approx(
        brake.contact.area / angle * 2.0 * np.sin(9.0 * angle) / 18.0, rel=1e-8)


@pytest.mark.parametrize('points', [1, 2, 3])
def test_panels_converge_with_twice_their_points(points: int, brake: Brake) -> None:
    def value(panels: int) -> float:
        q = sector_quadrature(brake.contact, 0.0, panels=(panels, panels), points=points)
        return float(q.weight @ (np.cos(5.0 * q.angle) * np.exp(q.radius / 0.05)))

    order = rates(np.array([[value(n)] for n in (4, 8, 16)]))
    assert order == pytest.approx(2.0 * points, abs=0.2)  # still climbing from four panels


def test_contact_rule_over_radius(brake: Brake) -> None:
    """Weights hold the area; r^-1 of R0 and steep shapes are integrated to rounding."""
    q, c = sector_quadrature(brake.contact, 0.008), brake.contact
    for power in (-1, 0, 9):
        exact = c.angle * (c.outer_radius**(power + 2) - c.inner_radius**(power + 2)) / (power + 2)
        assert q.weight @ q.radius**power == pytest.approx(exact, rel=1e-13)
    assert np.all(q.height == 0.008)


def contact_arrays(rule: Callable[[float], Quadrature], brake: Brake,  # type: ignore[no-untyped-def]  # noqa: E501
                   disc, pad, sides: int = 2) -> dict[str, FloatArray]:
    """Arrays of both faces, or of the top one alone, which is cheaper and as telling."""
    half, faces = 0.5 * brake.disc.rotor_thickness, []
    for build, z, bottom in ((operators.top_face, half, half),
                             (operators.bottom_face, -half, -half - brake.pad.thickness))[:sides]:
        points = rule(z)
        shapes = replace(pad, offset=bottom).sample(points), disc.sample(points)
        faces.append(build(*shapes, len(pad.names)))
    return {name: function(faces) for name, function in ARRAYS.items()}


def element_rule(brake: Brake, disc, radial: int,  # type: ignore[no-untyped-def]  # noqa: E501
                 angular: int) -> Callable[[float], Quadrature]:
    """Gauss points in each element of the pad and of the disc, which shapes are smooth over."""
    c = brake.contact
    seams = np.unique(disc.basis.mesh.p[0])
    seams = seams[(seams > c.inner_radius) & (seams < c.outer_radius)]
    r, wr = panels(np.sort(np.r_[np.linspace(c.inner_radius, c.outer_radius, 10), seams]), radial)
    t, wt = panels(0.5 * c.angle * np.linspace(-1.0, 1.0, 19), angular)
    weight, angle = np.outer(wr * r, wt).ravel(), np.tile(t, r.size)
    return lambda z: Quadrature(np.repeat(r, t.size), angle, np.full(angle.shape, z), weight)


def panels(edges: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(points)
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    return (middle + half * x).ravel(), (half * w).ravel()


def worst(found: dict[str, FloatArray], exact: dict[str, FloatArray]) -> float:
    return max(float(np.abs(found[name] - a).max() / np.abs(a).max()) for name, a in exact.items())


def test_rules_by_element_converge(brake: Brake, disc, pad) -> None:  # type: ignore[no-untyped-def]  # noqa: E501
    """Pad shapes have kinks between elements: Gauss across them stops being spectral."""
    def arrays(rule: Callable[[float], Quadrature]) -> dict[str, FloatArray]:
        return contact_arrays(rule, brake, disc, pad, sides=1)

    exact = arrays(element_rule(brake, disc, 3, 4))  # to 3e-9, by 4 x 5 and 5 x 6 points
    coarse, fine = (worst(arrays(element_rule(brake, disc, n, n + 1)), exact) for n in (1, 2))
    assert fine < 1e-2 * coarse
    assert fine < 1e-4
    across = arrays(lambda z: sector_quadrature(brake.contact, z, panels=(1, 1), points=32))
    assert worst(across, exact) > 5.0 * fine  # with as many points as the fine rule has


def test_shipped_arrays_are_integrated(  # type: ignore[no-untyped-def]  # noqa: E501
        kang: BrakeModel, brake: Brake, disc, pad) -> None:
    exact = contact_arrays(element_rule(brake, disc, 3, 4), brake, disc, pad)
    # the shipped rule knows the pad's elements but not the disc's, whose kinks are P5's errors
    assert worst({name: getattr(kang, name) for name in ARRAYS}, exact) < 5e-7
    point = OperatingPoint(rotor_speed=5.0, friction=0.42, contact_stiffness=0.35e11,
                           contact_pressure=2000.0 / kang.contact_area)
    here, there = (complex_modes(m, point).unstable for m in (kang, replace(kang, **exact)))
    assert [m.index for m in here] == [m.index for m in there]
    for one, other in zip(here, there, strict=True):
        # 1e-7 of k_c A0 over 2 w; the mesh moves growth rates by 0.5 1/s
        assert one.eigenvalue == pytest.approx(other.eigenvalue, abs=1e-3)


@pytest.mark.parametrize(('elements', 'points'), [((6, 12, 2), 24), ((3, 6, 1), 30)])
def test_contact_points_need_not_fit_the_pad_mesh(
        elements: tuple[int, int, int], points: int, brake: Brake) -> None:
    """Also where they lie between an arc and its chord, which is 0.6 mm away at worst."""
    coarse = pad_modes(brake.pad, brake.contact, 7, elements=elements)
    q = sector_quadrature(brake.contact, 0.0, panels=(1, 1), points=points)
    s = coarse.sample(q)
    assert np.ptp(s.normal[3]) < 1e-9 * np.abs(s.normal[3]).max()  # lift lifts all alike
    x, y = q.radius * np.cos(q.angle), q.radius * np.sin(q.angle)
    spin_x = s.radial[2] * np.cos(q.angle) - s.tangential[2] * np.sin(q.angle)
    spin_y = s.radial[2] * np.sin(q.angle) + s.tangential[2] * np.cos(q.angle)
    for component, along in ((spin_x, y), (spin_y, x)):  # linear fields are held exactly
        straight = np.polynomial.Polynomial.fit(along, component, 1)(along)
        assert np.abs(component - straight).max() < 1e-9 * np.abs(component).max()

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

"""Finite elements against frequencies and integrals that can be written down: discs, pads."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import iv, ivp, jv, jvp, kv, kvp, yv, yvp
import skfem
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Brake, Contact, Material, Pad
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.fe import axisymmetric
from squeal_core.modes.fe.solid import pad_modes
from squeal_core.modes.modal_basis import Quadrature

STEEL = Material(young_modulus=210e9, density=7850.0, poisson_ratio=0.3)
FIELDS = ('radial', 'tangential', 'normal')


# ---------------------------------------------------------------- a spinning disc

def disc_volume(disc: axisymmetric.HarmonicModes, count: int) -> list[Quadrature]:
    """Gauss rules on the section's rectangles, exact for products of two P5 fields, per angle."""
    x, w = np.polynomial.legendre.leggauss(6)
    low, high = (f(disc.basis.mesh.p[:, disc.basis.mesh.t], axis=1) for f in (np.min, np.max))
    (r, z), half = 0.5 * (low + high)[..., None] + 0.5 * (high - low)[..., None] * x, high - low
    radius = np.repeat(r, 6, axis=1).ravel()
    weight = (np.outer(w, w).ravel() * (0.25 * half[0] * half[1])[:, None]).ravel()
    return [Quadrature(radius, np.full(radius.shape, angle), np.tile(z, 6).ravel(),
                       weight * radius * 2.0 * np.pi / count)
            for angle in 2.0 * np.pi * np.arange(count) / count]


def test_disc_arrays_by_other_integration(disc: axisymmetric.HarmonicModes,
                                          kang: BrakeModel) -> None:
    """Modes below 3 kHz on a tensor grid, derivatives by Fourier transform: unit masses, G0."""
    low = replace(disc, section_modes=disc.section_modes[:17])
    around = disc_volume(low, 12)  # products have up to 8 diameters: no aliasing below 12
    layers = [low.sample(q) for q in around]
    fields = [np.array([getattr(s, name) for s in layers]) for name in FIELDS]
    order = np.fft.fftfreq(12, 1.0 / 12.0)[:, None, None]
    turned = [np.fft.ifft(1j * order * np.fft.fft(f, axis=0), axis=0).real for f in fields]
    for name, found in zip(FIELDS, turned, strict=True):
        given_ = np.array([getattr(s, f'{name}_dtheta') for s in layers])
        assert np.abs(given_ - found).max() < 1e-12 * np.abs(found).max()  # rounding
    weight = low.density * np.array([q.weight for q in around])
    over = lambda a, b: np.einsum('kq,kmq,knq->mn', weight, a, b, optimize=True)  # noqa: E731
    (u, v, w), (du, dv, dw) = fields, turned
    in_plane, p = over(u, u) + over(v, v), over(u, du - v) + over(v, dv + u) + over(w, dw)
    # the FE arrays and these sums integrate the same polynomials: rounding only
    assert np.abs(in_plane + over(w, w) - np.eye(17)).max() < 1e-10
    g = kang.gyroscopic[20:37, 20:37]
    assert np.abs(p - p.T - g).max() < 1e-10
    first = [i for i, m in enumerate(low.section_modes) if m.half == 'c' and m.diameters]
    # g = 2 n + 4 pi rho int U V r dr dz; at theta = 0 U is in half c and -V in half s
    extra = [-2.0 * 12 * weight[0] @ (u[0, i] * v[0, i + 1]) for i in first]
    diameters = [low.section_modes[i].diameters for i in first]
    assert np.allclose([g[i, i + 1] for i in first], np.add(np.multiply(2, diameters), extra),
                       rtol=0, atol=1e-10)
    # so a mode turns like a transverse one but for its in-plane mass: 2 U V <= U^2 + V^2
    assert np.all(np.abs(extra) <= 2.0 * np.diag(in_plane)[first])
    assert np.min(np.abs(extra)) < 0.06 < 1.0 < np.max(np.abs(extra))


# ---------------------------------------------------------------- thin annulus

def annulus_frequency(thickness: float, diameters: int, clamped: bool) -> float:
    """Lowest frequency [Hz] of 0.5 <= r <= 1 from the disc's harmonics on a plain rectangle."""
    ends = np.array([0.0, 1.0, 3.0]) * thickness  # free edges have a layer of one thickness
    radii = np.concatenate([0.5 + ends, np.linspace(0.5, 1.0, 9)[1:-1], 1.0 - ends[::-1]])
    mesh = skfem.MeshQuad.init_tensor(radii, thickness * np.array([-0.5, 0.5]))
    basis = skfem.CellBasis(mesh, skfem.ElementVector(skfem.ElementQuadP(3), 3), intorder=6)
    mass = axisymmetric._mass(basis, STEEL.density)
    held = basis.get_dofs(lambda x: np.isclose(x[0], 0.5)).all() if clamped else np.array([], int)
    stiffness = axisymmetric._stiffness_family(basis, STEEL)(diameters)
    return min(m.frequency for m in axisymmetric._harmonic(
        basis, stiffness, mass, held, diameters, 2))


def kirchhoff(diameters: int, clamped: bool) -> float:
    """Frequency over thickness [Hz/m] of the thin plate: root of the 4 x 4 determinant."""
    n, nu = diameters, STEEL.poisson_ratio
    pairs = ((jv, jvp, -1.0), (yv, yvp, -1.0), (iv, ivp, 1.0), (kv, kvp, 1.0))

    def edge(k: float, r: float, held: bool) -> FloatArray:
        rows = []
        for f, df, sign in pairs:
            w, dw, d2w = f(n, k * r), k * df(n, k * r), k**2 * df(n, k * r, 2)
            moment = d2w + nu * (dw / r - (n / r)**2 * w)
            shear = sign * k**2 * dw - (1.0 - nu) * n**2 / r**2 * (dw - w / r)
            rows.append((w, dw) if held else (moment, shear))
        return np.array(rows).T

    def determinant(k: float) -> float:
        a = np.vstack([edge(k, 0.5, clamped), edge(k, 1.0, False)])
        a /= np.abs(a).max(axis=1)[:, None]
        return float(np.linalg.det(a / np.abs(a).max(axis=0)))

    k = first_root(determinant, 1.0, 8.0)
    rigidity = STEEL.young_modulus / 12.0 / (1.0 - nu**2)
    return k**2 * float(np.sqrt(rigidity / STEEL.density)) / 2.0 / np.pi


def first_root(function: Callable[[float], float], start: float, stop: float) -> float:
    grid = np.linspace(start, stop, 200)
    signs = np.sign([function(x) for x in grid])
    i = int(np.flatnonzero(signs[1:] != signs[:-1])[0])
    return float(brentq(function, grid[i], grid[i + 1]))


@pytest.mark.parametrize(('diameters', 'clamped'), [(2, False), (3, False), (0, True), (2, True)])
def test_annulus_becomes_kirchhoffs(diameters: int, clamped: bool) -> None:
    """Three-dimensional theory is off Kirchhoff's by c1 h (edge layers) + c2 h^2 (shear)."""
    thickness = np.array([1 / 50, 1 / 100, 1 / 200])
    off = np.array([annulus_frequency(h, diameters, clamped) / h for h in thickness])
    off = off / kirchhoff(diameters, clamped) - 1.0
    assert np.all(np.abs(off) < 0.2 * thickness)
    if not clamped:  # a twisted free edge of a solid is softer, as if h / 3 narrower
        assert np.all(off < 0)
        assert off[0] / off[1] == pytest.approx(2.15, abs=0.15)
    once = 2.0 * off[1:] - off[:-1]
    twice = (4.0 * once[1] - once[0]) / 3.0
    assert abs(once[1]) < 4e-4  # c2 h^2 is left
    # h^3 is left, and P3 rectangles at the clamped edge, whose corners are singular
    assert abs(twice) < (1e-4 if clamped else 5e-6)


# ---------------------------------------------------------------- free pad and beam

def test_pad_rigid_modes(pad, brake: Brake) -> None:  # type: ignore[no-untyped-def]
    """Exact zeros; mass and inertia of an annular sector, by Gauss in r, theta, z."""
    assert np.array_equal(pad.angular_frequencies[:6], np.zeros(6))
    assert np.all(pad.angular_frequencies[6:] > 2e4)
    contact, h, rho = brake.contact, brake.pad.thickness, brake.pad.material.density
    x, w = np.polynomial.legendre.leggauss(8)
    r, t, z = np.meshgrid(0.121 + 0.021 * x, 0.5 * contact.angle * x, 0.5 * h * (1 + x))
    wr, wt, wz = np.meshgrid(0.021 * w, 0.5 * contact.angle * w, 0.5 * h * w)
    q = Quadrature(*(a.ravel() for a in (r, t, z, wr * wt * wz * r)))
    s = replace(pad, shapes=pad.shapes[:6], names=pad.names[:6]).sample(q)
    product = sum((f * rho * q.weight) @ f.T for f in (s.radial, s.tangential, s.normal))
    # second-order curves miss the sector's volume by 3e-8, its moments by 1e-7
    assert np.abs(product - np.eye(6)).max() < 3e-7
    mass = rho * h * contact.area
    assert s.normal[3].mean()**-2 == pytest.approx(mass, rel=1e-7)
    assert np.ptp(s.normal[3]) < 1e-9 * abs(s.normal[3, 0])  # lift lifts every point alike
    flexible = pad.shapes[:6] @ (skfem.asm(_mass_form, pad.basis) * rho) @ pad.shapes[6:].T
    assert np.abs(flexible).max() < 1e-10


@skfem.BilinearForm
def _mass_form(u, v, _):  # type: ignore[no-untyped-def]
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def timoshenko(length: float, depth: float, width: float) -> float:
    """First bending frequency [Hz] of a free beam (Huang 1961, shear coefficient of Cowper)."""
    nu, e, rho = STEEL.poisson_ratio, STEEL.young_modulus, STEEL.density
    area, inertia = width * depth, width * depth**3 / 12.0
    r2 = inertia / area / length**2
    s2 = r2 * 2.0 * (1.0 + nu) * (12.0 + 11.0 * nu) / 10.0 / (1.0 + nu)

    def determinant(b: float) -> float:
        root = np.sqrt((r2 - s2)**2 + 4.0 / b**2)
        alpha, beta = (b * np.sqrt(0.5 * (root + sign * (r2 + s2))) for sign in (-1, 1))
        cross = b**2 * r2 * (r2 - s2)**2 + 3.0 * r2 - s2
        return float(2.0 - 2.0 * np.cosh(alpha) * np.cos(beta) + b * cross / np.sqrt(
            1.0 - b**2 * r2 * s2) * np.sinh(alpha) * np.sin(beta))

    b = first_root(determinant, 15.0, 22.4)
    return b * float(np.sqrt(e * inertia / rho / area)) / length**2 / 2.0 / np.pi


@pytest.mark.parametrize('length', [0.1, 0.15])
def test_slender_pad_is_a_timoshenko_beam(length: float) -> None:
    """A sector of 50 m radius; 1 % below Euler and Bernoulli, 0.05 % from Timoshenko."""
    wide, thick = 0.01, 0.005
    sector = Contact(50.0 - wide / 2, 50.0 + wide / 2, length / 50.0, 1e10)
    found = pad_modes(Pad(STEEL, thick), sector, 9, elements=(2, 24, 2)).angular_frequencies[6:8]
    for f, depth, width in zip(found / 2 / np.pi, (thick, wide), (wide, thick), strict=True):
        euler = 4.730040744862704**2 / 2 / np.pi / length**2 * np.sqrt(
            STEEL.young_modulus / STEEL.density / 12.0) * depth
        # anticlastic bending and Q2 elements 1 to 3 depths long leave 5e-4
        assert f == pytest.approx(timoshenko(length, depth, width), rel=5e-4)
        assert 0.3 * (depth / length)**2 < 1.0 - f / euler < 4.0 * (depth / length)**2

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

"""
Disc modes from the axisymmetric section: Fourier harmonics in theta, exact doublets.

Each mode has n nodal diameters and a section shape (U, V, W)(r, z). Its two halves are

    c:  u_r = U cos(n theta),  u_theta =  V sin(n theta),  u_z = W cos(n theta)
    s:  u_r = U sin(n theta),  u_theta = -V cos(n theta),  u_z = W sin(n theta)

so a doublet is exact, and so are derivatives in theta. For n = 0, U and W (umbrella modes) live
in half c alone, and V (torsion) in half s alone.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

try:
    import skfem
except ImportError as error:
    raise ImportError(
        "finite element modes need scikit-fem: pip install -e '.[fe]' in the checkout") from error

from squeal_core.brake.dimensions import HatDisc, Material
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.fe.eigen import gathered
from squeal_core.modes.fe.mode_cache import content_key, remembered
from squeal_core.modes.modal_basis import keep_whole_doublets, Quadrature, SampledShapes

_DIGITS = 12  # of a place in the section [m]
_GRADING = 0.15  # ratio of neighbouring elements towards a re-entrant corner: hp theory's choice


@dataclass(frozen=True)
class _SectionMode:
    frequency: float
    diameters: int
    family: int
    half: str
    shape: FloatArray


@dataclass(frozen=True)
class HarmonicModes:
    """Modes of a disc of revolution; a `ModalBasis`. Make it with `disc_modes`."""

    basis: skfem.CellBasis
    density: float
    section_modes: tuple[_SectionMode, ...]

    @property
    def angular_frequencies(self) -> FloatArray:
        return 2.0 * np.pi * np.array([m.frequency for m in self.section_modes])

    @property
    def names(self) -> tuple[str, ...]:
        """`disc (n,m)c`: n nodal diameters, m-th family, half c or s."""
        return tuple(f'disc ({m.diameters},{m.family}){m.half}' for m in self.section_modes)

    def sample(self, points: Quadrature) -> SampledShapes:
        # as the mesh is: a face may lie a last bit outside of it
        section = np.vstack([points.radius, points.height]).round(_DIGITS)
        unique, place = np.unique(section, axis=1, return_inverse=True)
        shapes = np.array([m.shape for m in self.section_modes])
        probe = self.basis.split_bases()[0].probes(unique)
        u, v, w = ((probe @ shapes[:, dofs].T).T[:, place.ravel()]
                   for dofs in self.basis.split_indices())
        return self._turn(u, v, w, points)

    def volume_layers(self) -> Iterator[SampledShapes]:
        """
        Yield samples that together integrate products of two modes over the volume exactly.

        One section at a time: the trapezoidal rule in theta is exact for trigonometric products
        once it has more than twice as many points as nodal diameters.
        """
        shapes = np.array([m.shape for m in self.section_modes])
        u, v, w = np.stack([np.asarray(self.basis.interpolate(x)).reshape(3, -1)
                            for x in shapes]).swapaxes(0, 1)
        (r, z), dx = self.basis.global_coordinates().value.reshape(2, -1), self.basis.dx.ravel()
        count = 2 * max(m.diameters for m in self.section_modes) + 2
        for angle in 2.0 * np.pi * np.arange(count) / count:
            points = Quadrature(r, np.full(r.shape, angle), z, dx * r * 2.0 * np.pi / count)
            yield self._turn(u, v, w, points)

    def _turn(self, u: FloatArray, v: FloatArray, w: FloatArray,
              points: Quadrature) -> SampledShapes:
        n = np.array([m.diameters for m in self.section_modes])[:, None]
        is_s = np.array([m.half == 's' for m in self.section_modes])[:, None]
        c, s = np.cos(n * points.angle), np.sin(n * points.angle)
        even, odd = np.where(is_s, s, c), np.where(is_s, -c, s)  # d even = -n odd, d odd = n even
        return SampledShapes(
            radial=u * even, tangential=v * odd, normal=w * even,
            radial_dtheta=-n * u * odd, tangential_dtheta=n * v * even,
            normal_dtheta=-n * w * odd, points=points)


def disc_modes(disc: HatDisc, count: int, *, order: int = 4, element_size: float = 0.03,
               corner_layers: int = 2, cache: str | Path | None = None) -> HarmonicModes:
    """
    Return at least `count` lowest modes of a clamped hat disc, no doublet cut in two.

    Parameters
    ----------
    disc : HatDisc
        Dimensions and material.
    count : int
        Number of modes wanted; one more is kept where a doublet would be cut.
    order : int
        Polynomial order of the quadrilaterals.
    element_size : float
        Largest element edge [m].
    corner_layers : int
        Geometric layers of elements towards the hat's re-entrant corners and the clamp.
    cache : path, optional
        Folder that keeps solutions (`resources.cache_folder()`); None keeps none.

    """
    basis = skfem.CellBasis(
        hat_section(disc, element_size, corner_layers),
        skfem.ElementVector(skfem.ElementQuadP(order), 3), intorder=2 * order)
    clamped = basis.get_dofs(lambda x: np.isclose(x[0], disc.clamp_radius)).all()

    def solve() -> tuple[FloatArray, FloatArray]:
        result = _lowest(basis, disc.material, clamped, count)[:count + 1]
        return (np.array([m.frequency for m in result]),
                np.array([[m.diameters, m.family, m.half == 's', *m.shape] for m in result]))

    material = disc.material
    key = content_key(
        places=basis.mesh.p, cells=basis.mesh.t, clamped=clamped, count=count,
        element=f'{type(basis.elem).__name__} {order} {basis.N}', material=[
            material.young_modulus, material.density, material.poisson_ratio])
    frequencies, rows = remembered(cache, key, (count + 1, basis.N + 3), solve)
    kept = keep_whole_doublets(frequencies, count)
    return HarmonicModes(basis, material.density, tuple(
        _SectionMode(frequency, int(row[0]), int(row[1]), 's' if row[2] else 'c', row[3:])
        for frequency, row in zip(frequencies[:kept].tolist(), rows, strict=False)))


def hat_section(disc: HatDisc, element_size: float, layers: int = 2) -> skfem.MeshQuad:
    """Return the section's mesh of rectangles: rotor plate, hat wall, top plate."""
    half = 0.5 * disc.rotor_thickness
    top = half + disc.hat_height
    plate = top - disc.top_plate_thickness
    inner, outer = disc.hat_wall_inner_radius, disc.hat_wall_outer_radius
    mesh = skfem.MeshQuad.init_tensor(
        _graded((disc.clamp_radius, inner, outer, disc.rotor_outer_radius), element_size, layers,
                smooth=disc.rotor_outer_radius),
        _graded((-half, half, plate, top), element_size, layers, smooth=-half))
    r, z = mesh.p[:, mesh.t].mean(axis=1)
    rotor, wall, top_plate = z < half, (r > inner) & (r < outer), (z > plate) & (r < outer)
    return mesh.restrict(np.flatnonzero((rotor & (r > inner)) | wall | top_plate))


def _graded(corners: tuple[float, ...], element_size: float, layers: int,
            smooth: float) -> FloatArray:
    """
    Divide between corners evenly, then geometrically towards each, the smooth end left out.

    Stress is singular at the re-entrant corners and at the clamp's edges.
    """
    spans = [np.linspace(a, b, 1 + max(1, int(np.ceil((b - a) / element_size))))
             for a, b in zip(corners, corners[1:], strict=False)]
    steps = _GRADING ** np.arange(1, layers + 1)
    cuts = list(spans)
    for span in spans:
        for corner, neighbour in ((span[0], span[1]), (span[-1], span[-2])):
            if corner != smooth:
                cuts.append(corner + (neighbour - corner) * steps)
    return np.unique(np.concatenate(cuts).round(_DIGITS))


def _lowest(basis: skfem.CellBasis, material: Material, clamped: FloatArray,
            count: int) -> list[_SectionMode]:
    """Return all modes up to the one after the count-th, of as many harmonics as reach there."""
    mass = _mass(basis, material.density)
    stiffness = _stiffness_family(basis, material)
    each = 1 + count // 4
    while True:
        modes: list[_SectionMode] = []
        lowest: list[float] = [0.0]
        highest: list[float] = []
        while len(modes) <= count or lowest[-1] <= modes[count].frequency:
            n = len(highest)
            new = _harmonic(basis, stiffness(n), mass, clamped, n, each)
            lowest.append(new[0].frequency)
            highest.append(new[-1].frequency)
            modes = sorted(modes + new, key=lambda m: (round(m.frequency, 6), m.half))
        if min(highest) > modes[count].frequency:
            return modes
        each *= 2  # a harmonic has more modes below the cut than were asked for


def _mass(basis: skfem.CellBasis, density: float) -> Any:
    """Return the sparse mass matrix [kg/rad], all element matrices at once."""
    values = np.array([np.asarray(field[0]) for field in basis.basis]).swapaxes(0, 1)
    return density * gathered(basis, _products(basis, values, values))


def _stiffness_family(basis: skfem.CellBasis, material: Material) -> Callable[[int], Any]:
    """Return n -> K(n) = K0 + n K1 + n^2 K2, as strains are linear in n."""
    fixed = _strains(basis, 0.0)
    turned = _strains(basis, 1.0) - fixed

    def block(first: FloatArray, second: FloatArray) -> Any:
        return gathered(basis, _products(basis, first, _stresses(second, material)))

    zero, square = block(fixed, fixed), block(turned, turned)
    linear = block(fixed, turned)
    linear = linear + linear.T
    return lambda n: zero + n * linear + n**2 * square


def _strains(basis: skfem.CellBasis, n: float) -> FloatArray:
    """
    Return strains (6, functions, E, Q) of the basis functions.

    Amplitudes of e_rr, e_tt, e_zz, g_rz (with cos n theta) and of g_rt, g_tz (with sin).
    """
    r = basis.global_coordinates().value[0]
    radial, tangential, axial = np.array(
        [np.asarray(field[0]) for field in basis.basis]).swapaxes(0, 1)
    u, v, w = np.array([field[0].grad for field in basis.basis]).transpose(1, 2, 0, 3, 4)
    return np.array([u[0], (n * tangential + radial) / r, w[1], u[1] + w[0],
                     v[0] - (tangential + n * radial) / r, v[1] - n * axial / r])


def _stresses(strains: FloatArray, material: Material) -> FloatArray:
    e, nu = material.young_modulus, material.poisson_ratio
    lame, shear = e * nu / (1 + nu) / (1 - 2 * nu), e / 2 / (1 + nu)
    direct = 2.0 * shear * strains[:3] + lame * strains[:3].sum(axis=0)
    return np.concatenate([direct, shear * strains[3:]])


def _products(basis: skfem.CellBasis, first: FloatArray, second: FloatArray) -> FloatArray:
    """Return integrals (E, functions, functions) over r dr dz of (components, functions, E, Q)."""
    weight = basis.dx * basis.global_coordinates().value[0]
    one, other = (np.moveaxis(field, (2, 1), (0, 1)).reshape(*field.shape[2:0:-1], -1)
                  for field in (first * weight, second))
    return np.asarray(one @ other.swapaxes(1, 2))


def _harmonic(basis: skfem.CellBasis, stiffness: Any, mass: Any, clamped: FloatArray,
              n: int, count: int) -> list[_SectionMode]:
    """Solve one harmonic; both halves of each mode, mass normalised over the volume."""
    squares, shapes = skfem.solve(
        *skfem.condense(stiffness, mass, D=clamped),
        solver=skfem.solver_eigen_scipy_sym(k=count, sigma=0.0, v0=np.ones(
            mass.shape[0] - clamped.size)))
    around = np.pi if n else 2.0 * np.pi
    modes, families = [], dict.fromkeys('cs', 0)
    tangential = basis.split_indices()[1]
    for square, x in sorted(zip(squares, shapes.T, strict=True), key=lambda pair: pair[0]):
        halves = 'cs' if n else ('s' if _dominates(x, tangential) else 'c')
        for half in halves:
            modes.append(_SectionMode(
                float(np.sqrt(square) / 2.0 / np.pi), n, families[half], half,
                x / np.sqrt(around * (x @ (mass @ x)))))
            families[half] += 1
    return modes


def _dominates(x: FloatArray, part: FloatArray) -> bool:
    return float(np.abs(x[part]).max()) > 0.5 * float(np.abs(x).max())

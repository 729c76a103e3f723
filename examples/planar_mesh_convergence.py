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
Measure the uniform planar-mesh method: as printed, as it should be, and on irregular nodes.

Run: python examples/planar_mesh_convergence.py [--quick] [PNG]; prints the tables of
docs/explanation/planar_mesh.md and draws its picture.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Iterable, Mapping  # noqa: I100
from dataclasses import replace
import sys
from typing import Any

import numpy as np

from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.brake.dimensions import Brake, HatDisc
from squeal_core.common import resources
from squeal_core.common.arrays import FloatArray
from squeal_core.model import operators
from squeal_core.modes.fe.axisymmetric import disc_modes
from squeal_core.modes.fe.meshes import hat_disc_mesh
from squeal_core.modes.fe.solid import at_radius, pad_modes, solid_modes, SolidModes
from squeal_core.modes.modal_basis import modal_assurance, ModalBasis, Quadrature, SampledShapes
from squeal_core.modes.planar_mesh import (
    contact_grid,
    Layer,
    LayeredBasis,
    PlanarGrid,
    PlanarModes,
    sector_quadrature,
)
from squeal_core.stability.eigensolution import complex_modes, Mode

ARRAYS = {'A0': ('contact_stiffness', operators.contact_stiffness),
          'B0': ('friction_couple', operators.friction_couple),
          'R0': ('radial_dissipation', operators.radial_dissipation),
          'S0': ('negative_slope', operators.negative_slope),
          'F0': ('follower', operators.follower)}
# contact grid, points across the disc, points round it, layers a part
UNIFORM = (((8, 22), 10, 122, 2), ((15, 43), 20, 244, 4), ((20, 57), 27, 325, 5),
           ((29, 85), 40, 488, 8), ((43, 125), 60, 732, 12))
GAUSS = (((4, 4), 4, 24, 1), ((4, 8), 4, 32, 1), ((8, 16), 8, 48, 2), ((16, 32), 8, 64, 2),
         ((36, 72), 12, 96, 4))  # the last is the default
RULES: dict[str, tuple[Any, dict[str, Any], float]] = {
    'as printed': (UNIFORM, {'rule': 'nodes', 'derivative': 'forward'}, 1.0),
    'midpoint': (UNIFORM, {'rule': 'midpoint', 'derivative': 'central'}, 2.0),
    'Gauss': (GAUSS, {'rule': 'gauss', 'derivative': 'spectral'}, 0.0)}
DERIVATIVES = ('forward', 'central', 'spectral')
STEPS = (48, 96, 244)  # points round the disc
MESHES = (20, 28, 40, 60)  # elements round the disc
GRID = PlanarGrid()  # that modes are carried to from irregular nodes


def main(arguments: list[str]) -> None:
    from squeal_core.view.mesh_convergence import MeshRefinement, plot_mesh_convergence

    quick = '--quick' in arguments
    brake = read_brake(resources.config_folder() / 'brakes' / 'kang2009.yaml')
    disc = disc_modes(brake.disc, brake.disc_modes)
    pad = pad_modes(brake.pads[0], brake.contact, brake.pad_modes)
    exact = exact_arrays(brake, disc, pad)
    truth = largest_growth(brake, disc, pad, exact)
    titles = {'as printed': 'as printed\nsums over nodes, forward difference',
              'midpoint': 'midpoint\nequal cells, central difference',
              'Gauss': 'Gauss\npanels of four points, spectral derivative'}
    rules = []
    print('| rule | contact | disc r, theta | ' + ' | '.join(['G0', *ARRAYS]) + ' | 1/s |')
    print('|' + '---|' * 10)
    for name, (ladder, settings, order) in RULES.items():
        rows, growth = [], []
        for contact, radial, around, parts in ladder[:2] if quick else ladder:
            grid = PlanarGrid(radial, around, contact, **settings)
            found = grid_arrays(brake, disc, pad, grid, parts)
            rows.append(errors(found, exact))
            growth.append(largest_growth(brake, disc, pad, found))
            print(f'| {name} | {contact[0]} x {contact[1]} | {radial} x {around} | '
                  + ' | '.join(f'{e:.1e}' for e in rows[-1].values()) + f' | {growth[-1]:.1f} |')
        rules.append(MeshRefinement(titles[name], [row[0][1] for row in ladder[:len(rows)]],
                                    columns(rows), growth, order))
    print(f'\nrelative errors in the Frobenius norm; the growth rate is {truth:.2f} 1/s\n')
    derivative_errors(brake, disc, pad, exact, STEPS[:1] if quick else STEPS)
    rows = irregular_errors(brake, pad, MESHES[:2] if quick else MESHES)
    plot_mesh_convergence(rules, MeshRefinement(
        'modes from irregular nodes, default grid\nagainst exact integrals over the elements',
        [2 * around for around in MESHES[:len(rows)]], columns(rows)),
        next((a for a in arguments if a.endswith('.png')), 'planar_mesh.png'), growth_rate=truth)
    if not quick:
        against_axisymmetric(brake, pad, exact)


def columns(rows: list[dict[str, float]]) -> dict[str, list[float]]:
    return {name: [row[name] for row in rows] for name in rows[0]}


def hat_layers(disc: HatDisc, parts: int) -> tuple[Layer, ...]:
    """Return planes of a hat disc: `parts` slabs in each of rotor, wall and top plate."""
    half = 0.5 * disc.rotor_thickness
    top = half + disc.hat_height
    plate = top - disc.top_plate_thickness
    inner, outer = disc.hat_wall_inner_radius, disc.hat_wall_outer_radius
    inside = 1e-9  # nearer to the middle than rounding puts a point off the section's mesh
    return tuple(Layer(float(z), r + inside, s - inside) for r, s, heights in (
        (inner, disc.rotor_outer_radius, np.linspace(inside - half, half - inside, parts + 1)),
        (inner, outer, np.linspace(half, plate, parts + 1)[1:-1]),
        (disc.clamp_radius, outer, np.linspace(plate + inside, top - inside, parts + 1)))
        for z in heights)


def faces(brake: Brake, discs: Iterable[SampledShapes], pad: Any) -> list[operators.ContactFace]:
    """Return both contact faces, of the disc's shapes on its top and on its bottom."""
    top, bottom = discs
    half, count = 0.5 * brake.disc.rotor_thickness, len(pad.names)
    above = replace(pad, offset=half).sample(top.points)
    below = replace(pad, offset=-half - brake.pads[1].thickness).sample(bottom.points)
    return [operators.top_face(above, top, count), operators.bottom_face(below, bottom, count)]


def arrays(brake: Brake, disc: Any, pad: Any, points: Iterable[Quadrature],
           layers: Iterable[SampledShapes]) -> dict[str, FloatArray]:
    both = faces(brake, (disc.sample(q) for q in points), pad)
    return {'G0': operators.gyroscopic(layers, brake.disc.material.density),
            **{name: function(both) for name, (_, function) in ARRAYS.items()}}


def exact_arrays(brake: Brake, disc: Any, pad: Any,
                 panels: tuple[int, int] = (18, 36)) -> dict[str, FloatArray]:
    """Return arrays of modes that know their own volume, by a fine Gauss rule on the contact."""
    half = 0.5 * brake.disc.rotor_thickness
    return arrays(brake, disc, pad, [sector_quadrature(brake.contact, z, panels=panels)
                                     for z in (half, -half)], disc.volume_layers())


def grid_arrays(brake: Brake, disc: ModalBasis, pad: Any, grid: PlanarGrid,
                parts: int) -> dict[str, FloatArray]:
    """Return arrays of exact shapes on a planar grid: the error is the grid's alone."""
    return planar_arrays(
        brake, PlanarModes(LayeredBasis(disc, hat_layers(brake.disc, parts)), grid), pad)


def planar_arrays(brake: Brake, disc: PlanarModes, pad: Any) -> dict[str, FloatArray]:
    half = 0.5 * brake.disc.rotor_thickness
    return arrays(brake, disc, pad, [contact_grid(brake.contact, z, disc.grid)
                                     for z in (half, -half)], disc.volume_layers())


def errors(found: Mapping[str, FloatArray], exact: Mapping[str, FloatArray]) -> dict[str, float]:
    """Return relative errors in the Frobenius norm."""
    return {name: float(np.linalg.norm(found[name] - a) / np.linalg.norm(a))
            for name, a in exact.items()}


def derivative_errors(brake: Brake, disc: ModalBasis, pad: Any, exact: Mapping[str, FloatArray],
                      steps: Iterable[int]) -> None:
    """Print what derivatives alone do: exact shapes, sums by Gauss."""
    print('| points round the disc | ' + ' | '.join(
        f'{name}, {derivative}' for name in ('G0', 'F0') for derivative in DERIVATIVES) + ' |')
    print('|' + '---|' * (1 + 2 * len(DERIVATIVES)))
    for around in steps:
        off = [errors(grid_arrays(brake, disc, pad, replace(
            GRID, around=around, derivative=derivative), 2), exact)  # type: ignore[arg-type]
            for derivative in DERIVATIVES]
        print(f'| {around} | ' + ' | '.join(
            f'{row[name]:.1e}' for name in ('G0', 'F0') for row in off) + ' |')
    print()


def model(brake: Brake, disc: Any, pad: Any, found: Mapping[str, FloatArray]) -> BrakeModel:
    own = {field: found[name] for name, (field, _) in ARRAYS.items() if name != 'F0'}
    return BrakeModel(
        angular_frequencies=np.concatenate([
            pad.angular_frequencies, disc.angular_frequencies, pad.angular_frequencies]),
        damping_ratios=brake.damping_ratio,
        gyroscopic=np.pad(found['G0'], len(pad.names)), **own)


def operating_point(brake: Brake, rotor_speed: float = 5.0) -> OperatingPoint:
    """Return K09's: mu = 0.42, a preload of 2000 N."""
    return OperatingPoint(
        rotor_speed=rotor_speed, friction=0.42, contact_stiffness=brake.contact.stiffness,
        contact_pressure=2000.0 / brake.contact.area)


def unstable(brake: Brake, disc: Any, pad: Any, found: Mapping[str, FloatArray],
             rotor_speed: float = 5.0) -> tuple[Mode, ...]:
    return complex_modes(model(brake, disc, pad, found),
                         operating_point(brake, rotor_speed)).unstable


def largest_growth(brake: Brake, disc: Any, pad: Any, found: Mapping[str, FloatArray]) -> float:
    return max((mode.growth_rate for mode in unstable(brake, disc, pad, found)), default=0.0)


def irregular_disc(brake: Brake, count: int, around: int, *, irregularity: float = 0.5,
                   **mesh: Any) -> SolidModes:
    """Return modes of the disc on hexahedra whose nodes are moved at random within layers."""
    return solid_modes(
        hat_disc_mesh(brake.disc, around=around, irregularity=irregularity, **mesh),
        brake.disc.material, count, clamped=at_radius(brake.disc.clamp_radius),
        progress=lambda text: print(f'  {text}', file=sys.stderr))


def irregular_errors(brake: Brake, pad: Any, meshes: Iterable[int]) -> list[dict[str, float]]:
    """Return errors of the default grid fed from nodes, against integrals over the elements."""
    rows = []
    print('| nodes round the disc | unknowns | ' + ' | '.join(['G0', *ARRAYS]) + ' |')
    print('|' + '---|' * 8)
    for around in meshes:
        solid = irregular_disc(brake, brake.disc_modes + 1, around)
        rows.append(errors(planar_arrays(brake, PlanarModes.from_nodal(solid.nodal(), GRID), pad),
                           exact_arrays(brake, solid, pad)))
        print(f'| {2 * around} | {solid.basis.N} | '
              + ' | '.join(f'{e:.1e}' for e in rows[-1].values()) + ' |')
    return rows


def against_axisymmetric(brake: Brake, pad: Any, exact: Mapping[str, FloatArray]) -> None:
    """Print how modes on a fine irregular mesh, carried to the grid, compare with harmonics."""
    reference = disc_modes(brake.disc, brake.disc_modes)
    solid = irregular_disc(brake, len(reference.names), 64, irregularity=0.3,
                           element_size=0.0078, corner_layers=1)
    planar = PlanarModes.from_nodal(solid.nodal(), GRID)
    off = solid.angular_frequencies / reference.angular_frequencies - 1.0
    print(f'\n{solid.basis.N} unknowns: frequencies off by {off.min():.2e} to {off.max():.2e}, '
          f'least MAC {aligned_assurance(reference, planar, brake).min():.4f}')
    found = planar_arrays(brake, planar, pad)
    for speed in (5.0, 20.0):
        for name, disc, parts in (('harmonics', reference, exact), ('planar mesh', planar, found)):
            print(f'Omega {speed:g}, {name}: ' + ', '.join(
                f'{m.frequency_hz:.1f} Hz {m.growth_rate:+.2f} 1/s'
                for m in unstable(brake, disc, pad, parts, speed)))


def aligned_assurance(reference: Any, other: ModalBasis, brake: Brake) -> FloatArray:
    """
    Return the MAC of each reference mode with its image in modes of nearly its frequency.

    Doublets turn freely, so each reference shape is projected on all modes within 3 %.
    """
    points = contact_grid(replace(brake.contact, angle=2.0 * np.pi),
                          0.5 * brake.disc.rotor_thickness * (1.0 - 1e-9),
                          PlanarGrid(contact=(4, 64), rule='midpoint'))
    first, second = (np.hstack([s.radial, s.tangential, s.normal])
                     for s in (reference.sample(points), other.sample(points)))
    found = []
    for shape, w in zip(first, reference.angular_frequencies, strict=True):
        near = second[np.abs(other.angular_frequencies / w - 1.0) < 0.03]
        image = np.linalg.lstsq(near.T, shape, rcond=None)[0] @ near
        found.append(modal_assurance(shape[None], image[None])[0, 0])
    return np.array(found)


if __name__ == '__main__':
    main(sys.argv[1:])

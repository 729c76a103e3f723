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

"""Modes of one component of a brake, as its file has them, checked against the brake."""

from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np
from scipy.sparse import identity
from squeal_core.brake.dimensions import Contact, ModalResults
from squeal_core.modes.modal_basis import (
    keep_whole_doublets,
    modal_assurance,
    ModalBasis,
    Quadrature,
)
from squeal_core.modes.nodal_modes import NodalModes

# neighbours this close in frequency are a doublet; a mesh without symmetry splits it a little
_DOUBLET = 5e-3
# tolerance of stated modal masses against integrated ones: lumped masses differ by more
# than a tenth on coarse meshes, confused units by more than two
_STATED_MASS = 0.25
# least fraction of the mass that modes carry in each rigid motion: with elements, and by nodes
# alone, over which flexible modes are not quite orthogonal to rigid motion
_CARRIED, _CARRIED_BY_NODES = 0.1, 0.5
_OPEN = math.radians(60.0)  # largest angle without nodes; coarse meshes have one every 30
_AROUND = 128  # points around the ring
_MATCHING = 0.5  # a fraction: 1 of whole discs, 0.3 in cylindrical components
_BESIDE = 0.02  # how far a contact face may lie from its place, in thicknesses


@dataclass(frozen=True)
class Component:
    """A component's modes, its density [kg/m^3], and the MAC where they were interpolated."""

    basis: ModalBasis
    density: float = math.nan
    mac: float | None = None


def read_component(results: ModalResults, count: int, contact: Contact,
                   faces: tuple[float, ...]) -> Component:
    """
    Read modes of another package: through their elements, or through planar layers of nodes.

    Parameters
    ----------
    results : ModalResults
        Where the modal results are.
    count : int
        Number of modes to keep; of a disc one more where a doublet would be cut.
    contact : Contact
        Contact patch.
    faces : floats
        z of its contact faces [m]: two of a disc, one of a pad.

    Raises
    ------
    SquealError
        For a file that cannot be read, or that is not of this component of this brake.

    """
    from squeal_core.modes.fe.elements import KINDS
    from squeal_core.modes.fe.mixed import ElementModes
    from squeal_core.modes.fe.solid import RIGID_NAMES, solid_names, SolidModes
    from squeal_core.modes.planar_mesh import LayeredNodes, PlanarModes
    from squeal_core.modes.readers import read_modes, ReaderError
    from squeal_core.modes.readers.placing import LENGTH_UNITS_M

    is_disc = len(faces) == 2
    nodal = read_modes(
        results.file, format=results.format, length_unit=results.length_unit,
        mass_unit=results.mass_unit, axis=results.axis,  # type: ignore[arg-type]
        origin=[c / LENGTH_UNITS_M.get(results.length_unit, 1.0) for c in results.origin],
        modal_mass=results.modal_mass, density=results.density,
        mass_tolerance=0.05 if results.modal_mass is None else _STATED_MASS)
    if len(nodal.names) < count:
        raise ReaderError(results.file, f'has {len(nodal.names)} modes, but the brake is to keep '
                          f'{count}', 'export more modes, or keep fewer (modes)')
    _check_place(nodal, results, contact, faces)
    _check_bearing(nodal, results, is_disc)
    if is_disc:
        _check_whole(nodal, results, contact)
        count = keep_whole_doublets(nodal.angular_frequencies, count, tolerance=_DOUBLET)
    elif np.count_nonzero(nodal.angular_frequencies == 0.0) == len(RIGID_NAMES):
        # `read_modes` has turned the rigid ones into this order
        nodal = replace(nodal, names=solid_names(len(nodal.names)))
    nodal = nodal.keep(count)
    basis: ModalBasis
    if nodal.elements:
        kinds = {block.kind for block in nodal.elements}
        basis = (SolidModes.from_nodal(nodal, density=results.density)
                 if len(kinds) == 1 and kinds <= set(KINDS) else ElementModes(nodal))
    else:
        basis = PlanarModes(LayeredNodes(nodal))
        _check_masses(basis, results, volume=is_disc)
    if is_disc:
        _check_axes(basis, results, contact, faces[0])
    return Component(basis, results.density, _interpolation(basis, nodal))


def _interpolation(basis: ModalBasis, nodal: NodalModes, *, most: int = 400) -> float:
    """Return the least MAC of a basis, sampled at nodes, with the shapes given there."""
    nodes = np.linspace(0, len(nodal.coordinates) - 1, most).round().astype(int)
    x, y, z = nodal.coordinates[np.unique(nodes)].T
    given = nodal.shapes[:, np.unique(nodes)]
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    s = basis.sample(Quadrature(radius, angle, z, np.ones_like(x)))
    c, d = np.cos(angle), np.sin(angle)
    result = np.stack([s.radial * c - s.tangential * d, s.radial * d + s.tangential * c, s.normal],
                      axis=2)
    flat = [part.reshape(len(given), -1) for part in (result, given)]
    return float(np.diag(modal_assurance(*flat)).min())


def _check_place(nodal: NodalModes, results: ModalResults, contact: Contact,
                 faces: tuple[float, ...]) -> None:
    """
    Refuse a component whose contact faces are not where the brake has them.

    Elsewhere the contact would be found inside the body, or not at all.
    """
    from squeal_core.modes.readers import ReaderError
    remedy = ('check axis, origin_m (z = 0 lies midway between the faces of the rotor, theta = 0 '
              'in the middle of the pads), length_unit and thickness')
    radius = np.hypot(*nodal.coordinates[:, :2].T)
    z = nodal.coordinates[(radius > 0.99 * contact.inner_radius)
                          & (radius < 1.01 * contact.outer_radius), 2]
    if not z.size:
        raise ReaderError(
            results.file, f'has nodes at radii from {radius.min():.4g} to {radius.max():.4g} m, '
            f'none at those of the contact, {contact.inner_radius:g} to '
            f'{contact.outer_radius:g} m', remedy)
    for face in faces:
        # a disc's upper face is its contact face, but it is a pad's lower one that lies on it
        result = float(z.max() if (face > 0.0) == (len(faces) == 2) else z.min())
        if abs(result - face) > _BESIDE * results.thickness:
            raise ReaderError(results.file, f'has its contact face at z = {result:.4g} m, the '
                              f'brake at {face:.4g} m', remedy)


def _check_bearing(nodal: NodalModes, results: ModalResults, is_disc: bool) -> None:
    """
    Refuse a disc that is not held, and a pad without all of its rigid modes.

    A pad on springs has none of zero frequency, but modes that carry it as a rigid body.
    """
    from squeal_core.modes.readers import ReaderError
    from squeal_core.modes.readers.rigid_modes import rigid_mass_fractions
    rigid = int(np.count_nonzero(nodal.angular_frequencies == 0.0))
    if is_disc:
        if rigid:
            raise ReaderError(results.file, f'has {rigid} rigid modes: the disc is free',
                              'clamp the disc at its hub, against turning too')
        return
    if rigid == 6:
        return
    least = float(rigid_mass_fractions(nodal, _node_masses(nodal, results.density))[0])
    enough = _CARRIED if nodal.elements else _CARRIED_BY_NODES
    if least < enough:
        raise ReaderError(
            results.file, f'has {rigid} rigid modes, and no mode carries the pad in a further '
            f'rigid motion ({least:.2g} of its mass, at least {enough:g})', 'export all modes '
            'from the first one on: a free pad has six rigid ones, none left out')


def _node_masses(nodal: NodalModes, density: float) -> Any:
    """Return the mass matrix of the nodes: by the elements; without them the same mass at each."""
    from squeal_core.modes.fe.mass import mass_matrix
    if nodal.elements:
        return mass_matrix(nodal, density)
    mass = 1.0 / float(np.median(np.sum(nodal.shapes**2, axis=(1, 2))))
    return identity(len(nodal.coordinates)) * mass


def _check_whole(nodal: NodalModes, results: ModalResults, contact: Contact) -> None:
    """Refuse a sector: whatever its modes are, they are not those of the ring."""
    from squeal_core.modes.readers import ReaderError
    x, y = nodal.coordinates[:, :2].T
    radius = np.hypot(x, y)
    swept = (radius > 0.99 * contact.inner_radius) & (radius < 1.01 * contact.outer_radius)
    angle = np.sort(np.arctan2(y[swept], x[swept]))
    gap = float(np.diff(angle, append=angle[0] + 2.0 * np.pi).max())
    if gap > _OPEN:
        raise ReaderError(
            results.file, f'has no node in {np.degrees(gap):.0f} degrees of the ring that the '
            'pads sweep: a sector, as in a model with symmetry planes or cyclic symmetry',
            'solve and export the whole disc of 360 degrees, and check origin_m and axis')


def _check_axes(basis: ModalBasis, results: ModalResults, contact: Contact, face: float) -> None:
    """
    Refuse a disc whose displacements are not along the global Cartesian axes.

    Around the ring the in-plane parts of a mode have as many waves as its part along the axis
    has. Cylindrical components that are read as Cartesian ones have one more or one less.
    """
    from squeal_core.modes.readers import ReaderError
    angle = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    ones = np.ones(_AROUND)
    shapes = basis.sample(Quadrature(contact.mean_radius * ones, angle, face * ones, ones))
    radial, tangential, normal = (np.abs(np.fft.rfft(part, axis=1))**2 for part in (
        shapes.radial, shapes.tangential, shapes.normal))
    in_plane = radial + tangential
    waves = np.argmax(in_plane + normal, axis=1)
    total = in_plane.sum(axis=1)
    matching = in_plane[np.arange(len(waves)), waves] / np.where(total > 0.0, total, 1.0)
    if matching[total > 0.0].size and matching[total > 0.0].mean() < _MATCHING:
        raise ReaderError(
            results.file, f'moves in the plane of the disc in other waves than along the axis '
            f'({matching.mean():.0%} in the same, at least {_MATCHING:.0%}): results in a '
            'cylindrical or another local system', 'export results in the global Cartesian system '
            '(Ansys RSYS,0; CalculiX GLOBAL=YES; Nastran CD blank), and check axis')


def _check_masses(basis: ModalBasis, results: ModalResults, *, volume: bool) -> None:
    """Refuse shapes in planar layers whose modal masses differ from the stated ones."""
    from squeal_core.modes.readers import ReaderError
    masses, size = np.zeros(len(basis.names)), 0.0
    for part in basis.volume_layers():
        size += part.points.weight.sum()
        masses += results.density * sum(
            np.sum(part.points.weight * shape**2, axis=1)
            for shape in (part.radial, part.tangential, part.normal))
    if size == 0.0:
        if volume:
            raise ReaderError(results.file, 'gives nodes in one plane, which cover no volume',
                              'export all nodes of the disc, or its elements')
        return
    worst = int(np.abs(masses - 1.0).argmax())
    if abs(masses[worst] - 1.0) > _STATED_MASS:
        raise ReaderError(
            results.file, f'mode {worst + 1} has {masses[worst]:.3g} times the modal mass stated, '
            'by density and layers of nodes', 'check modal_mass, mass_unit, length_unit and '
            'density')

"""Modes of one component of a brake, as its file has them, held against the brake it is to fit."""

from dataclasses import dataclass
import math

import numpy as np

from squeal_core.audit import interpolation
from squeal_core.brake import Contact, ModalResults
from squeal_core.modal_basis import keep_whole_doublets, ModalBasis
from squeal_core.nodal_modes import NodalModes

# neighbours this close in frequency are a doublet; a mesh without symmetry splits it a little
_DOUBLET = 5e-3
# how far modal masses that are stated may lie from integrated ones: lumped masses differ by more
# than a tenth on coarse meshes, confused units by more than two
_STATED_MASS = 0.25
_BESIDE = 0.02  # how far a contact face may lie from its place, in thicknesses


@dataclass(frozen=True)
class Component:
    """A component's modes, its density [kg/m^3], and the MAC where they were interpolated."""

    basis: ModalBasis
    density: float = math.nan
    mac: float | None = None


def read_component(results: ModalResults, count: int, contact: Contact,
                   faces: tuple[float, ...]) -> Component:
    """Read modes of another package: through their elements, or through planar layers of nodes.

    Parameters
    ----------
    results : ModalResults
    count : int
        Number of modes to keep; of a disc one more where a doublet would be cut.
    contact : Contact
    faces : floats
        z of its contact faces [m]: two of a disc, one of a pad.

    Raises
    ------
    SquealError
        For a file that cannot be read, or that is not of this component of this brake.
    """
    from squeal_core.fe.elements import KINDS
    from squeal_core.fe.mixed import ElementModes
    from squeal_core.fe.solid import SolidModes
    from squeal_core.planar_mesh import LayeredNodes, PlanarModes
    from squeal_core.readers import read_modes, ReaderError
    from squeal_core.readers.placing import LENGTH_UNITS_M

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
    if is_disc:
        count = keep_whole_doublets(nodal.angular_frequencies, count, tolerance=_DOUBLET)
    nodal = nodal.keep(count)
    basis: ModalBasis
    if nodal.elements:
        kinds = {block.kind for block in nodal.elements}
        basis = (SolidModes.from_nodal(nodal, density=results.density)
                 if len(kinds) == 1 and kinds <= set(KINDS) else ElementModes(nodal))
    else:
        basis = PlanarModes(LayeredNodes(nodal))
        _check_masses(basis, results, volume=is_disc)
    return Component(basis, results.density, interpolation(basis, nodal))


def _check_place(nodal: NodalModes, results: ModalResults, contact: Contact,
                 faces: tuple[float, ...]) -> None:
    """Refuse a component whose contact faces are not where the brake has them.

    Elsewhere the contact would be found inside the body, or not at all.
    """
    from squeal_core.readers import ReaderError
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
        found = float(z.max() if (face > 0.0) == (len(faces) == 2) else z.min())
        if abs(found - face) > _BESIDE * results.thickness:
            raise ReaderError(results.file, f'has its contact face at z = {found:.4g} m, the '
                              f'brake at {face:.4g} m', remedy)


def _check_masses(basis: ModalBasis, results: ModalResults, *, volume: bool) -> None:
    """Refuse shapes in planar layers whose modal masses are not what they are stated to be."""
    from squeal_core.readers import ReaderError
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

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

"""Normalisation to unit modal mass: by masses that are stated, or by density and elements."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import short_repr
from squeal_core.modes.fe.mass import mass_matrix, mass_products
from squeal_core.modes.nodal_modes import ModesError, NodalModes
from squeal_core.modes.readers.raw import ReaderError
from squeal_core.modes.readers.rigid_modes import exact_rigid_modes, in_plane_first, rigid_fields

# bounds of the mass of a component over the box around it [kg/m^3]: from a spidery light alloy
# to a full box of lead, with a wide margin for uneven meshes
_LIGHTEST, _HEAVIEST = 20.0, 50_000.0
# lumped masses and two materials under one density reach 0.2, twice the same mode gives 1
_SHARED_MASS = 0.3
_SAME = 0.995  # the same where there are no elements: twice the same shape
_PLANAR = 0.01  # of its length: a flatter set of nodes is a face, not a body
_STATE = ('state modal_mass (1 for mass-normalised modes, in mass_unit), or density where there '
          'are elements')


def normalised(modes: NodalModes, stated: FloatArray | None, density: float | None,
               total_mass: float | None, tolerance: float) -> NodalModes:
    """
    Return the modes with unit modal mass.

    Parameters
    ----------
    modes : NodalModes
        In SI units, of any normalisation.
    stated : (N,) array or None
        Modal masses of these shapes [kg].
    density : float or None
        [kg/m^3]; the masses are integrated over the elements, if there are any, and held against
        those stated.
    total_mass : float or None
        Of a free component [kg]; held against the rigid modes.
    tolerance : float
        How far masses may differ, relative.

    """
    for name, value in (('density', density), ('total_mass', total_mass)):
        if value is not None and not 0.0 < value < np.inf:
            raise ReaderError(modes.source, f'{name} is {short_repr(value)}',
                              'give a positive number')
    still = np.flatnonzero(~np.any(modes.shapes, axis=(1, 2)))
    if still.size:
        raise ReaderError(modes.source, f'mode {still[0] + 1} moves no node',
                          'export its displacements')
    modes = exact_rigid_modes(modes)
    masses = stated
    if density is not None and modes.elements:
        masses = _integrated(modes, density, stated, tolerance)
    else:
        flat = modes.shapes.reshape(len(modes.shapes), -1)
        _check_orthogonal(modes, flat @ flat.T, _SAME)
    if masses is None:
        raise ReaderError(modes.source, 'does not say how its shapes are normalised', _STATE)
    scaled = in_plane_first(replace(
        modes, shapes=modes.shapes / np.sqrt(masses)[:, None, None]))
    _check_box(scaled)
    if total_mass is not None:
        _check_total(scaled, total_mass, tolerance)
    return scaled


def stated_masses(source: str, count: int, given: float | Sequence[float] | None,
                  result: FloatArray | None, unit_kg: float) -> FloatArray | None:
    """Return modal masses [kg]: those given, one for all or one each; else those of the file."""
    if given is None:
        return None if result is None else result * unit_kg
    masses = np.array(given, dtype=float)
    if masses.shape not in ((), (count,)):
        raise ReaderError(source, f'has {count} modes but {masses.size} modal masses',
                          'give one number, or one each mode')
    if not np.all((masses > 0.0) & (masses < np.inf)):
        raise ReaderError(source, f'modal_mass is {short_repr(given)}', 'give positive numbers')
    return np.broadcast_to(masses, (count,)) * unit_kg


def rigid_mass(modes: NodalModes) -> float | None:
    """
    Return the mass of a free component from its rigid modes [kg]; None without all six.

    At the mass centre c, and only there, the sum of phi(c)^2 over the mass-normalised rigid modes
    is least, and it is 3 / m: the rotations have no part in it.
    """
    shapes = modes.shapes[modes.angular_frequencies == 0.0]
    if len(shapes) != 6:
        return None
    field = rigid_fields(modes.coordinates).reshape(6, -1).T
    parts = np.linalg.lstsq(field, shapes.reshape(6, -1).T, rcond=None)[0].T
    shift, turn = parts[:, :3], parts[:, 3:]
    # phi(c) = shift + turn x c
    cross = np.array([[np.cross(t, e) for e in np.eye(3)] for t in turn]).transpose(0, 2, 1)
    centre = np.linalg.lstsq(cross.reshape(-1, 3), -shift.ravel(), rcond=None)[0]
    left = shift + cross @ centre
    return float(3.0 / np.sum(left**2))


def _integrated(modes: NodalModes, density: float, stated: FloatArray | None,
                tolerance: float) -> FloatArray:
    try:
        products = mass_products(modes.shapes, mass_matrix(modes, density))
    except ModesError as error:
        raise ReaderError(modes.source, 'cannot be integrated over: '
                          f'{str(error).removeprefix(f"{modes.source}: ")}',
                          'or leave density away') from None
    result = np.diag(products)
    _check_orthogonal(modes, products, _SHARED_MASS)
    if stated is None:
        return result
    off = np.abs(result / stated - 1.0)
    if off.max() > tolerance:
        worst = int(off.argmax())
        raise ReaderError(
            modes.source, f'mode {worst + 1} has a modal mass of {result[worst]:.6g} kg by '
            f'density and elements, {stated[worst]:.6g} kg by what is stated', 'check density, '
            'modal_mass, mass_unit and length_unit')
    return stated


def _check_orthogonal(modes: NodalModes, products: FloatArray, limit: float) -> None:
    """Refuse shapes that share mass: natural modes of one analysis do not."""
    sizes = np.sqrt(np.diag(products))
    shared = np.abs(products / np.outer(sizes, sizes) - np.eye(len(products)))
    if shared.max() > limit:
        first, second = sorted(np.unravel_index(int(shared.argmax()), shared.shape))
        raise ReaderError(
            modes.source, f'modes {first + 1} and {second + 1} are not orthogonal: they share '
            f'{shared.max():.3g} of their mass, more than {limit:g}',
            'export real normal modes of one analysis, each once')


def _check_box(modes: NodalModes) -> None:
    """
    Refuse a normalisation that no component could have: it is a confusion of units.

    The mean over the nodes of a mass-normalised shape squared is about one over the mass.
    """
    sides = np.ptp(modes.coordinates, axis=0)
    if sides.min() < _PLANAR * sides.max():
        return
    masses = 1.0 / np.mean(np.sum(modes.shapes**2, axis=2), axis=1)
    density = float(np.median(masses) / sides.prod())
    if not _LIGHTEST < density < _HEAVIEST:
        raise ReaderError(
            modes.source, f'would weigh about {np.median(masses):.3g} kg, {density:.3g} kg to a '
            'cubic metre of the box around it', 'check modal_mass, mass_unit (t in models of mm '
            'and MPa) and length_unit')


def _check_total(modes: NodalModes, total: float, tolerance: float) -> None:
    result = rigid_mass(modes)
    if result is None:
        raise ReaderError(modes.source, 'has not the six rigid modes that total_mass is checked '
                          'by', 'leave total_mass away')
    if abs(result / total - 1.0) > tolerance:
        raise ReaderError(modes.source, f'weighs {result:.4g} kg by its rigid modes, {total:.4g} '
                          'kg by total_mass', 'check total_mass, modal_mass and mass_unit')

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
Rigid motions of a component: its zero-frequency shapes must be ones, and are made exact.

Solvers find rigid modes to some digits only. What they are off by has no stiffness of its own,
so that the friction couple turns it into a slow divergence that no brake has.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.nodal_modes import NodalModes
from squeal_core.modes.readers.raw import ReaderError

RIGID_TOLERANCE = 1e-3  # of a zero-frequency shape: the fraction that is no rigid motion
_IN_PLANE, _OUT_OF_PLANE = [0, 1, 5], [2, 3, 4]  # of `rigid_fields`: by motion along z
_LEAST_SPREAD = 0.02  # least singular value of unit rigid shapes that are independent
_EXPORT = ('export one free component, results in the global Cartesian system (Ansys RSYS,0; '
           'CalculiX GLOBAL=YES; Nastran CD blank), with six digits')


def rigid_fields(coordinates: FloatArray) -> FloatArray:
    """Return translations and rotations about the mean node: (6, M, 3), rotations in m."""
    x, y, z = (coordinates - coordinates.mean(axis=0)).T
    zero, one = np.zeros_like(x), np.ones_like(x)
    return np.stack([np.stack(column, axis=1) for column in (
        (one, zero, zero), (zero, one, zero), (zero, zero, one),
        (zero, -z, y), (z, zero, -x), (-y, x, zero))])


def exact_rigid_modes(modes: NodalModes) -> NodalModes:
    """
    Return the modes, those of zero frequency replaced by the rigid motions nearest to them.

    Parameters
    ----------
    modes : NodalModes
        Of any normalisation.

    Raises
    ------
    ReaderError
        For a zero-frequency shape that is no rigid motion within `RIGID_TOLERANCE`: results in
        local coordinates, a mechanism, or another component; and for one that is there twice.

    """
    rigid = np.flatnonzero(modes.angular_frequencies == 0.0)
    flat = modes.shapes[rigid].reshape(rigid.size, modes.coordinates.size)
    norms = np.linalg.norm(flat, axis=1)
    if not rigid.size or not norms.all():  # a shape that moves nothing is refused elsewhere
        return modes
    basis = _orthonormal(rigid_fields(modes.coordinates))
    parts = flat @ basis
    exact = parts @ basis.T
    left = np.linalg.norm(flat - exact, axis=1) / norms
    worst = int(left.argmax())
    if left[worst] > RIGID_TOLERANCE:
        raise ReaderError(
            modes.source, f'mode {rigid[worst] + 1} has a frequency near zero but is no rigid '
            f'motion: {left[worst]:.2%} of its displacement departs from one, more than '
            f'{RIGID_TOLERANCE:.1%}', _EXPORT)
    spread = np.linalg.svd(parts / norms[:, None], compute_uv=False)
    if spread[-1] < _LEAST_SPREAD or rigid.size > basis.shape[1]:
        raise ReaderError(modes.source, f'has {rigid.size} modes near zero frequency that are '
                          'not as many rigid motions', 'export each mode once')
    shapes = modes.shapes.copy()
    shapes[rigid] = exact.reshape(rigid.size, -1, 3)
    return replace(modes, shapes=shapes)


def in_plane_first(modes: NodalModes) -> NodalModes:
    """
    Return the modes, the rigid ones turned so that those in the plane of the disc are first.

    Any turn of modes of one frequency is as good; solvers mix them at will. In this one a motion
    that presses nowhere has no stiffness at all, instead of what rounding leaves.

    Parameters
    ----------
    modes : NodalModes
        Of unit modal mass, rigid ones exact; z is the axis of rotation.

    """
    rigid = np.flatnonzero(modes.angular_frequencies == 0.0)
    if not rigid.size:
        return modes
    fields = rigid_fields(modes.coordinates).reshape(6, -1).T
    sizes = np.linalg.norm(fields, axis=0)
    fields /= np.where(sizes > 0.0, sizes, 1.0)
    parts = np.linalg.lstsq(fields, modes.shapes[rigid].reshape(rigid.size, -1).T,
                            rcond=None)[0].T
    turn, values, _ = np.linalg.svd(parts[:, _OUT_OF_PLANE])
    parts = turn.T @ parts
    pressing = np.pad(values, (0, rigid.size))[:rigid.size]
    flat = pressing <= RIGID_TOLERANCE * np.linalg.norm(parts, axis=1)
    parts[np.ix_(flat, _OUT_OF_PLANE)] = 0.0
    parts = np.vstack([_triangular(parts[flat], _IN_PLANE),
                       _triangular(parts[~flat], _OUT_OF_PLANE)])
    shapes = modes.shapes.copy()
    shapes[rigid] = (parts @ fields.T).reshape(rigid.size, -1, 3)
    return replace(modes, shapes=shapes)


def _triangular(parts: FloatArray, columns: list[int]) -> FloatArray:
    """Turn rows so that these columns are upper triangular: one turn, whatever the mixture."""
    turn, upper = np.linalg.qr(parts[:, columns], mode='complete')
    signs = np.ones(len(parts))
    diagonal = np.sign(np.diag(upper))
    signs[:diagonal.size] = np.where(diagonal == 0.0, 1.0, diagonal)
    return np.asarray(signs[:, None] * (turn.T @ parts))


def rigid_mass_fractions(modes: NodalModes, mass: Any) -> FloatArray:
    """
    Return the fractions of mass that modes carry in rigid motion: (6,), rising, 0 to 1.

    One near zero says that the component can move as a rigid body in a way in which no mode
    does: a free component whose file lacks a rigid mode.

    Parameters
    ----------
    modes : NodalModes
        Of unit modal mass.
    mass : sparse (M, M) array
        Of the nodes, for each direction [kg].

    """
    fields = rigid_fields(modes.coordinates)
    weighed = np.stack([mass @ fields[:, :, axis].T for axis in range(3)], axis=2)  # (M, 6, 3)
    values, vectors = np.linalg.eigh(np.einsum('kmi,mli->kl', fields, weighed))
    held = values > 1e-9 * values.max()
    to_unit = vectors[:, held] / np.sqrt(values[held])
    parts = to_unit.T @ np.einsum('mki,nmi->kn', weighed, modes.shapes)
    return np.linalg.eigvalsh(parts @ parts.T)


def _orthonormal(fields: FloatArray) -> FloatArray:
    """Return an orthonormal basis of the fields, as columns (3M, at most 6)."""
    columns = fields.reshape(6, -1).T
    sizes = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns / np.where(sizes > 0.0, sizes, 1.0),
                                    full_matrices=False)
    return np.asarray(left[:, values > 1e-9 * values[0]])

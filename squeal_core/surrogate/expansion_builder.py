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

"""Builds expansions: a full eigensolution, the choice of blocks, their power series."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components
from squeal_core.brake.operating_point import Coefficients, DAMPING, DASHPOTS, OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.state_space import frequency_scale, state_matrix
from squeal_core.surrogate.monomials import Monomials
from squeal_core.surrogate.riccati_recursion import RiccatiRecursion
from squeal_core.surrogate.spectral_expansion import DEGREE, SpectralExpansion

_STEP = 0.1  # relative step of the parameters that blocks are chosen for
_STIFFNESS_STEP = 0.04  # modes move past each other with it: a larger one would mix many
_SLOPE_STEP = 0.01  # s/m; the slope may be zero
_COUPLING = 0.07  # root of the second-order term from which on two modes share a block
_DEFECTIVE = 4.9e-5  # part of the largest eigenvalue by which some are off: vectors are one
_SMALL = 0.01  # of the damping or stiffness that is the spectrum's scale
_FIXED = ('material_damping', *DASHPOTS.values())  # or fixed to a stiffness, by the damping scale


def expand_spectrum(model: BrakeModel, point: OperatingPoint, *, degree: int = DEGREE,
                    around: FloatArray | None = None) -> SpectralExpansion:
    """
    Return the series of the spectrum around a point, from one full solve with all vectors.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Operating point.
    degree : int
        Of the series, 3 at least.
    around : (P, 9) array, optional
        Coefficients, of the point's damping scale, that the series is for: those that vary among
        them are its variables, and blocks are chosen for how far they are; None: steps of a tenth
        of each parameter.

    Raises
    ------
    numpy.linalg.LinAlgError
        Where the eigensolution fails or its vectors do not span the space.

    """
    frame = (_Frame.at(model, point) if around is None
             else _Frame.spanning(model, point, around))
    eigenvalues, right = _eigensolution(model, point)
    couplings = _projected(model, point, frame, eigenvalues, right)
    gap = None if around is None else _closest(eigenvalues, couplings, frame.steps)
    blocks = _blocks(eigenvalues, couplings, frame.steps, gap)
    return _series(frame, eigenvalues, couplings, blocks, degree)


@dataclass(frozen=True, eq=False)
class _Frame:
    """Rows of the coefficients that count (v,), centre and scales (v,) and the scaled steps."""

    rows: IndexArray
    centre: FloatArray
    scales: FloatArray
    steps: Sequence[FloatArray]

    @classmethod
    def spanning(cls, model: BrakeModel, point: OperatingPoint,
                 around: FloatArray) -> '_Frame':
        """Return that of the coefficients that vary, steps to the points farthest along each."""
        rows = _rows(model)
        rows = rows[np.ptp(around[:, rows], axis=0) > 0.0]
        centre = np.array(point.coefficients())[rows]
        offsets = around[:, rows] - centre
        scales = np.abs(offsets).max(axis=0)
        farthest = np.union1d(offsets.argmin(axis=0), offsets.argmax(axis=0))
        return cls(rows, centre, scales, list(offsets[farthest] / scales))

    @classmethod
    def at(cls, model: BrakeModel, point: OperatingPoint) -> '_Frame':
        rows = _rows(model)
        centre = np.array(point.coefficients())[rows]
        steps = [np.array(there.coefficients())[rows] - centre
                 for there in _neighbours(point)]
        scales = np.abs(steps).max(axis=0, initial=0.0)
        still = np.flatnonzero(scales == 0.0)
        scales[still] = [_small_change(model, point, rows[i]) for i in still.tolist()]
        return cls(rows, centre, scales, [step / scales for step in steps])


def _rows(model: BrakeModel) -> IndexArray:
    """Return the coefficients at one damping scale that multiply anything."""
    return np.array([i for i, name in enumerate(Coefficients._fields) if name not in _FIXED
                     and (array := getattr(model, name)) is not None and np.any(array)],
                    dtype=np.intp)


def _small_change(model: BrakeModel, point: OperatingPoint, row: int) -> float:
    """Return a step of a coefficient that no parameter's step moves, as at no friction."""
    name = Coefficients._fields[row]
    scale = frequency_scale(model, point) ** (1 if name in DAMPING else 2)
    return _SMALL * scale / float(np.abs(getattr(model, name)).max()) or 1.0


def _eigensolution(model: BrakeModel, point: OperatingPoint) -> tuple[ComplexArray, ComplexArray]:
    """Return all eigenvalues (M,) and their right vectors (M, M)."""
    result = np.linalg.eig(state_matrix(model, model.damping(point), model.stiffness(point)))
    return result.eigenvalues, result.eigenvectors


def _series(frame: _Frame, eigenvalues: ComplexArray, couplings: ComplexArray,
            blocks: Sequence[IndexArray], degree: int) -> SpectralExpansion:
    """Return the series of the blocks of a spectrum with couplings E_i (v, M, M)."""
    recursion = RiccatiRecursion(eigenvalues, couplings, blocks,
                                 _monomials(frame.rows.size, degree))
    sizes = np.array([block.size for block in blocks], dtype=np.intp)
    own = np.repeat(np.arange(sizes.size), sizes)
    least = 5e-15 * abs(eigenvalues).max(initial=0.0)
    whole = np.array([abs(own.imag.sum()) <= least + 1e-9 * abs(own).sum()
                      for own in (eigenvalues[block] for block in blocks)])
    return SpectralExpansion(
        rows=frame.rows, centre=readonly(frame.centre), scales=readonly(frame.scales),
        monomials=recursion.monomials, sizes=readonly(sizes, np.intp),
        series=readonly(np.concatenate(recursion.terms()), complex),
        mirrored=readonly(~whole[own], bool) if own.size else np.zeros(0, bool))


@cache
def _monomials(variables: int, degree: int) -> Monomials:
    return Monomials(variables, degree)


def _neighbours(point: OperatingPoint) -> list[OperatingPoint]:
    """Return points a step of each parameter away."""
    slope = point.friction_slope
    moved = [replace(point, **{name: (1.0 + step) * getattr(point, name)})
             for name, step in (('rotor_speed', _STEP), ('contact_pressure', _STEP),
                                ('contact_stiffness', _STIFFNESS_STEP))]
    friction = replace(point, friction=(1.0 + _STEP) * point.friction,
                       friction_slope=(1.0 + _STEP) * slope)
    return [*moved, friction, replace(point, friction_slope=slope + _SLOPE_STEP)]


class _Pairs(NamedTuple):
    """Eigenvalues with Im >= 0, those that are their images, and the image of each."""

    upper: IndexArray
    lower: IndexArray
    image: IndexArray

    @classmethod
    def of(cls, eigenvalues: ComplexArray) -> '_Pairs':
        """Find them among eigenvalues of numpy's eig, which has the two of a pair side by side."""
        upper = np.flatnonzero(eigenvalues.imag >= 0.0)
        lower = upper + (eigenvalues[upper].imag > 0.0)
        image = np.empty(eigenvalues.size, np.intp)
        image[upper], image[lower] = lower, upper
        return cls(upper, lower, image)


def _projected(model: BrakeModel, point: OperatingPoint, frame: _Frame, eigenvalues: ComplexArray,
               right: ComplexArray) -> ComplexArray:
    """Return couplings E_i (v, M, M); LinAlgError where the vectors do not span the space."""
    damping, stiffness = model.damping(point), model.stiffness(point)
    state = state_matrix(model, damping, stiffness)
    left = np.ascontiguousarray(np.linalg.inv(right), complex)
    held, moving = len(state) - model.size, np.logical_not(model.free_coordinates)
    pairs = _Pairs.of(eigenvalues)
    # real and imaginary parts in turn: real arrays are multiplied with them as they are
    displacements, velocities = np.split(
        np.ascontiguousarray(right[:, pairs.upper], complex).view(float), [held])
    couplings = np.empty((frame.rows.size, *state.shape), complex)
    pushing = np.ascontiguousarray(left[:, held:])
    for coupling, row, scale in zip(couplings, frame.rows, frame.scales, strict=True):
        name = Coefficients._fields[row]
        array = -scale * getattr(model, name)
        felt = array @ velocities if name in DAMPING else array[:, moving] @ displacements
        dashpot = getattr(model, DASHPOTS.get(name, ''), None)
        if dashpot is not None:
            felt -= scale * point.damping_scale * (dashpot @ velocities)
        half = pushing @ felt.view(complex)
        coupling[:, pairs.upper], coupling[:, pairs.lower] = half, half[pairs.image].conj()
    # the state matrix times the vectors, without its zeros and ones
    pushed = stiffness[:, moving] @ displacements + damping @ velocities
    off = left @ np.concatenate([velocities[moving], -pushed]).view(complex)
    off[pairs.upper, np.arange(pairs.upper.size)] -= eigenvalues[pairs.upper]
    # that may vanish by chance where two vectors are equal to the last bit
    least = np.finfo(float).eps * (np.abs(left) * (np.abs(state) @ np.abs(right)).T).sum(axis=1)
    rounding = max(least.max(initial=0.0), np.abs(off).max(initial=0.0))
    if not rounding < _DEFECTIVE * (np.abs(eigenvalues).max(initial=0.0) or 1.0):
        raise np.linalg.LinAlgError('Eigenvectors do not span the space')
    return couplings


def _closest(eigenvalues: ComplexArray, couplings: ComplexArray,
             steps: Sequence[FloatArray]) -> FloatArray:
    """Return the least distances (M, M) of eigenvalues within steps, to first order."""
    apart = eigenvalues[:, None] - eigenvalues
    closest = np.abs(apart)
    own = np.diagonal(couplings, axis1=1, axis2=2)
    for step in steps:
        moved = step @ own
        change = moved[:, None] - moved
        size = np.maximum(np.abs(change)**2, np.finfo(float).tiny)
        along = np.clip(-(apart * change.conj()).real / size, 0.0, 1.0)
        closest = np.minimum(closest, np.abs(apart + along * change))
    return closest


def _blocks(eigenvalues: ComplexArray, couplings: ComplexArray,
            steps: Sequence[FloatArray], gap: FloatArray | None = None) -> list[IndexArray]:
    """Return the eigenvalues of each block, small blocks first; of mirror images the upper one."""
    if gap is None:
        gap = np.abs(eigenvalues[:, None] - eigenvalues)
    np.fill_diagonal(gap, np.inf)
    strength = np.zeros(gap.shape)
    for step in steps:
        change = np.tensordot(step, couplings, axes=1)
        strength = np.maximum(strength, np.abs(change * change.T))
    close = strength >= (_COUPLING * gap) ** 2  # two equal eigenvalues too, however weakly coupled
    _, label = connected_components(close, directed=False)
    groups = [np.flatnonzero(label == i) for i in range(label.max(initial=-1) + 1)]
    size = np.abs(eigenvalues).max(initial=0.0)
    kept = [g for g in groups if eigenvalues[g].imag.sum() > -1e-9 * size]
    return sorted(kept, key=lambda g: (g.size, float(eigenvalues[g[0]].imag),
                                       float(eigenvalues[g[0]].real)))

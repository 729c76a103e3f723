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
Complex modes at many operating points at once, from as few local expansions as will do.

Points are answered in groups around an expansion, one matrix product for all points of a group.
Expansions are computed where several points wait for one; single points left over are solved in
full. Errors are within the same limits as those of a table.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.brake.operating_point import coefficients_of, OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.table_cell import TableTolerances, verdict_within_error

_CHUNK = 512  # points evaluated at once: their terms fit into the cache
_TRIED = 3  # expansions tried for a point
_FAR = 3.0  # trust radii beyond which an expansion is not tried
_WORTH = 8  # points that wait from which on an expansion costs less than their full solves
# steps within which points may share an expansion: of ln speed, ln pressure, ln k_c, mu, mu_v
_STEPS = np.array([0.3, 0.4, 0.05, 0.06, 0.01])


@dataclass(frozen=True, eq=False)
class OperatingPoints:
    """
    Steady sliding under load at P points; each field as in `OperatingPoint`, (P,) or a number.

    Speeds not zero, pressures and contact stiffnesses above zero.
    """

    rotor_speed: FloatArray
    friction: FloatArray
    contact_pressure: FloatArray
    contact_stiffness: FloatArray
    friction_slope: FloatArray
    damping_scale: FloatArray

    @classmethod
    def of(cls, *, rotor_speed: ArrayLike, friction: ArrayLike, contact_pressure: ArrayLike,
           contact_stiffness: ArrayLike, friction_slope: ArrayLike = 0.0,
           damping_scale: ArrayLike = 1.0) -> 'OperatingPoints':
        """Return points of arrays that are broadcast together."""
        arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(value, float)) for value in (
            rotor_speed, friction, contact_pressure, contact_stiffness, friction_slope,
            damping_scale)))
        return cls(*(readonly(array) for array in arrays))

    def __len__(self) -> int:
        return int(self.rotor_speed.size)

    def __getitem__(self, place: int) -> OperatingPoint:
        return OperatingPoint(**{item.name: float(getattr(self, item.name)[place])
                                 for item in fields(self)})

    def coefficients(self) -> FloatArray:
        """Return (9, P), as `OperatingPoint.coefficients`."""
        return np.stack(coefficients_of(self))

    def places(self) -> FloatArray:
        """Return where the points are (P, 5), in steps of what shares an expansion."""
        with np.errstate(divide='ignore'):
            logarithms = np.log(np.maximum(np.abs(np.stack(
                [self.rotor_speed, self.contact_pressure, self.contact_stiffness])), 1e-12))
        return np.asarray((np.concatenate(
            [logarithms, [self.friction, self.friction_slope]]) / _STEPS[:, None]).T)


@dataclass(frozen=True, eq=False)
class BatchModes:
    """
    The modes at P points.

    Parameters
    ----------
    mode_eigenvalues : (P, N) array
        One root of each mode, in order of index, as `ComplexModes.mode_eigenvalues` [1/s].
    errors : (P, N) array
        What each may be off by [1/s]; 0 where solved in full.
    full : (P,) bool array
        Points solved in full.
    tolerances : Tolerances

    """

    mode_eigenvalues: ComplexArray
    errors: FloatArray
    full: Any
    tolerances: Tolerances

    def least_stable(self, low_hz: float, high_hz: float) -> IndexArray:
        """
        Return the place (P,) of the least stable mode that oscillates in a band.

        -1 where there is none.
        """
        frequency = self.mode_eigenvalues.imag / (2.0 * np.pi)
        inside = ((self.mode_eigenvalues.imag > self.tolerances.oscillation) & (
            frequency >= low_hz) & (frequency <= high_hz))
        growth = np.where(inside, self.mode_eigenvalues.real, -np.inf)
        return np.where(inside.any(axis=1), growth.argmax(axis=1), -1)

    def growth_rates(self, low_hz: float, high_hz: float) -> FloatArray:
        """Return the largest growth rate in a band (P,) [1/s]; -inf where no mode is in it."""
        places = self.least_stable(low_hz, high_hz)
        found = self.mode_eigenvalues.real[np.arange(len(places)), np.maximum(places, 0)]
        return np.where(places < 0, -np.inf, found)


class BatchSolver:
    """
    Complex modes of a model at many points, from expansions that stay for the next batch.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    tolerances : Tolerances, optional
        What counts as oscillation and growth; `Tolerances.of(model)` where None.
    errors : TableTolerances, optional
        Errors of eigenvalues above which a point is solved in full; `TableTolerances.of(model)`
        where None.

    Attributes
    ----------
    expansions : list of SpectralExpansion
        Computed so far.

    """

    def __init__(self, model: BrakeModel, tolerances: Tolerances | None = None, *,
                 errors: TableTolerances | None = None) -> None:
        self.model = model
        self.tolerances = tolerances or Tolerances.of(model)
        self.errors = errors or TableTolerances.of(model)
        self.expansions: list[SpectralExpansion] = []

    def modes(self, points: OperatingPoints) -> BatchModes:
        """Return the modes at points."""
        batch = _Batch(self, points)
        batch.from_expansions()
        batch.from_new_expansions()
        batch.in_full()
        return BatchModes(readonly(batch.mode_eigenvalues, complex), readonly(batch.errors),
                          readonly(batch.full, bool), self.tolerances)


class _Batch:
    """The work on one batch: which points are answered, and how."""

    def __init__(self, solver: BatchSolver, points: OperatingPoints) -> None:
        self.solver, self.points, self.tolerances = solver, points, solver.tolerances
        self._coefficients = points.coefficients()
        self._free = int(np.count_nonzero(solver.model.free_coordinates))
        shape = (len(points), solver.model.size)
        self.mode_eigenvalues, self.errors = np.zeros(shape, complex), np.zeros(shape)
        self.full = np.zeros(len(points), bool)
        self._waiting = np.ones(len(points), bool)

    def from_expansions(self) -> None:
        """Answer what expansions can answer, each point by the nearest few."""
        expansions = self.solver.expansions
        if not expansions:
            return
        waiting = np.flatnonzero(self._waiting)
        distances = np.stack([self._distances(one, waiting) for one in expansions])
        for _ in range(min(_TRIED, len(expansions))):
            nearest = distances.argmin(axis=0)
            near = distances[nearest, np.arange(waiting.size)] < _FAR
            for i in np.unique(nearest[near]).tolist():
                self._answer(expansions[i], waiting[near & (nearest == i)])
            distances[nearest, np.arange(waiting.size)] = np.inf
            left = self._waiting[waiting]
            waiting, distances = waiting[left], distances[:, left]

    def from_new_expansions(self) -> None:
        """Expand amid the points that wait around the first one, as long as it pays."""
        places, scale = self.points.places(), self.points.damping_scale
        apart = np.zeros(len(self.points), bool)  # left to full solves
        while (waiting := np.flatnonzero(self._waiting & ~apart)).size:
            first = waiting[0]
            alike = waiting[scale[waiting] == scale[first]]
            group = alike[np.abs(places[alike] - places[first]).max(axis=1) <= 1.0]
            if group.size < _WORTH:
                apart[group] = True
                continue
            middle = places[group].mean(axis=0)
            seed = int(group[np.abs(places[group] - middle).max(axis=1).argmin()])
            apart[[first, seed]] = True
            try:
                expansion = expand_spectrum(self.solver.model, self.points[seed])
            except np.linalg.LinAlgError:  # the vectors do not span the space
                continue
            self.solver.expansions.append(expansion)
            self._answer(expansion, waiting[self._distances(expansion, waiting) < _FAR])

    def in_full(self) -> None:
        """Solve what is left."""
        for place in np.flatnonzero(self._waiting).tolist():
            found = complex_modes(self.solver.model, self.points[place],
                                  tolerances=self.tolerances)
            self.mode_eigenvalues[place] = found.mode_eigenvalues
            self.full[place] = True
        self._waiting[:] = False

    def _distances(self, expansion: SpectralExpansion, places: IndexArray) -> FloatArray:
        """Return how far points are from an expansion, in its trust radii."""
        away = self._coefficients[expansion.rows][:, places] - expansion.centre[:, None]
        distances = np.linalg.norm(away / expansion.trust_radius[:, None], axis=0)
        other = self.points.damping_scale[places] != expansion.point.damping_scale
        return np.where(other, np.inf, distances)

    def _answer(self, expansion: SpectralExpansion, places: IndexArray) -> None:
        for start in range(0, places.size, _CHUNK):
            chunk = places[start:start + _CHUNK]
            roots, errors = expansion.eigenvalues(self._coefficients[:, chunk])
            good = self._good(expansion, roots, errors)
            if good.any():
                self._take(chunk[good], roots[:, good], errors[:, good])

    def _good(self, expansion: SpectralExpansion, roots: ComplexArray, errors: FloatArray) -> Any:
        """Tell which points are answered well enough, with no verdict that hangs on the errors."""
        limits = self.tolerances
        became_real = expansion.mirrored[:, None] & (roots.imag <= limits.oscillation)
        return ~((errors > self.solver.errors.allowed(roots)) | became_real
                 | verdict_within_error(roots, errors, limits)).any(axis=0)

    def _take(self, places: IndexArray, roots: ComplexArray, errors: FloatArray) -> None:
        """Sort the roots of points into modes, in order of index."""
        zeros = np.zeros((self._free, places.size))
        roots, errors = np.concatenate([zeros, roots]), np.concatenate([zeros, errors])
        quiet = np.abs(roots.imag) <= self.tolerances.oscillation
        upper = roots.imag > self.tolerances.oscillation
        count = quiet.sum(axis=0)
        key = np.where(quiet, -1.0, np.where(upper, roots.imag, np.inf))
        order = np.lexsort((np.where(quiet, -roots.real, roots.real), key), axis=0)
        for quiets in np.unique(count).tolist():
            of = np.flatnonzero(count == quiets)
            rows = np.concatenate([np.arange(quiets // 2),
                                   np.arange(quiets,
                                             quiets // 2 + self.mode_eigenvalues.shape[1])])
            of = of[upper[:, of].sum(axis=0) + quiets // 2 == self.mode_eigenvalues.shape[1]]
            chosen = order[rows[:, None], of]
            self.mode_eigenvalues[places[of]] = roots[chosen, of].T
            self.errors[places[of]] = errors[chosen, of].T
            self._waiting[places[of]] = False

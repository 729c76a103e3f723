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
Mode tracking: identities that modes keep along a path, through veering and merging.

The identity of a mode is K09's number: its place in order of frequency without friction (mu = 0).
It is carried along by left and right vectors in small steps. Where two modes come so close to
merging that the way of each cannot be told, both carry both numbers from there on, as '13/14'.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, readonly
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import classify, Mode, Tolerances
from squeal_core.stability.parameter_paths import _COORDINATES, between, matrices, MatrixPath
from squeal_core.stability.state_space import state_matrix

RESOLUTION = 1e-2  # least step, as a part of the way; friction is not known any better
LONGEST_STEP = 0.25  # of the way
OVERLAP = 0.25  # how far the overlap of a mode with itself, a step on, may be from one


@dataclass(frozen=True)
class Identity:
    """Numbers of a mode, as text '25'; of modes that merged, those of all of them: '25/26'."""

    numbers: tuple[int, ...]

    @property
    def merged(self) -> bool:
        return len(self.numbers) > 1

    def __str__(self) -> str:
        return '/'.join(map(str, self.numbers))

    def joined(self, other: 'Identity') -> 'Identity':
        return Identity(tuple(sorted({*self.numbers, *other.numbers})))


@dataclass(frozen=True)
class Spectrum:
    """
    All eigenvalues at a point, and the vectors of the n modes that oscillate, by frequency.

    Columns of `right` (M, n) and rows of `left` (n, M) are those of the first-order form, scaled
    so that left @ right = 1.
    """

    eigenvalues: ComplexArray
    right: ComplexArray
    left: ComplexArray


@dataclass(frozen=True)
class Tracked:
    """
    The modes at a point in order of index, and the identity of each.

    Modes that do not oscillate share one eigenvalue at zero without friction, or nearly so, and
    are numbered by growth rate; once one came from or went to the oscillating ones they share
    theirs.
    """

    modes: tuple[Mode, ...]
    identities: tuple[Identity, ...]
    spectrum: Spectrum

    def of(self, numbers: Collection[int]) -> tuple[Mode, ...]:
        """Return the modes that carry one of the numbers, worst first."""
        result = [mode for mode, identity in zip(self.modes, self.identities, strict=True)
                  if not set(numbers).isdisjoint(identity.numbers)]
        return tuple(sorted(result, key=lambda mode: -mode.growth_rate))

    def mode(self, number: int) -> Mode | None:
        """Return the mode of a number; of those that merged the lowest is the least stable."""
        same = self.of((number,))
        if not same:
            return None
        return same[min(self.identity(same[0]).numbers.index(number), len(same) - 1)]

    def identity(self, mode: Mode) -> Identity:
        """Return the identity of one of the modes."""
        return self.identities[mode.index - 1]


def identities(model: BrakeModel, point: OperatingPoint, *, resolution: float = RESOLUTION,
               tolerances: Tolerances | None = None) -> tuple[Identity, ...]:
    """Return the identity of each mode of `complex_modes(model, point)`; see `identify`."""
    return identify(model, point, resolution=resolution, tolerances=tolerances).identities


def identify(model: BrakeModel, point: OperatingPoint, *, resolution: float = RESOLUTION,
             tolerances: Tolerances | None = None) -> Tracked:
    """
    Return the modes at a point and their identities, carried there from mu = 0.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Friction and its slope grow together from zero to their values here; speed, pressure and
        contact stiffness stay.
    resolution : float
        Least step, as a part of the way; modes that cannot be told apart by it are merged.
    tolerances : Tolerances, optional
        Of the classification of eigenvalues.

    Notes
    -----
    Modes are matched between steps by P_ij = (w_i^H v'_j)(w'_j^H v_i), the overlap of their
    spectral projectors. It does not depend on the scale of vectors or a doublet's orientation,
    is 1 for a mode that stays what it is, and is far from 1 near a merging. A step after which
    any mode's overlap with itself is off by more than a quarter is made smaller.

    """
    limits = tolerances or Tolerances.of(model, point)

    def family(way: float) -> tuple[FloatArray, FloatArray]:
        return matrices(model, replace(
            point, friction=way * point.friction, friction_slope=way * point.friction_slope))

    start = numbered(model, family, tolerances=limits)
    if point.friction == 0.0 and point.friction_slope == 0.0:
        return start
    return follow(model, family, start, resolution=resolution, tolerances=limits)


def track(model: BrakeModel, points: Sequence[OperatingPoint], *, resolution: float = RESOLUTION,
          tolerances: Tolerances | None = None) -> Iterator[Tracked]:
    """
    Yield modes and identities at points along a path: `identify` at the first, then on.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    points : sequence of OperatingPoint
        The path is straight between them.
    resolution : float
        Least step, as a part of the largest value that a parameter takes on the path: where the
        path begins makes no difference.
    tolerances : Tolerances, optional
        Of the classification of eigenvalues.

    """
    limits = tolerances or Tolerances.of(model, *points[:1])
    values = np.array([[getattr(point, name) for name in _COORDINATES] for point in points])
    largest = np.abs(values).max(axis=0, initial=0.0)
    for i, point in enumerate(points):
        if i == 0:
            here = identify(model, point, resolution=resolution, tolerances=limits)
        else:
            change = np.abs(values[i] - values[i - 1])[largest > 0.0] / largest[largest > 0.0]
            here = follow(model, between(model, points[i - 1], point), here, tolerances=limits,
                          resolution=resolution, parts=1.0 / max(change.max(), resolution))
        yield here


def numbered(model: BrakeModel, family: MatrixPath, *, tolerances: Tolerances) -> Tracked:
    """Return the modes where a way begins, each numbered by its index there."""
    spectrum = _spectrum(model, family(0.0), tolerances)
    modes = classify(spectrum.eigenvalues, tolerances).modes
    return Tracked(modes, tuple(Identity((mode.index,)) for mode in modes), spectrum)


def follow(model: BrakeModel, family: MatrixPath, start: Tracked, *,
           resolution: float = RESOLUTION, parts: float = 1.0, tolerances: Tolerances) -> Tracked:
    """
    Carry identities along a way; see `identify` for how.

    Parameters
    ----------
    model : BrakeModel
        Says which coordinates have no stiffness.
    family : callable
        Damping [1/s] and stiffness [1/s^2], (N, N) each, from 0, where `start` is, to 1.
    start : Tracked
        Where it begins.
    resolution : float
        Least step, as a part of the whole path.
    parts : float
        How many times as long as this way the path is.
    tolerances : Tolerances
        Of the classification of eigenvalues.

    """
    least, longest = min(resolution * parts, 1.0), min(LONGEST_STEP * parts, 1.0)
    here, way, step = start, 0.0, longest
    while way < 1.0:
        step = min(max(step, least), longest, 1.0 - way)
        there = _spectrum(model, family(way + step), tolerances)
        match = _Match(here, there)
        if match.doubtful and step > least:
            step /= 4.0
            continue
        match.settle()
        here = Tracked(classify(there.eigenvalues, tolerances).modes, match.identities(), there)
        # to the end exactly, though steps are added up
        way, step = (1.0 if step == 1.0 - way else way + step), 2.0 * step
    return here


class _Match:
    """The modes of one point among those of the next; merged modes are one unit."""

    def __init__(self, old: Tracked, new: Spectrum) -> None:
        count = old.spectrum.right.shape[1]
        quiet = old.identities[:len(old.identities) - count]
        self._labels = list(old.identities[len(quiet):])
        self._still = Identity(tuple(sorted({n for i in quiet for n in i.numbers})))
        self._mixed = any(identity.merged for identity in quiet)
        self._size = new.eigenvalues.size // 2
        self._overlap = (old.spectrum.left @ new.right) * (new.left @ old.spectrum.right).T
        self._assign()

    def _assign(self) -> None:
        """Assign a unit to each new mode, and compute what units share over the step."""
        from scipy.optimize import linear_sum_assignment  # slow to load, and few commands follow
        self._units = list(dict.fromkeys(self._labels))
        before = _membership(self._units, self._labels)
        grouped = before @ self._overlap
        rows, columns = linear_sum_assignment(-np.abs(before.T @ grouped))
        self._new: list[Identity | None] = [None] * self._overlap.shape[1]
        for row, column in zip(rows, columns, strict=True):
            self._new[column] = self._labels[row]
        self._stopped = set(range(len(self._labels))) - set(rows.tolist())
        shared = grouped @ _membership(self._units, self._new).T
        self._unlike = np.abs(np.diag(shared) - before.sum(axis=1)) > OVERLAP
        self._shared = np.maximum(np.abs(shared), np.abs(shared).T)
        np.fill_diagonal(self._shared, 0.0)

    @property
    def doubtful(self) -> bool:
        """Return whether the identity of a unit is uncertain, or the number of modes changed."""
        return bool(self._unlike.any()) or len(self._labels) != len(self._new)

    def settle(self) -> None:
        """Merge units that cannot be told apart, until the rest can."""
        while True:
            shared = self._shared * self._unlike[:, None]
            if shared.size == 0 or shared.max() <= 0.25 * OVERLAP:
                break
            pair = [self._units[i] for i in np.unravel_index(shared.argmax(), shared.shape)]
            self._labels = [pair[0].joined(pair[1]) if label in pair else label
                            for label in self._labels]
            self._assign()
        for row in self._stopped:  # oscillates no more
            self._still, self._mixed = self._still.joined(self._labels[row]), True
        self._mixed = self._mixed or None in self._new

    def identities(self) -> tuple[Identity, ...]:
        """Return the identities after the step, in order of index."""
        quiet = self._size - len(self._new)
        first = ([self._still] * quiet if self._mixed
                 else [Identity((number,)) for number in self._still.numbers])
        return (*first, *(self._still if label is None else label for label in self._new))


def _membership(units: Sequence[Identity], labels: Sequence[Identity | None]) -> FloatArray:
    """Return 1 where a label (column) is a unit's (row), else 0."""
    row = {unit: i for i, unit in enumerate(units)}
    rows = np.array([-1 if label is None else row[label] for label in labels], int)
    return np.asarray(rows == np.arange(len(units))[:, None], float)


def _spectrum(model: BrakeModel, of: tuple[FloatArray, FloatArray],
              tolerances: Tolerances) -> Spectrum:
    eigenvalues, right = np.linalg.eig(state_matrix(model, *of))
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:  # two vectors are one, to the last bit
        left = np.linalg.pinv(right)
    chosen = np.flatnonzero(eigenvalues.imag > tolerances.oscillation)
    chosen = chosen[np.lexsort((eigenvalues[chosen].real, eigenvalues[chosen].imag))]
    every = np.concatenate([np.zeros(2 * model.size - eigenvalues.size), eigenvalues])
    return Spectrum(*(readonly(a, complex) for a in (every, right[:, chosen], left[chosen])))

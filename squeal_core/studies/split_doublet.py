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
Masses on the disc that split one of its doublets, and their effect on growth rates.

A disc of revolution has doublets: two modes of n nodal diameters at one frequency, which friction
couples at any strength. 2n equal masses evenly round the disc load one of the two and not the
other. They turn with the disc: here they are frozen at angles to the pads, one after another.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
import math

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly, RealArray
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.change_of_basis import in_basis
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND, Tolerances
from squeal_core.stability.mode_tracking import Identity, Tracked
from squeal_core.studies.design_effects import ModeFollower, Variant
from squeal_core.studies.target_modes import TargetMode

ANGLES = 24
PAIR = 1e-2  # relative distance of frequencies within which two modes are a doublet
_LARGEST_SPLIT = 0.1  # masses are small against the disc's, or its modes are not those any more
_SECANTS = 6


@dataclass(frozen=True)
class DiscRing:
    """
    Shapes of the disc's modes on the outermost arc of the swept ring, as Fourier series.

    Parameters
    ----------
    places : (D,) index array
        Of the disc's modes in the model.
    radius : float
        Of the arc [m].
    series : (K, 3, D) array
        Coefficients of exp(i k theta) of radial, tangential and normal shapes [kg^-1/2].

    """

    places: IndexArray
    radius: float
    series: ComplexArray

    @classmethod
    def of(cls, model: BrakeModel) -> 'DiscRing':
        """Return that of a model with surface shapes of a whole ring."""
        first = 0
        for patch in model.surface.patches if model.surface else ():
            if patch.closed:
                break
            first += patch.size
        else:
            raise SquealError('--split-doublet: the model has no shapes round the disc; build it '
                              'from a brake description')
        assert model.surface is not None
        arc = slice(first + (patch.rows - 1) * patch.columns, first + patch.size)
        points, shapes = model.surface.points[arc], model.surface.shapes[arc]
        places = np.flatnonzero(np.abs(shapes).max(axis=(0, 1)) > 0.0)
        angle = np.arctan2(points[:, 1], points[:, 0])
        c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
        x, y, z = shapes[:, :, places].transpose(1, 0, 2)
        polar = np.stack([c * x + s * y, c * y - s * x, z], axis=1)
        turn = np.exp(-1j * np.arange(patch.columns // 2) * angle[0])[:, None, None]
        series = np.fft.rfft(polar, axis=0)[:patch.columns // 2] / patch.columns * turn
        series[1:] *= 2.0
        return cls(places, float(np.hypot(*points[0, :2])), series)

    def at(self, angles: RealArray) -> FloatArray:
        """Return radial, tangential and normal shapes at angles [rad], (3 angles, D)."""
        waves = np.exp(1j * np.multiply.outer(angles, np.arange(len(self.series))))
        return np.asarray(np.einsum('ak,kcd->acd', waves, self.series).real.reshape(
            3 * angles.size, -1))

    @property
    def diameters(self) -> IndexArray:
        """Return the number of nodal diameters of each mode, (D,)."""
        return np.asarray((np.abs(self.series)**2).sum(axis=1).argmax(axis=0))

    def doublet(self, model: BrakeModel, diameters: int) -> tuple[int, int]:
        """Return the places among the disc's modes of its lowest doublet of n diameters."""
        order = self.diameters
        frequencies = model.angular_frequencies[self.places]
        own = np.flatnonzero(order == diameters).tolist()
        for first, second in zip(own, own[1:], strict=False):
            if frequencies[second] - frequencies[first] < PAIR * frequencies[second]:
                return first, second
        known = sorted({int(n) for n in order if n and np.sum(order == n) > 1})
        raise SquealError(f'--split-doublet: is {diameters}; the disc has doublets of '
                          f'{", ".join(map(str, known))} nodal diameters')


@dataclass(frozen=True)
class SplitDoublet:
    """
    2n equal masses on the disc.

    Parameters
    ----------
    model : BrakeModel
        Without them.
    ring : DiscRing
        Where they sit.
    diameters : int
        n.
    doublet : (2,) ints
        Places of the doublet among the disc's modes.
    mass : float
        Of each [kg].

    """

    model: BrakeModel
    ring: DiscRing
    diameters: int
    doublet: tuple[int, int]
    mass: float

    @classmethod
    def of(cls, model: BrakeModel, diameters: int, *, split: float | None = None,
           mass: float | None = None) -> 'SplitDoublet':
        """
        Return masses of a given size, or those that split the doublet by so much.

        Parameters
        ----------
        model : BrakeModel
            With surface shapes.
        diameters : int
            n of the doublet.
        split : float, optional
            Distance of its two frequencies, of their mean [-].
        mass : float, optional
            Of each [kg]; one of the two is given.

        Raises
        ------
        SquealError
            For a disc without such a doublet, or masses that are not small.

        """
        ring = DiscRing.of(model)
        doublet = ring.doublet(model, diameters)
        if mass is None:
            assert split is not None
            mass, goal = 1e-3, split
            for _ in range(_SECANTS):  # nearly in proportion
                mass *= goal / max(cls(model, ring, diameters, doublet, mass).split, 1e-12)
                if not mass < 1e3:
                    break
        result = cls(model, ring, diameters, doublet, mass)
        if not result.split <= _LARGEST_SPLIT:
            raise SquealError(f'--split-doublet: masses of {1e3 * mass:.4g} g split the doublet '
                              f'by {100.0 * result.split:.3g} %; give less, '
                              f'{_LARGEST_SPLIT:.0%} at most: modes are those of the bare disc')
        return result

    @property
    def count(self) -> int:
        """Return the number of masses."""
        return 2 * self.diameters

    @property
    def period(self) -> float:
        """Return the angle after which the masses are where they were [rad]."""
        return math.pi / self.diameters

    @property
    def bare_hz(self) -> float:
        """Return the frequency of the free disc's doublet without the masses [Hz]."""
        own = self.ring.places[list(self.doublet)]
        return float(self.model.angular_frequencies[own].mean()) / math.tau

    @property
    def frequencies_hz(self) -> tuple[float, float]:
        """Return the frequencies of the free disc's doublet with the masses, rising [Hz]."""
        basis = self._without_mass(self._added(0.0))
        squares, vectors = np.linalg.eigh(
            basis @ np.diag(self.model.angular_frequencies[self.ring.places]**2) @ basis)
        own = (vectors[list(self.doublet)]**2).sum(axis=0)
        first, second = np.sort(np.sqrt(squares[np.sort(own.argsort()[-2:])])) / math.tau
        return float(first), float(second)

    @property
    def split(self) -> float:
        """Return the distance of the doublet's frequencies, of their mean [-]."""
        first, second = self.frequencies_hz
        return 2.0 * (second - first) / (second + first)

    def at(self, angle: float) -> BrakeModel:
        """Return the model with the masses frozen at an angle [rad] to the middle of the pads."""
        basis = np.eye(self.model.size)
        basis[np.ix_(self.ring.places, self.ring.places)] = self._without_mass(self._added(angle))
        return in_basis(self.model, basis, reference=self.model)

    def _added(self, angle: float) -> FloatArray:
        """Return the masses' modal mass [-], (D, D)."""
        shapes = self.ring.at(angle + self.period * np.arange(self.count))
        return np.asarray(self.mass * shapes.T @ shapes)

    @staticmethod
    def _without_mass(added: FloatArray) -> FloatArray:
        """Return (1 + added)^(-1/2): coordinates in which the mass is 1 again."""
        values, vectors = np.linalg.eigh(added)
        return np.asarray((vectors / np.sqrt(1.0 + values)) @ vectors.T)


@dataclass(frozen=True)
class ModeOverAngle:
    """Growth rate of one mode [1/s]: without masses, and with them at each angle, (A,)."""

    identity: Identity
    frequency_hz: float
    without: float
    over_angle: FloatArray


@dataclass(frozen=True)
class SplitGrowth:
    """
    Growth rates with the masses frozen at angles to the middle of the pads.

    Parameters
    ----------
    angles : (A,) array
        Over one period of the masses [rad].
    least_stable : ModeOverAngle
        Whichever mode of the band that is at each angle; identity and frequency are those without
        masses.
    modes : tuple of ModeOverAngle
        The target, then others.

    """

    angles: FloatArray
    least_stable: ModeOverAngle
    modes: tuple[ModeOverAngle, ...]


def split_growth(masses: SplitDoublet, target: TargetMode, tracked: Tracked, *,
                 band_hz: tuple[float, float] = SQUEAL_BAND, angles: int = ANGLES,
                 progress: Callable[[int, int], None] = lambda *_: None) -> SplitGrowth:
    """
    Return growth rates of modes over one period of the masses.

    Parameters
    ----------
    masses : SplitDoublet
        On the disc.
    target : TargetMode
        A mode and the others of the band.
    tracked : Tracked
        All modes at its point, without masses.
    band_hz : (2,) floats
        Squeal band.
    angles : int
        How many.
    progress : callable
        Told how many are done, and of how many.

    """
    model, point = masses.model, target.point
    follower = ModeFollower(model, point, tracked, Tolerances.of(model, point))
    modes = [(target.identity, target.eigenvalue), *target.others]
    places = masses.period * np.arange(angles) / angles
    rows, worst = [], []
    for place in places.tolist():
        loaded = masses.at(place)
        rows.append(follower.eigenvalues(Variant(loaded, point),
                                         [identity for identity, _ in modes]).real)
        mode = complex_modes(loaded, point).worst_in(*band_hz)
        worst.append(math.nan if mode is None else mode.growth_rate)
        progress(len(rows), angles)
    result = tuple(ModeOverAngle(identity, value.imag / math.tau, value.real, readonly(growth))
                   for (identity, value), growth in zip(modes, np.array(rows).T, strict=True))
    before = max(result, key=lambda mode: mode.without)
    return SplitGrowth(readonly(places), replace(before, over_angle=readonly(worst)), result)

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

"""Families of modes that couple, single ones or pairs, by the shapes of modes without friction."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
import math

import numpy as np
import scipy  # its parts are loaded at first use: optimize is slow to load
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.model.brake_model import BrakeModel

_STEP = 0.025  # of ln k_c between reference shapes
_NEAR = 0.03  # relative distance of eigenvalues within which mixed shapes mean coupling
_COUPLED = 0.03  # mean squared projection from which on modes are of one family
_MIXED = 0.005  # likewise, of one cluster
_LARGEST_CLUSTER = 12  # modes; its small matrices are kept at all points


@dataclass(frozen=True)
class ModeFamily:
    """
    A mode, or two that couple, such as a doublet.

    Parameters
    ----------
    numbers : tuple of int
        Mode numbers, by frequency at mu = 0 and nominal contact stiffness.
    frequency_hz : float
        Mean there [Hz].
    decay_rate : float
        -Re(lambda) there at nominal damping, mean [1/s].
    largest_growth : float
        Largest growth rate in an emulator's domain [1/s]; infinite where it is not known.

    """

    numbers: tuple[int, ...]
    frequency_hz: float
    decay_rate: float
    largest_growth: float = math.inf


class ReferenceModes:
    """
    Shapes of the modes without friction and damping over contact stiffness.

    They are orthonormal, numbered by frequency at the nominal stiffness, and followed from there
    by their shapes, so that modes that cross keep their numbers.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    stiffness : (2,) floats
        Lowest and highest k_c [N/m^3].

    """

    def __init__(self, model: BrakeModel, stiffness: tuple[float, float]) -> None:
        nominal = model.nominal_contact_stiffness
        low, high = (round(float(np.log(end / nominal)) / _STEP) for end in stiffness)
        self._first = min(low, 0)
        up = list(_followed(model, nominal * np.exp(_STEP * np.arange(max(high, 0) + 1))))
        down = list(_followed(model, nominal * np.exp(-_STEP * np.arange(1 - self._first))))
        self._shapes = np.stack([*down[:0:-1], *up])
        self._nominal = nominal

    def at(self, stiffness: float) -> FloatArray:
        """Return the shapes (N, N), one in each column, at the nearest stiffness that there is."""
        place = round(float(np.log(stiffness / self._nominal)) / _STEP) - self._first
        return np.asarray(self._shapes[min(max(place, 0), len(self._shapes) - 1)])

    def numbered(self, shapes: ComplexArray,
                 stiffness: float) -> tuple[IndexArray, IndexArray, FloatArray]:
        """
        Return numbers - 1 and columns of complex modes (N, n), and all squared projections.

        The projections (N, n) are on the references; a mode without a number is left out.
        """
        projections = np.abs(self.at(stiffness).T @ shapes) ** 2
        numbers, columns = scipy.optimize.linear_sum_assignment(-projections)
        return numbers, columns, projections


def _followed(model: BrakeModel, stiffnesses: FloatArray) -> Iterator[FloatArray]:
    before = None
    for stiffness in stiffnesses.tolist():
        matrix = np.diag(model.angular_frequencies**2)
        for factor, array in ((1.0, model.support_stiffness),
                              (stiffness, model.contact_stiffness)):
            if array is not None:
                matrix = matrix + factor * array
        shapes = np.linalg.eigh(matrix)[1]
        if before is not None:
            shapes = shapes[:, scipy.optimize.linear_sum_assignment(-(before.T @ shapes) ** 2)[1]]
        yield shapes
        before = shapes


def mixing(eigenvalues: ComplexArray, projections: FloatArray) -> FloatArray:
    """
    Return the degree to which modes mix while eigenvalues are near, (N, N), symmetric.

    Parameters
    ----------
    eigenvalues : (P, N) array
        By number, at P points; NaN where there is none.
    projections : (P, N, N) array
        Squared projections on the references (last axis) of the modes (second).

    """
    apart = np.abs(eigenvalues[:, :, None] - eigenvalues[:, None, :])
    near = apart < _NEAR * np.abs(eigenvalues)[:, :, None]
    mixed = np.where(near, projections, 0.0).mean(axis=0)
    return np.asarray(np.maximum(mixed, mixed.T))


def coupled(mixed: FloatArray) -> list[IndexArray]:
    """Return the places of the modes of each family: single modes, and pairs that mix most."""
    mixed = np.triu(mixed, 1)
    free, result = np.ones(len(mixed), bool), []
    for i, j in np.argwhere(mixed > _COUPLED)[np.argsort(-mixed[mixed > _COUPLED])]:
        if free[i] and free[j]:
            free[[i, j]] = False
            result.append(np.array([i, j]))
    return sorted([*result, *np.flatnonzero(free)[:, None]], key=lambda places: int(places[0]))


def clusters(mixed: FloatArray, families: Iterable[IndexArray]) -> list[IndexArray]:
    """Return the places of modes that mix at all, directly or by others; families stay whole."""
    bound = np.zeros_like(mixed, bool)
    for places in families:
        bound[np.ix_(places, places)] = True
    threshold = _MIXED
    while True:
        _, labels = scipy.sparse.csgraph.connected_components(
            bound | (mixed > threshold), directed=False)
        result = [np.flatnonzero(labels == label) for label in range(labels.max() + 1)]
        if max(map(len, result)) <= _LARGEST_CLUSTER or threshold > 1.0:
            return result
        threshold *= 1.5

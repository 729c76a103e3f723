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

"""Modes of several models matched with each other: by MAC of their shapes, or by frequencies."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, repr_with_shapes
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.surface_shapes import SurfaceShapes
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.mode_tracking import numbered, Tracked

DOUBLET = 0.02  # relative difference of frequencies: pads and rotation split doublets by less
LEAST_MAC = 0.6  # under it modes are not the same; planes with one shape in common have 0.5
FARTHEST = 0.1  # relative difference of frequencies, beyond which modes without shapes are not
_BREAKS_TIES = 1e-3  # what frequencies and single shapes count beside the MAC of doublets


@dataclass(frozen=True, eq=False)
class ModeShapes:
    """
    Oscillating modes of a model, by frequency.

    Parameters
    ----------
    frequencies_hz : (n,) array
    shapes : (3 P, n) complex array, optional
        Displacements at the points of its surfaces; None: it carries none.
    surface : SurfaceShapes, optional
        Where they are.

    """

    frequencies_hz: FloatArray
    shapes: ComplexArray | None = None
    surface: SurfaceShapes | None = None

    __repr__ = repr_with_shapes


class ModeMatch(NamedTuple):
    """
    Modes of one model (n) among those of another.

    Attributes
    ----------
    places : (n,) index array
        Of the mode of the other that is the same; -1: none.
    mac : (n,) array
        Of both; NaN where there are no shapes.
    basis : str
        By what they were matched, in words.

    """

    places: IndexArray
    mac: FloatArray
    basis: str


def frictionless_modes(model: BrakeModel, point: OperatingPoint) -> tuple[Tracked, ModeShapes]:
    """Return numbered modes at a point without friction, and shapes of those that oscillate."""
    still = replace(point, friction=0.0, friction_slope=0.0)
    start = numbered(model, lambda _: (model.damping(still), model.stiffness(still)),
                     tolerances=Tolerances.of(model, point))
    vectors = start.spectrum.right[-model.size:]  # velocities, of all coordinates
    oscillating = start.modes[model.size - vectors.shape[1]:]
    hertz = np.array([mode.frequency_hz for mode in oscillating])
    if model.surface is None:
        return start, ModeShapes(hertz)
    motion = model.surface.shapes.reshape(-1, model.size) @ vectors
    return start, ModeShapes(hertz, motion, model.surface)


def match_modes(first: ModeShapes, second: ModeShapes) -> ModeMatch:
    """
    Match modes one to one.

    Parameters
    ----------
    first, second : ModeShapes
        Of two models.

    Notes
    -----
    Points of surfaces are taken for the same by their place in the pad or in the ring that the
    pads sweep, so brakes of other dimensions can be compared. Shapes of a doublet are any
    combination of two, and small changes turn them: for two modes of nearly one frequency in both
    models the MAC is that of the planes that the shapes span, the mean of the squared cosines
    between them, where that is larger. It does not depend on order, signs or orientation.

    """
    why_not = _without_shapes(first, second)
    ratio = np.abs(np.log(first.frequencies_hz[:, None] / second.frequencies_hz))
    if why_not:
        places = _assigned(-ratio, ratio <= FARTHEST)
        return ModeMatch(places, np.full(places.size, np.nan), f'frequencies, as {why_not}')
    assert first.shapes is not None
    assert second.shapes is not None
    single = assurance(first.shapes, second.shapes)
    mac = np.maximum(single, _of_doublets(first, second))
    places = _assigned(mac + _BREAKS_TIES * (single - ratio), mac >= LEAST_MAC)
    own = np.where(places < 0, np.nan, mac[np.arange(places.size), places])
    return ModeMatch(places, own, 'MAC of shapes')


def assurance(first: ComplexArray, second: ComplexArray) -> FloatArray:
    """Return the MAC (n, m) of shapes (P, n) and (P, m), |a^H b|^2 / (a^H a b^H b)."""
    cross = np.abs(first.conj().T @ second) ** 2
    norms = np.outer(np.sum(np.abs(first)**2, axis=0), np.sum(np.abs(second)**2, axis=0))
    return np.asarray(np.divide(cross, norms, out=np.zeros_like(cross), where=norms > 0.0))


def _of_doublets(first: ModeShapes, second: ModeShapes) -> FloatArray:
    """Return the largest MAC of planes that two modes (n, m) are in; 0 for those in none."""
    result = np.zeros((first.frequencies_hz.size, second.frequencies_hz.size))
    pairs, planes = zip(*map(_planes, (first, second)), strict=True)
    if not all(map(len, pairs)):
        return result
    cosines = np.abs(planes[0].conj().T @ planes[1]) ** 2
    mac = 0.5 * cosines.reshape(len(pairs[0]), 2, len(pairs[1]), 2).sum(axis=(1, 3))
    for one in (0, 1):
        for other in (0, 1):
            np.maximum.at(result, np.ix_(pairs[0][:, one], pairs[1][:, other]), mac)
    return result


def _planes(modes: ModeShapes) -> tuple[IndexArray, ComplexArray]:
    """Return pairs (k, 2) of modes of nearly one frequency, and bases of planes (P, 2 k)."""
    assert modes.shapes is not None
    hertz = modes.frequencies_hz
    pairs = np.argwhere(np.triu(np.abs(hertz[:, None] - hertz) <= DOUBLET * hertz, 1))
    bases = [np.linalg.qr(modes.shapes[:, pair])[0] for pair in pairs]
    return pairs, np.concatenate([np.empty((len(modes.shapes), 0)), *bases], axis=1)


def _without_shapes(first: ModeShapes, second: ModeShapes) -> str:
    """Return the reason why shapes cannot be compared; empty where they can."""
    if first.surface is None or second.surface is None:
        return 'not both carry shapes'
    grids = [[(p.name, p.rows, p.columns, p.closed) for p in one.surface.patches]
             for one in (first, second) if one.surface]
    return '' if grids[0] == grids[1] else 'their surfaces have other points'


def _assigned(similarity: FloatArray, admitted: NDArray[np.bool_]) -> IndexArray:
    """Return the most similar partners, one to one; -1 where none is allowed."""
    places = np.full(len(similarity), -1, np.intp)
    if similarity.size:
        # a pair that is not allowed costs more than any sum of allowed ones
        worst = 10.0 * len(similarity) * (1.0 + np.abs(similarity).max())
        rows, columns = linear_sum_assignment(np.where(admitted, -similarity, worst))
        fit = admitted[rows, columns]
        places[rows[fit]] = columns[fit]
    return places

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

DOUBLET = 5e-3  # relative difference of frequencies up to which two modes may be a doublet
LEAST_MAC = 0.5  # under it modes are not the same
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
    pads sweep, so brakes of other dimensions can be compared. Shapes of a doublet, two modes of
    nearly one frequency, are any combination of two: where both models have one, the MAC is that
    of the planes that both shapes span, the mean of the squared cosines between them. It does not
    depend on order, signs or orientation.

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


def doublets(frequencies_hz: FloatArray) -> list[tuple[int, int]]:
    """Return pairs of neighbours of nearly one frequency, the closest first; each mode once."""
    gaps = np.diff(frequencies_hz) / frequencies_hz[1:]
    found: list[tuple[int, int]] = []
    taken: set[int] = set()
    for low in np.argsort(gaps, kind='stable').tolist():
        if gaps[low] <= DOUBLET and not {low, low + 1} & taken:
            found.append((low, low + 1))
            taken |= {low, low + 1}
    return found


def _of_doublets(first: ModeShapes, second: ModeShapes) -> FloatArray:
    """Return the MAC of the planes of doublets, (n, m); 0 for modes that are in none."""
    found = np.zeros((first.frequencies_hz.size, second.frequencies_hz.size))
    assert first.shapes is not None
    assert second.shapes is not None
    for own in doublets(first.frequencies_hz):
        plane = np.linalg.qr(first.shapes[:, own])[0]
        for other in doublets(second.frequencies_hz):
            across = plane.conj().T @ np.linalg.qr(second.shapes[:, other])[0]
            found[np.ix_(own, other)] = np.linalg.norm(across) ** 2 / 2.0
    return found


def _without_shapes(first: ModeShapes, second: ModeShapes) -> str:
    """Return why shapes cannot be compared; empty where they can."""
    if first.surface is None or second.surface is None:
        return 'not both carry shapes'
    grids = [[(p.name, p.rows, p.columns, p.closed) for p in one.surface.patches]
             for one in (first, second) if one.surface]
    return '' if grids[0] == grids[1] else 'their surfaces have other points'


def _assigned(similarity: FloatArray, admitted: NDArray[np.bool_]) -> IndexArray:
    """Return the most similar partners, one to one; -1 where none is allowed."""
    places = np.full(len(similarity), -1, np.intp)
    if similarity.size:
        # what is not allowed is worse than any sum of what is
        worst = 10.0 * len(similarity) * (1.0 + np.abs(similarity).max())
        rows, columns = linear_sum_assignment(np.where(admitted, -similarity, worst))
        fit = admitted[rows, columns]
        places[rows[fit]] = columns[fit]
    return places

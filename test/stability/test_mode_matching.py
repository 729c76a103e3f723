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

"""Matching of modes: it does not depend on order, signs, or how doublets are turned."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
import pytest
from squeal_core import BrakeModel
from squeal_core.model.surface_shapes import Patch, SurfaceShapes
from squeal_core.stability.mode_matching import (
    assurance,
    frictionless_modes,
    match_modes,
    ModeShapes,
)
from support.stability_models import kang_point


def turned(model: BrakeModel, seed: int) -> BrakeModel:
    """Return the same brake in other coordinates: permuted, of other signs, doublets rotated."""
    rng = np.random.default_rng(seed)
    w, basis = model.angular_frequencies, np.diag(rng.choice([-1.0, 1.0], model.size))
    for first in np.flatnonzero((np.diff(w) == 0.0) & (w[1:] > 0.0)).tolist():
        angle = rng.uniform(0.0, np.pi)
        c, s = np.cos(angle), np.sin(angle)
        pair = [first, first + 1]
        basis[:, pair] = basis[:, pair] @ [[c, -s], [s, c]]
    order = rng.permutation(model.size)
    basis = basis[:, order]
    arrays = {name: basis.T @ getattr(model, name) @ basis for name in (
        'gyroscopic', 'contact_stiffness', 'friction_couple', 'radial_dissipation',
        'negative_slope')}
    assert model.surface is not None
    surface = SurfaceShapes(model.surface.points, model.surface.shapes @ basis,
                            model.surface.patches)
    return replace(model, angular_frequencies=w[order], names=(), surface=surface, **arrays)


def test_a_brake_matches_itself_in_any_coordinates(kang: BrakeModel) -> None:
    point = kang_point(kang, 20.0)
    own = frictionless_modes(kang, point)[1]
    for other in (own, frictionless_modes(turned(kang, 1), point)[1]):
        found = match_modes(own, other)
        assert found.basis == 'MAC of shapes'
        np.testing.assert_array_equal(found.places, np.arange(found.places.size))
        # eigenvectors of neighbours 1e-3 apart are good to 1e-10 or so
        np.testing.assert_allclose(found.mac, 1.0, atol=1e-6)


def ring(shapes: NDArray[np.float64], hertz: list[float]) -> ModeShapes:
    """Return modes of a ring from axial shapes (P, n) at P points around it."""
    angle = 2.0 * np.pi * np.arange(len(shapes) // 2) / (len(shapes) // 2)
    points = np.concatenate([np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.0 * angle])
                             for r in (0.1, 0.14)])
    motion = np.zeros((len(shapes), 3, shapes.shape[1]))
    motion[:, 2] = shapes
    surface = SurfaceShapes(points, motion, (Patch('disc', 2, len(angle), True),))
    return ModeShapes(np.array(hertz), motion.reshape(-1, shapes.shape[1]).astype(complex),
                      surface)


def around(count: int, *phases: tuple[int, float]) -> NDArray[np.float64]:
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.tile(np.column_stack([np.cos(n * angle - phase) for n, phase in phases]), (2, 1))


def test_the_mac_of_a_doublet_is_that_of_its_plane() -> None:
    angle = np.pi / 6.0
    own = ring(around(24, (3, 0.0), (3, np.pi / 2.0)), [1000.0, 1000.0])
    other = ring(around(24, (3, angle), (3, angle + np.pi / 2.0)), [1010.0, 1010.0])
    assert own.shapes is not None
    assert other.shapes is not None
    # singly it is cos^2 of 30 degrees, and sin^2
    np.testing.assert_allclose(assurance(own.shapes, other.shapes), [[0.75, 0.25], [0.25, 0.75]])
    np.testing.assert_allclose(match_modes(own, other).mac, 1.0)
    # one shape of the plane is another one: half of the plane is left
    strange = ring(around(24, (3, angle), (4, 0.0)), [1010.0, 1010.0])
    np.testing.assert_allclose(match_modes(own, strange).mac[0], 0.75)


def test_modes_that_change_places_are_found_by_shape_and_others_are_not() -> None:
    own = ring(around(24, (2, 0.0), (3, 0.0), (4, 0.0)), [900.0, 1000.0, 2000.0])
    other = ring(around(24, (3, 0.0), (2, 0.0), (5, 0.0)), [950.0, 1000.0, 2000.0])
    found = match_modes(own, other)
    assert found.places.tolist() == [1, 0, -1]
    assert np.isnan(found.mac[2])


@pytest.mark.parametrize(('other', 'why'), [
    (ModeShapes(np.array([990.0, 2150.0])), 'not both carry shapes'),
    (ring(around(32, (3, 0.0), (2, 0.0)), [990.0, 2150.0]), 'surfaces have other points')])
def test_without_common_shapes_frequencies_match_and_it_is_said(other: ModeShapes,
                                                                why: str) -> None:
    own = ring(around(24, (2, 0.0), (3, 0.0), (4, 0.0)), [1000.0, 2000.0, 2700.0])
    found = match_modes(own, other)
    assert found.places.tolist() == [0, 1, -1]
    assert found.basis.startswith('frequencies')
    assert why in found.basis
    assert np.isnan(found.mac).all()

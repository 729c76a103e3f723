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

"""Interpolation from scattered nodes within a layer of the planar mesh."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.modes.planar_mesh import local_weights
from support.annulus import INNER, OUTER, scattered

QUICK = settings(deadline=None, max_examples=15, derandomize=True)


def anywhere(count: int, seed: int = 1) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(INNER, OUTER, count), rng.uniform(-np.pi, np.pi, count)


def test_weights_converge_as_their_polynomials() -> None:
    """Degree 4 over irregular nodes: values with h^5, theta derivatives with h^4."""
    at_radius, at_angle = anywhere(600)
    off = []
    for spacing in (8e-3, 4e-3, 2e-3):
        radius, angle = scattered(spacing)
        values, slopes = local_weights(radius, angle, at_radius, at_angle)
        field = np.cos(7.0 * angle) * np.exp(radius / 0.03)
        scale = np.exp(at_radius / 0.03)
        off.append([np.std((values @ field) / scale - np.cos(7.0 * at_angle)),
                    np.std((slopes @ field) / scale + 7.0 * np.sin(7.0 * at_angle))])
    rates = np.log2(np.divide(off[:-1], off[1:]))
    # random nodes scatter the rates, and h^5 splines outrun their polynomials while coarse
    assert np.all(rates[-1] == pytest.approx([5.0, 4.0], abs=0.6))
    assert off[-1][0] < 1e-5


@QUICK
@given(seed=st.integers(0, 1000))
def test_weights_hold_polynomials(seed: int) -> None:
    """Products r^i theta^j of total degree four or less, and their derivatives, to rounding."""
    rng = np.random.default_rng(seed)
    radius, angle = rng.uniform(0.1, 0.14, 200), rng.uniform(-0.2, 0.2, 200)
    at_radius, at_angle = rng.uniform(0.11, 0.13, 30), rng.uniform(-0.15, 0.15, 30)
    values, slopes = local_weights(radius, angle, at_radius, at_angle)
    for i, j in ((0, 0), (1, 0), (0, 1), (2, 1), (1, 3), (4, 0), (0, 4)):
        def field(r: FloatArray, t: FloatArray, i: int = i, j: int = j) -> FloatArray:
            return ((r - 0.12) / 0.02)**i * (t / 0.2)**j

        slope = j * ((at_radius - 0.12) / 0.02)**i * (at_angle / 0.2)**max(j - 1, 0) / 0.2
        # weights reach some tens where nodes lie badly, derivatives thirty times that
        assert np.allclose(values @ field(radius, angle), field(at_radius, at_angle), atol=1e-9)
        assert np.allclose(slopes @ field(radius, angle), slope, atol=1e-7)


@pytest.mark.parametrize(('rows', 'power'), [(1, 0), (2, 1), (3, 2)])
def test_thin_walls_have_few_rows(rows: int, power: int) -> None:
    """Across the wall no more is known than the rows tell; along it, all of degree four."""
    rng = np.random.default_rng(rows)
    circles = np.linspace(0.082, 0.0895, rows) if rows > 1 else np.array([0.085])
    angle = (np.arange(60) + rng.uniform(-0.3, 0.3, (rows, 60))) * 2.0 * np.pi / 60
    radius = np.repeat(circles, 60)
    at_radius, at_angle = rng.uniform(circles[0], circles[-1], 200), rng.uniform(-3.0, 3.0, 200)
    values, slopes = local_weights(radius, angle.ravel(), at_radius, at_angle)
    field = np.cos(3.0 * angle.ravel()) * radius**power
    # 20 nodes a wave: h^5 / 5! of 1.5^5 each side of the point, and h^4 of its derivative
    assert np.allclose(values @ field, np.cos(3.0 * at_angle) * at_radius**power, atol=1e-3)
    assert np.allclose(slopes @ field, -3.0 * np.sin(3.0 * at_angle) * at_radius**power, atol=2e-2)


def test_weights_know_no_seam() -> None:
    """Turning nodes and points together changes nothing, also over theta = pi."""
    radius, angle = scattered(6e-3)
    at_radius, at_angle = anywhere(200)
    plain = local_weights(radius, angle, at_radius, at_angle)
    wrapped = np.angle(np.exp(1j * (angle + 2.5)))
    turned = local_weights(radius, wrapped, at_radius, at_angle + 2.5)
    for one, other in zip(plain, turned, strict=True):
        assert abs(one - other).max() < 1e-8 * abs(one).max()


def test_points_off_the_nodes_are_refused() -> None:
    radius, angle = scattered(6e-3)
    with pytest.raises(SquealError, match=r'r = 0\.19 m, theta = 0\.5 rad lies off the nodes'):
        local_weights(radius, angle, np.array([0.12, 0.19]), np.array([0.0, 0.5]))

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
A0, B0, R0, S0, F0 and contact damping against the nonlinear contact force, by differences.

Nothing here uses the linearised contact: points of the disc move through space (K09 eqs 5-10),
their velocity is a derivative of that motion, the friction force follows its direction (12)-(15),
and its virtual work gives the generalised force (30), (31). What K09 assumes is assumed:

- the friction material stays over its point of the pad and follows the disc's surface (4), so the
  part of friction along z (w_theta / r) does no work in (31), and p0 acts along z for good;
- the integral runs over the undeformed patch;
- the friction coefficient answers to vibration *velocity* alone. The disc's displacement also
  changes the sliding speed, by Omega (u + v_theta); the last test says what leaving it out leaves.
"""

import numpy as np
import pytest
from squeal_core.common.arrays import FloatArray
from squeal_core.model import operators
from support.sliding_contact import DISC, ORDER, PADS, Sliding

# Fourth-order differences, with steps that turn the sliding direction by up to 3e-3: what they cut
# off is (3e-3)^4 = 1e-10 at worst, a tenth of it as seen; rounding leaves eps / 1e-4.
TOLERANCE = 1e-10


def assert_same(found: FloatArray, expected: FloatArray) -> None:
    size = np.abs(expected).max()
    assert size > 0.0
    assert np.abs(found - expected).max() < TOLERANCE * size


def predicted_stiffness(case: Sliding) -> FloatArray:
    c, face = case.point.coefficients(), [case.face]
    return (c.contact_stiffness * operators.contact_stiffness(face)
            + c.friction_couple * operators.friction_couple(face)
            + c.follower * operators.follower(face))


def predicted_damping(case: Sliding) -> FloatArray:
    c, face = case.point.coefficients(), [case.face]
    return (c.radial_dissipation * operators.radial_dissipation(face)
            + c.negative_slope * operators.negative_slope(face)
            + case.retardation_time * (
                c.contact_damping * operators.contact_stiffness(face)
                + c.contact_damping_couple * operators.friction_couple(face)))


EVERY_WAY = pytest.mark.parametrize(
    ('side', 'speed'), [(1, 5.0), (1, -5.0), (-1, 5.0), (-1, -5.0), (1, 0.3), (-1, 40.0)])


@EVERY_WAY
def test_velocity_is_that_of_k09(side: int, speed: float) -> None:
    """Eqs (7)-(10) spelled out, so that the derivative in space is known to be the right one."""
    case, rng = Sliding(side, speed), np.random.default_rng(0)
    a, rate = 1e-3 * rng.standard_normal((2, DISC))
    q, shape = case.quadrature, case.shapes[1]
    at = (q.radius, q.angle, q.height)
    (u, v, _), turning = (np.tensordot(s(*at), a, (1, 0)) for s in (shape, shape.dtheta))
    expected = np.tensordot(shape(*at), rate, (1, 0)) + speed * turning
    expected[0] -= speed * v
    expected[1] += speed * (q.radius + u)
    # complex steps are exact to rounding
    assert np.allclose(case.disc_velocity(a, rate), expected, rtol=0, atol=1e-14 * abs(speed))


@EVERY_WAY
def test_contact_stiffness(side: int, speed: float) -> None:
    case = Sliding(side, speed, friction=0.0)
    assert_same(case.stiffness_matrix(), 0.35e11 * operators.contact_stiffness([case.face]))


@EVERY_WAY
def test_friction_couple(side: int, speed: float) -> None:
    """What friction adds to the stiffness where there is no preload to follow the sliding."""
    case = Sliding(side, speed, pressure=0.0)
    added = case.stiffness_matrix() - Sliding(
        side, speed, pressure=0.0, friction=0.0).stiffness_matrix()
    expected = case.point.friction * 0.35e11 * operators.friction_couple([case.face])
    assert_same(added, expected)


@EVERY_WAY
def test_follower(side: int, speed: float) -> None:
    """Where the contact has no stiffness, the turning of the sliding direction is all there is."""
    case = Sliding(side, speed, stiffness=0.0)
    assert_same(case.stiffness_matrix(),
                case.pressure * case.point.friction * operators.follower([case.face]))


@EVERY_WAY
def test_radial_dissipation(side: int, speed: float) -> None:
    case = Sliding(side, speed)
    assert_same(case.damping_matrix(), case.pressure * case.friction / abs(speed)
                * operators.radial_dissipation([case.face]))


@EVERY_WAY
def test_negative_slope(side: int, speed: float) -> None:
    case = Sliding(side, speed, friction=0.0, slope=-0.1)
    assert_same(case.damping_matrix(), -0.1 * 6e5 * operators.negative_slope([case.face]))


@EVERY_WAY
@pytest.mark.parametrize('friction', [0.0, 0.42])
def test_contact_damping(side: int, speed: float, friction: float) -> None:
    """The force of a viscous layer, and the friction that this force carries."""
    case = Sliding(side, speed, friction, pressure=0.0, retardation_time=8e-6)
    viscous = 8e-6 * 0.35e11 * operators.contact_stiffness([case.face])
    couple = 8e-6 * 0.35e11 * operators.friction_couple([case.face])
    assert_same(case.damping_matrix(), viscous + case.point.friction * couple)


@EVERY_WAY
def test_everything_together(side: int, speed: float) -> None:
    """A contact so soft (kc r = p0) that no term hides behind another."""
    case = Sliding(side, speed, slope=-0.1, stiffness=5e6, retardation_time=1e-2)
    assert_same(case.stiffness_matrix(), predicted_stiffness(case))
    assert_same(case.damping_matrix(), predicted_damping(case))


@EVERY_WAY
def test_what_k09_leaves_out(side: int, speed: float) -> None:
    """
    Displacement moves the sliding speed too: p0 mu_v Omega int t^T (v_theta + u) dA.

    Like F0, which K09 leaves out as well, it is small: less than 1e-3 of k_c A0.
    """
    case = Sliding(side, speed, slope=-0.1, stiffness=0.0, displacement_moves_friction=True)
    q, shape = case.quadrature, case.shapes[1].sampled(case.quadrature)
    gained = np.zeros((ORDER, q.weight.size))
    gained[PADS:PADS + DISC] = shape.tangential_dtheta + shape.radial
    left_out = case.pressure * case.slope * speed * (case.face.tangential * q.weight) @ gained.T
    assert_same(case.stiffness_matrix(), predicted_stiffness(case) + left_out)
    assert_same(case.damping_matrix(), predicted_damping(case))
    size = np.abs(left_out).max()
    assert size > 1e3 * TOLERANCE * np.abs(predicted_stiffness(case)).max()  # so it is seen
    stiff = Sliding(side, speed, friction=0.0).stiffness_matrix()
    assert size < 1e-3 * np.abs(stiff).max()

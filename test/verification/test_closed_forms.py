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

"""Roots that can be written down: spinning doublet, flutter of two modes, divergence."""

from hypothesis import assume, given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.optimize import brentq
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import ComplexArray
from squeal_core.stability.eigensolution import complex_modes, eigenvalues
from squeal_core.stability.eigenvectors import mode_vectors

PRESSURE, STIFFNESS = 1e6, 1e10
QUICK = settings(deadline=None, max_examples=40, derandomize=True)


def point(**changes: float) -> OperatingPoint:
    values = {'rotor_speed': 5.0, 'friction': 0.0, 'contact_pressure': PRESSURE,
              'contact_stiffness': STIFFNESS}
    return OperatingPoint(**(values | changes))


def upper(model: BrakeModel, q: OperatingPoint) -> ComplexArray:
    """Roots with Im > 0, by frequency."""
    roots = eigenvalues(model, q)
    return np.array(sorted(roots[roots.imag > 0], key=lambda x: x.imag))


# ---------------------------------------------------------------- a spinning disc

def doublet(w: float, g: float) -> BrakeModel:
    return BrakeModel(angular_frequencies=[w, w], damping_ratios=0.0,
                      gyroscopic=[[0.0, g], [-g, 0.0]])


@QUICK
@given(w=st.floats(100.0, 1e5), g=st.floats(0.0, 40.0), speed=st.floats(0.01, 300.0))
def test_spinning_doublet_splits(w: float, g: float, speed: float) -> None:
    """w^2 - s^2 = -+ g Omega s."""
    split = np.sqrt(w**2 + 0.25 * (g * speed)**2) + 0.5 * g * speed * np.array([-1.0, 1.0])
    # a double root moves by sqrt(eps) w where the split is lost in rounding
    assert np.abs(upper(doublet(w, g), point(rotor_speed=speed)) - 1j * split).max() < 1e-7 * w


def test_disc_carries_the_forward_wave() -> None:
    """cos(n t) a1 + sin(n t) a2 of the higher root runs with the rotation: a2 = -i a1."""
    model, q = doublet(1e4, 6.0), point(rotor_speed=20.0)
    for root, turn in zip(upper(model, q), (1j, -1j), strict=True):
        vector = mode_vectors(model, q, complex(root)).right
        assert vector[1] / vector[0] == pytest.approx(turn, abs=1e-9)


# ---------------------------------------------------------------- two-mode flutter

def two_modes(gap: float, couple: float, contact: float, work: float) -> BrakeModel:
    """Near frequencies, contact stiffness between them, friction that does work around them."""
    return BrakeModel(angular_frequencies=[1e4, 1e4 * (1.0 + gap)], damping_ratios=0.0,
                      contact_stiffness=[[2e-3, contact], [contact, 1e-3]],
                      friction_couple=[[0.0, couple + work], [couple - work, 0.0]])


def discriminant(model: BrakeModel, friction: float) -> float:
    """(K11 - K22)^2 + 4 K12 K21, written out."""
    (w1, w2), a, b = model.angular_frequencies, model.contact_stiffness, model.friction_couple
    gap = w1**2 - w2**2 + STIFFNESS * (a[0, 0] - a[1, 1])
    across = (a[0, 1] + friction * b[0, 1]) * (a[1, 0] + friction * b[1, 0])
    return gap**2 + 4.0 * STIFFNESS**2 * across


@QUICK
@given(gap=st.floats(0.01, 0.05), couple=st.floats(-1e-4, 1e-4), contact=st.floats(-1e-4, 1e-4),
       work=st.floats(1e-3, 2e-3))
def test_two_modes_flutter_above_critical_friction(
        gap: float, couple: float, contact: float, work: float) -> None:
    model = two_modes(gap, couple, contact, work)
    critical = brentq(lambda mu: discriminant(model, mu), 0.0, 10.0, xtol=1e-14)
    assume(critical > 0.1)  # elsewhere the pair has met already, and the steps below are large
    middle = 0.5 * np.trace(model.stiffness(point(friction=critical)))
    below, above = (complex_modes(model, point(friction=critical * (1.0 + side * 1e-3)))
                    for side in (-1, 1))
    assert [m.kind for m in below.modes] == ['stable', 'stable']
    assert sorted(m.kind for m in above.modes) == ['flutter', 'stable']
    spin = np.sqrt(-discriminant(model, critical * 1.001) + 0j)
    expected = np.sqrt(-middle + 0.5j * spin)
    # 3 % away from the merging, roots are conditioned like 30 and rounding is eps * 1e4
    assert above.unstable[0].eigenvalue == pytest.approx(expected, abs=1e-8)
    assert above.unstable[0].frequency_hz == pytest.approx(
        np.sqrt(middle) / 2 / np.pi, rel=1e-3)  # (spin / middle)^2, as above
    near, far = (complex_modes(model, point(friction=critical + step)).unstable[0].growth_rate
                 for step in (1e-6, 4e-6))
    assert far / near == pytest.approx(2.0, rel=1e-4)  # square root law; next term is step / mu


# ---------------------------------------------------------------- no vibration

@QUICK
@given(slope=st.floats(-0.5, -1e-4), mass=st.floats(0.1, 10.0), w=st.floats(50.0, 1e4))
def test_free_sliding_diverges_on_a_falling_friction(slope: float, mass: float, w: float) -> None:
    """Coordinates: slides freely with S0 = 1 / mass, slides freely without, and an oscillator."""
    model = BrakeModel(angular_frequencies=[0.0, w, 0.0], damping_ratios=0.1,
                       negative_slope=np.diag([1e-3 / mass, 0.0, 0.0]))
    found = complex_modes(model, point(friction_slope=slope))
    rate = -slope * PRESSURE * 1e-3 / mass
    assert [m.kind for m in found.modes] == ['divergence', 'rigid', 'stable']
    assert found.modes[0].growth_rate == pytest.approx(rate, rel=1e-12)
    assert found.modes[1].eigenvalue == 0.0
    assert found.modes[2].eigenvalue == pytest.approx(
        w * (-0.1 + 1j * np.sqrt(0.99)), rel=1e-12)
    rising = complex_modes(model, point(friction_slope=-slope))
    assert [m.kind for m in rising.modes] == ['rigid', 'rigid', 'stable']


def test_static_divergence_and_overdamping() -> None:
    """Friction beats stiffness: +-sqrt(-K); damping beats it: two falling real roots."""
    model = BrakeModel(angular_frequencies=[100.0, 200.0], damping_ratios=[0.0, 1.25],
                       friction_couple=np.diag([-5e-6, 0.0]))
    found = complex_modes(model, point(friction=0.5))
    assert [m.kind for m in found.modes] == ['divergence', 'stable']
    real = np.sort(found.eigenvalues.real)
    # lambda^2 = 15000; lambda^2 + 500 lambda + 40000 = 0 -> -100 and -400
    assert np.allclose(real, [-400.0, -np.sqrt(15e3), -100.0, np.sqrt(15e3)], rtol=1e-12)
    assert not found.eigenvalues.imag.any()

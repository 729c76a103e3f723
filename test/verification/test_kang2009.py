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

"""K09's brake against the paper's figures and against another model of the same fit."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.assembly.build import build_model
from squeal_core.brake.dimensions import Brake
from squeal_core.common.arrays import ComplexArray
from squeal_core.model.matrix_names import OPERATORS
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, eigenvalues, Mode

DATA: dict[str, Any] = json.loads(
    (Path(__file__).parents[1] / 'data' / 'k09.json').read_text(encoding='utf-8'))
# mesh choices move frequencies by 0.1 to 0.3 % (the data's note)
MESH = 5e-3
PAD_PAIR = 26


def frequencies(model: BrakeModel) -> np.ndarray:
    return model.angular_frequencies / 2.0 / np.pi


def at(model: BrakeModel, speed: float, friction: float = 0.42, slope: float = 0.0,
       preload: float = 2000.0, stiffness: float = 0.35e11) -> OperatingPoint:
    return OperatingPoint(rotor_speed=speed, friction=friction, friction_slope=slope,
                          contact_pressure=preload / model.contact_area,
                          contact_stiffness=stiffness)


def by_law(model: BrakeModel, speed: float) -> ComplexModes:
    """Modes at a speed with K09's velocity-dependent friction and 2000 N."""
    assert model.caliper is not None
    return complex_modes(model, model.operating_point(
        rotor_speed=speed, pressure=2000.0 / model.caliper.piston_area))


def nearest(modes: ComplexModes, frequency_hz: float) -> Mode:
    return min(modes.modes, key=lambda m: abs(m.frequency_hz - frequency_hz))


# ---------------------------------------------------------------- components

def test_size_of_k09(kang: BrakeModel) -> None:
    assert kang.size == 92
    assert sum(name.startswith('disc') for name in kang.names) == 52
    assert kang.follower is None  # K09 leaves it out of its results
    assert np.all(kang.damping_ratios == 0.002)
    assert kang.contact_radius == pytest.approx(0.1222, abs=5e-5)


def test_disc_frequencies(kang: BrakeModel) -> None:
    disc = slice(20, 50)
    assert frequencies(kang)[disc] == pytest.approx(DATA['disc_frequencies_hz'], rel=MESH)
    diameters = [int(name[6:name.index(',')]) for name in kang.names[disc]]
    assert diameters == DATA['disc_nodal_diameters']


@pytest.mark.parametrize('pad', [1, 2])
def test_pad_frequencies(pad: int, kang: BrakeModel) -> None:
    for i, expected in enumerate(DATA['pad_flexible_frequencies_hz'], start=1):
        found = frequencies(kang)[kang.names.index(f'pad {pad} flexible {i}')]
        assert found == pytest.approx(expected, rel=MESH)


@pytest.mark.parametrize('printed', DATA['printed_hz'], ids=lambda p: f'{p["frequency_hz"]} Hz')
def test_printed_frequencies(printed: dict[str, Any], kang: BrakeModel) -> None:
    found = frequencies(kang)[kang.names.index(printed['mode'])]
    assert found == pytest.approx(printed['frequency_hz'], rel=MESH)


def test_no_doublet_is_cut(kang: BrakeModel) -> None:
    halves = {name for name in kang.names if name.startswith('disc')}
    for name in halves:
        if not name.startswith('disc (0,'):
            other = name[:-1] + ('s' if name.endswith('c') else 'c')
            assert other in halves
            pair = frequencies(kang)[[kang.names.index(name), kang.names.index(other)]]
            assert pair[0] == pair[1]


# ---------------------------------------------------------------- coupled brake

@pytest.mark.parametrize('case', DATA['unstable_modes'],
                         ids=lambda case: f'{case["rotor_speed_rad_s"]:g} rad/s')
def test_unstable_modes(case: dict[str, Any], kang: BrakeModel) -> None:
    found = complex_modes(kang, at(
        kang, case['rotor_speed_rad_s'], case['friction'], case['friction_slope'],
        case['preload_n'], case['contact_stiffness']))
    unstable = {m.index: m for m in found.modes if m.unstable}
    assert sorted(unstable) == [m['index'] for m in case['modes']]
    for expected in case['modes']:
        mode = unstable[expected['index']]
        assert mode.kind == 'flutter'
        assert mode.frequency_hz == pytest.approx(expected['frequency_hz'], rel=MESH)
        # the data's note: 0.5 1/s, the pad pair's up to 2
        tolerance = 2.0 if mode.index == PAD_PAIR else 1.0
        assert mode.growth_rate == pytest.approx(expected['growth_rate'], abs=tolerance)


def test_pairs_of_figures_11_and_12(kang: BrakeModel) -> None:
    """Modes 13/14 and 25/26 are pairs of near frequencies, one growing and one falling."""
    modes = {m.index: m for m in complex_modes(kang, at(kang, 5.0)).modes}
    for one, other in ((13, 14), (25, 26)):
        # damping by sliding, unlike for the two, keeps them from merging altogether: 0.75 %
        assert modes[one].frequency_hz == pytest.approx(modes[other].frequency_hz, rel=0.01)
        assert modes[one].unstable != modes[other].unstable


def test_rigid_modes_come_first(kang: BrakeModel) -> None:
    found = complex_modes(kang, at(kang, 5.0)).modes
    assert [m.kind for m in found[:6]] == ['rigid'] * 6
    assert all(m.frequency_hz > 100.0 for m in found[6:])


def test_torsion_needs_the_negative_slope(kang: BrakeModel) -> None:
    """In-plane torsion does not press on the pads, so friction cannot couple it; section 3.2."""
    torsion = kang.names.index('disc (0,0)s')
    for array in (kang.contact_stiffness, kang.friction_couple):  # normal motion: columns
        assert np.abs(array[:, torsion]).max() < 1e-12 * np.abs(array).max()
    for friction in (0.42, 0.7, 1.0):
        assert not nearest(complex_modes(kang, at(kang, 5.0, friction)), 1364.0).unstable
    squeal = nearest(complex_modes(kang, at(kang, 5.0, slope=-0.1)), 1364.0)
    assert squeal.kind == 'flutter'
    # as one degree of freedom: -2 Re = 2 xi w + p0 mu_v S0; the pads it drags along take a little
    alone = -0.002 * kang.angular_frequencies[torsion] + 0.5 * 0.1 * (
        2000.0 / kang.contact_area) * kang.negative_slope[torsion, torsion]
    assert squeal.growth_rate == pytest.approx(alone, rel=0.05)


# ---------------------------------------------------------------- figure 15

def test_torsion_grows_as_speed_falls(kang: BrakeModel) -> None:
    growth = [nearest(by_law(kang, speed), 1364.0).growth_rate
              for speed in (20.0, 15.0, 10.0, 5.0, 3.0, 1.0, 0.5)]
    assert np.all(np.diff(growth) > 0.0)
    assert growth[0] < 0.0 < growth[2]


@pytest.mark.parametrize('frequency_hz', [1660.0, 2522.0])
def test_doublets_are_stable_below_a_speed(frequency_hz: float, kang: BrakeModel) -> None:
    """The third and the fourth disc doublet."""
    def grows(speed: float) -> bool:
        return any(m.kind == 'flutter' for m in by_law(kang, speed).modes
                   if abs(m.frequency_hz - frequency_hz) < 15.0)

    assert [grows(speed) for speed in (0.5, 1.0, 2.0, 10.0, 20.0)] == [False] * 3 + [True] * 2


def test_divergence_comes_with_the_slope(kang: BrakeModel) -> None:
    """Each pad slides as one along the rotation: rate -p0 mu_v A_c / m_p to begin with."""
    assert not [m for m in complex_modes(kang, at(kang, 5.0)).modes if m.kind == 'divergence']
    found = [m for m in by_law(kang, 5.0).modes if m.kind == 'divergence']
    assert [m.index for m in found] == [1, 2]
    mass = 7820.0 * 0.011 * kang.contact_area
    slope = -0.18 * np.exp(-5.0 * kang.contact_radius)
    # it turns a little as it slides, and drags the disc along
    assert found[0].growth_rate == pytest.approx(-2000.0 * slope / mass, rel=0.1)


# ---------------------------------------------------------------- rebuilt

@pytest.fixture(scope='module')
def rebuilt(brake: Brake, solved_once: None) -> BrakeModel:
    """Return the shipped model made anew; takes seconds."""
    return build_model(brake)


def test_rebuilt_arrays(rebuilt: BrakeModel, kang: BrakeModel) -> None:
    assert rebuilt.names == kang.names
    # eigensolvers stop at 1e-12 or so of w^2; the rigid modes' zeros are exact
    assert rebuilt.angular_frequencies == pytest.approx(kang.angular_frequencies, rel=1e-9)
    for name in OPERATORS:
        old, new = getattr(kang, name), getattr(rebuilt, name)
        if old is None:
            assert new is None
            continue
        # elsewhere vectors may come with other signs; close pad modes mix by 1e-9
        assert np.abs(np.abs(new) - np.abs(old)).max() < 1e-6 * np.abs(old).max(), name
    for name in ('contact_area', 'contact_radius', 'nominal_contact_stiffness', 'caliper',
                 'friction_law', 'damping_ratios'):
        assert np.all(getattr(rebuilt, name) == getattr(kang, name)), name


def in_order(roots: ComplexArray) -> ComplexArray:
    """By frequency; real roots, whose imaginary parts are rounding, by their real parts."""
    return roots[np.lexsort((roots.real, roots.imag.round(3)))]


@pytest.mark.parametrize('speed', [5.0, 20.0])
def test_rebuilt_roots(speed: float, rebuilt: BrakeModel, kang: BrakeModel) -> None:
    old, new = (in_order(eigenvalues(m, at(m, speed))) for m in (kang, rebuilt))
    # signs of vectors included, which the arrays' sizes are blind to
    assert np.abs(new - old).max() < 1e-6 * np.abs(old).max()
    first, second = (complex_modes(m, at(m, speed)).unstable for m in (kang, rebuilt))
    assert [m.index for m in first] == [m.index for m in second]
    for one, other in zip(first, second, strict=True):
        assert other.eigenvalue == pytest.approx(one.eigenvalue, rel=1e-6)

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

"""Labels of what makes a mode grow, by taking it out; who takes part in a mode."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.eigensolution import complex_modes, Mode
from squeal_core.stability.mechanism import (
    Label,
    Mechanism,
    mechanisms,
    participation,
    without_rotation,
)
from support.stability_models import (
    kang_point,
    kang_point_by_law,
    LOAD,
    MERGING,
    POINT,
    SKEW,
    W1,
    W2,
)

# ---------------------------------------------------------------- labels

TERM_OF: dict[Label, str] = {
    'mode coupling': 'friction_couple', 'negative slope': 'negative_slope',
    'gyroscopic': 'gyroscopic', 'radial-dissipation induced': 'radial_dissipation',
    'follower force': 'follower', 'contact damping': 'contact_damping',
    'divergence': 'negative_slope'}


def nearest(model: BrakeModel, point: OperatingPoint, mode: Mode) -> Mode:
    return min(complex_modes(model, point).modes,
               key=lambda m: abs(m.frequency_hz - mode.frequency_hz))


CASES: list[tuple[float, bool, dict[int, Label]]] = [
    (5.0, False, {13: 'mode coupling', 26: 'radial-dissipation induced'}),
    (20.0, False, {10: 'gyroscopic', 13: 'mode coupling', 18: 'mode coupling',
                   26: 'radial-dissipation induced', 40: 'gyroscopic', 46: 'gyroscopic'}),
    (5.0, True, {1: 'divergence', 2: 'divergence', 12: 'negative slope', 13: 'mode coupling',
                 26: 'radial-dissipation induced'})]


@pytest.mark.parametrize(('speed', 'law', 'expected'), CASES)
def test_labels_of_k09(speed: float, law: bool, expected: dict[int, Label], kang: BrakeModel,
                       of_k09: Callable[[float, bool], tuple[Mechanism, ...]]) -> None:
    """And full solves with the label's term out, in which the mode of that frequency is stable."""
    point = kang_point_by_law(kang, speed) if law else kang_point(kang, speed)
    found = of_k09(speed, law)
    assert {m.mode.index: m.label for m in found} == expected
    for m in found:
        term = TERM_OF[m.label]
        cured = nearest(replace(kang, **{term: None}), point, m.mode)
        assert not cured.unstable
        assert m.without[term] <= 1e-2
        around = [other.growth_rate for other in complex_modes(
            replace(kang, **{term: None}), point).modes
            if other.frequency_hz == pytest.approx(m.mode.frequency_hz, rel=0.01)]
        assert min(abs(growth - m.without[term]) for growth in around) < 1e-6
    free = without_rotation(kang)
    for m in found:
        if m.label == 'mode coupling':
            assert nearest(free, point, m.mode).frequency_hz == pytest.approx(
                m.mode.frequency_hz, rel=0.01)
            assert complex_modes(free, point).flutter_in(
                0.99 * m.mode.frequency_hz, 1.01 * m.mode.frequency_hz)


def labels(**arrays: FloatArray | list[float] | float) -> dict[Label, str]:
    model = BrakeModel(**{'angular_frequencies': [W1, W2], 'damping_ratios': 1e-5,  # type: ignore[arg-type]  # noqa: E501
                          **arrays})
    return {m.label: m.reason for m in mechanisms(model, POINT)}


BELOW, ABOVE = (part * MERGING / LOAD * SKEW for part in (0.8, 1.2))
SPIN = 20.0 / 7.0 * SKEW  # G0: 20 1/s at POINT's speed
ONE_SIDED = np.diag([20.0, 0.0]) / (5e5 * 0.5 / 7.0)  # R0: 20 1/s of mode 1
SLIDING = np.diag([1e-3, 1e-3])  # S0: -50 1/s of both


@pytest.mark.parametrize(('arrays', 'label'), [
    ({'friction_couple': ABOVE}, 'mode coupling'),
    ({'friction_couple': BELOW, 'gyroscopic': SPIN}, 'gyroscopic'),
    ({'friction_couple': BELOW, 'radial_dissipation': ONE_SIDED}, 'radial-dissipation induced'),
    ({'friction_couple': BELOW, 'negative_slope': SLIDING}, 'negative slope'),
    ({'negative_slope': SLIDING}, 'negative slope'),
    ({'follower': 1.2 * MERGING / (5e5 * 0.5) * SKEW}, 'follower force'),
    # friction of the dashpot's force along the motion: -25 1/s; that of the spring's only softens
    ({'friction_couple': -1e-3 * np.eye(2), 'contact_retardation_time': 5e-5},
     'contact damping'),
    # either of two is enough: taking one out cures nothing
    ({'friction_couple': ABOVE, 'negative_slope': SLIDING}, 'combined'),
    ({'friction_couple': BELOW, 'gyroscopic': SPIN, 'radial_dissipation': ONE_SIDED},
     'mode coupling'),
], ids=lambda value: value if isinstance(value, str) else '+'.join(value))
def test_labels_by_construction(arrays: dict[str, FloatArray], label: Label) -> None:
    assert label in labels(**arrays)


@pytest.mark.parametrize(('slope', 'label'), [(1.0, 'negative slope'), (0.4, 'contact damping')])
def test_of_two_that_are_needed_the_label_is_the_one_that_adds_more(
        slope: float, label: Label) -> None:
    """25 or 10 1/s by the slope, 12.5 by the dashpots; the structure takes 30 or 17 away."""
    damping = (30.0 if slope == 1.0 else 17.0) / W1
    assert list(labels(damping_ratios=damping, negative_slope=slope * SLIDING,
                       friction_couple=-1e-3 * np.eye(2), contact_retardation_time=5e-5)) == [
        label]


def test_none_of_the_parts_alone_makes_those_flutter() -> None:
    """The couple below merging, rotation and one-sided damping are all stable on their own."""
    for arrays in ({'friction_couple': BELOW}, {'gyroscopic': SPIN},
                   {'radial_dissipation': ONE_SIDED}):
        assert labels(**arrays) == {}


def test_a_stable_mode() -> None:
    model = BrakeModel(angular_frequencies=[W1, W2], damping_ratios=1e-3)
    found = mechanisms(model, POINT, complex_modes(model, POINT).modes)
    assert [m.label for m in found] == ['stable', 'stable']
    assert found[0].reason == 'growth rate -10.00 1/s'
    assert found[0].without == {}


def test_reason_says_what_was_taken_out(
        of_k09: Callable[[float, bool], tuple[Mechanism, ...]]) -> None:
    found = [mechanism for mechanism in of_k09(5.0, True) if mechanism.mode.index == 12]
    assert found[0].reason.startswith('negative slope needed: growth rate +17.')
    assert '-17.1' in found[0].reason
    assert list(found[0].without) == ['gyroscopic', 'friction_couple', 'radial_dissipation',
                                      'negative_slope', 'rotation']


# ---------------------------------------------------------------- participation

def test_participation_is_kinetic_energy() -> None:
    model = BrakeModel(angular_frequencies=[1e3, 1e3, 2e3, 3e3],
                       names=('disc (2,0)c', 'disc (2,0)s', 'disc (0,0)c', 'disc (0,0)s'))
    right = np.array([0.6, 0.8j, 2.0, 1.0 + 1.0j])
    found = participation(model, right)
    assert [(s.name, s.fraction) for s in found] == [
        ('disc (0,0)c', pytest.approx(4.0 / 7.0)), ('disc (0,0)s', pytest.approx(2.0 / 7.0)),
        ('disc (2,0)', pytest.approx(1.0 / 7.0))]
    assert participation(model, right, top=1) == found[:1]
    bare = BrakeModel(angular_frequencies=[1e3, 2e3])
    assert participation(bare, np.array([0j, 1.0]))[0].name == 'component 2'


@pytest.mark.parametrize(('index', 'name', 'least'), [
    (13, 'disc (3,0)', 0.6), (40, 'disc (6,0)', 0.7), (46, 'disc (7,0)', 0.9),
    (26, 'pad 1 roll', 0.2)])
def test_participants_in_k09(index: int, name: str, least: float, kang: BrakeModel) -> None:
    """The third and the sixth doublet; rigid motions of the pads in pair 25/26."""
    point = kang_point(kang, 20.0)
    mode = complex_modes(kang, point).modes[index - 1]
    (found,) = mechanisms(kang, point, [mode], top=92)
    assert found.participation[0].name == name
    assert found.participation[0].fraction > least
    assert sum(s.fraction for s in found.participation) == pytest.approx(1.0, rel=1e-12)
    if index == 26:
        assert all('pad' in s.name for s in found.participation[:4])

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

"""Brakes side by side, against closed forms of two modes that merge."""

from dataclasses import replace
import math

import numpy as np
import pytest
from squeal_core.studies.brake_comparison import compare_brakes, compared_model, mac_of
from support.stability_models import fluttering, POINT, W1, W2

DAMPING = 40.0  # 1/s, of both modes


def boundary(couple: float, stiffening: float = 0.0) -> float:
    """Return the critical friction of `fluttering` in closed form."""
    first, second = W1**2 + POINT.contact_stiffness * stiffening, W2**2
    gap, mean = 0.5 * (second - first), 0.5 * (second + first)
    return math.sqrt(gap**2 + DAMPING**2 * mean) / (POINT.contact_stiffness * couple)


def test_shift_growth_and_critical_friction_of_a_variant() -> None:
    couple, softer = 6e-3, -1e-4  # m^2/kg
    point = replace(POINT, friction=0.5, friction_slope=0.0)
    found = compare_brakes([
        compared_model('a', fluttering(couple), point),
        compared_model('b', fluttering(couple, softer), point)])
    assert found.matches[0].basis == 'frequencies, as not both carry shapes'
    rows = found.rows()
    assert [[mode.identity for mode in row if mode] for row in rows] in (
        [['1/2', '1/2']] * 2, [['1', '1'], ['2', '2']])
    assert math.isnan(mac_of(found, rows[0], 1))
    first, softened = (mode for mode in rows[0] if mode)
    # of one mode, frequency |Im| = sqrt(w^2 - d^2/4)
    w2 = W1**2 + POINT.contact_stiffness * softer
    assert softened.frictionless_hz / first.frictionless_hz == pytest.approx(
        math.sqrt((w2 - DAMPING**2 / 4) / (W1**2 - DAMPING**2 / 4)), rel=1e-9)
    # found between two solves 1e-4 apart
    assert first.critical_friction == pytest.approx(boundary(couple), abs=1e-4)
    assert softened.critical_friction == pytest.approx(boundary(couple, softer), abs=1e-4)
    load = 0.5 * POINT.contact_stiffness * couple
    for mode, low in ((first, W1**2), (softened, w2)):
        roots = np.roots([1.0, 2.0 * DAMPING, low + W2**2 + DAMPING**2,
                          DAMPING * (low + W2**2), low * W2**2 + load**2])
        assert mode.growth_rate == pytest.approx(roots.real.max(), rel=1e-6)
        assert mode.unstable


def test_a_mode_that_is_stable_up_to_the_bound_has_no_critical_friction() -> None:
    found = compared_model('a', fluttering(6e-3), POINT, bounds=(0.0, 0.2))
    assert boundary(6e-3) > 0.2
    assert all(math.isnan(mode.critical_friction) for mode in found.modes)


def test_a_mode_is_named_by_who_leads_at_the_point() -> None:
    """Without friction each of two is one component alone; merged they are both."""
    model = replace(fluttering(6e-3), names=('roll', 'pitch'))
    for friction, names in ((0.0, [{'roll'}, {'pitch'}]), (0.5, [{'roll', 'pitch'}] * 2)):
        found = compared_model('a', model, replace(POINT, friction=friction, friction_slope=0.0))
        assert [{*mode.component.split('+')} for mode in found.modes] == names

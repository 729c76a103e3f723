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

"""Where the next anchor is made: ahead of the way, and amid the brakes that it is to serve."""

from dataclasses import replace
import math

import pytest
from squeal_core import OperatingPoint
from squeal_core.surrogate.neighbours import ahead, alike, amid, Trail
from support.engine_models import between, point


def moved(ratio: float, **others: float) -> OperatingPoint:
    """Return the point with speed and pressure times a ratio."""
    here = point()
    return point(rotor_speed=ratio * here.rotor_speed,
                 contact_pressure=ratio * here.contact_pressure, **others)


# ---------------------------------------------------------------- ahead

def test_the_next_anchor_lies_on_the_way() -> None:
    behind, here = point(), point(rotor_speed=24.0, friction=0.4)
    there = ahead(here, behind)
    assert there.rotor_speed > 24.0
    assert there.friction < 0.4
    assert there.contact_pressure == here.contact_pressure
    # beyond the point, less far than the way already made
    assert between(behind, here, 1.0) == here
    assert there.rotor_speed / 24.0 < 24.0 / 20.0
    assert ahead(here, here) == here


@pytest.mark.parametrize('changes', [
    {'rotor_speed': 90.0}, {'rotor_speed': -20.0, 'friction': -0.42}, {'friction': 0.0},
    {'contact_pressure': 0.0}])
def test_a_jump_is_no_way(changes: dict[str, float]) -> None:
    assert ahead(point(**changes), point()) == point(**changes)
    assert ahead(point(), point(**changes)) == point()


# ---------------------------------------------------------------- foreseen

def test_a_steady_way_is_foreseen() -> None:
    """As a vehicle slows down."""
    trail = Trail()
    for now in range(0, 60, 3):
        here = moved(1.0 - 8e-3 * now, friction_slope=-1e-3 * now)
        (there,), = trail.foreseen([here], now, [20])
    assert there.rotor_speed == pytest.approx(20.0 * (1.0 - 8e-3 * 77))
    assert there.contact_pressure == pytest.approx(point().contact_pressure * (1.0 - 8e-3 * 77))
    assert there.friction_slope == pytest.approx(-1e-3 * 77)
    assert there.friction == here.friction


@pytest.mark.parametrize(('before', 'now', 'factor'), [(1.0, 1.5, 2.0), (1.5, 1.0, 0.5)])
def test_what_is_far_ahead_is_within_a_factor(before: float, now: float, factor: float) -> None:
    trail = Trail()
    trail.foreseen([moved(before)], 0, [400])
    (there,), = trail.foreseen([moved(now)], 1, [400])
    assert there.rotor_speed == factor * moved(now).rotor_speed


def test_a_turn_is_foreseen_from_what_came_after_it() -> None:
    """From a quarter of the horizon: no longer, as brakes turn; no less, as signals are noisy."""
    trail = Trail()
    for now in range(0, 100, 2):
        trail.foreseen([moved(1.0 + 0.01 * now)], now, [20, 40])
    for now in range(100, 112, 2):
        (near,), (there,) = trail.foreseen([moved(1.0 + 0.01 * (200 - now))], now, [20, 40])
    assert near.rotor_speed == pytest.approx(20.0 * (1.0 + 0.01 * (200 - 130)))
    assert there.rotor_speed == pytest.approx(20.0 * (1.0 + 0.01 * (200 - 150)))


def test_nothing_is_foreseen_of_the_unknown() -> None:
    """At the first point, after a jump, and where there are other brakes."""
    trail, here = Trail(), point()
    assert trail.foreseen([here], 5, [10]) == [[here]]
    assert trail.foreseen([moved(1.1)], 5, [5, 10]) == [[moved(1.1)]] * 2
    assert trail.foreseen([moved(3.0)], 6, [10]) == [[moved(3.0)]]
    assert trail.foreseen([moved(0.9), here], 7, [10]) == [[moved(0.9), here]]
    (still, gone), = trail.foreseen([moved(0.9), moved(1.1)], 8, [10])
    assert still == moved(0.9)
    assert gone.rotor_speed == pytest.approx(22.0 * (1.0 + 10 * (1.0 - 1.0 / 1.1)))


# ---------------------------------------------------------------- amid

def test_amid_an_axle_and_the_other() -> None:
    front, rear = moved(1.0), point(contact_pressure=0.8 * point().contact_pressure)
    found = amid(front, [front, rear, replace(rear, friction_slope=-0.04)])
    assert found.contact_pressure == pytest.approx(
        point().contact_pressure * math.exp(math.log(0.8) * 2 / 3))
    assert found.rotor_speed == point().rotor_speed
    assert found.friction_slope == pytest.approx((-0.02 - 0.02 - 0.04) / 3)


def test_brakes_of_other_places_have_no_part_in_it() -> None:
    here = point()
    others = [point(contact_pressure=0.4 * here.contact_pressure), point(rotor_speed=-20.0),
              point(contact_stiffness=1.2 * here.contact_stiffness), point(friction=0.0),
              point(friction=0.6)]
    assert amid(here, [here, *others]) is here
    near = point(friction=0.44)
    assert amid(here, [here, *others, near]).friction == pytest.approx(math.sqrt(0.42 * 0.44))


def test_alike_is_an_axle() -> None:
    assert alike(point(), moved(1.09))
    assert not alike(point(), moved(1.12))
    assert alike(point(), point(friction_slope=0.1))

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

"""Split of the brake force over two axles: force unchanged, risk least, limits kept."""

from dataclasses import replace
import math
import re
from typing import Any, cast

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.monitor.advice import AdviceSettings
from squeal_core.monitor.force_split import SplitAdvice, SplitAdviser
from squeal_core.risk.holding import holding_exceedances, over_members
from squeal_core.risk.squeal_risk import SquealRisk
from squeal_core.stability.eigensolution import SQUEAL_BAND, Tolerances
from squeal_core.stability.quiet_intervals import full_solutions
from support.advised_brakes import falling, falling_risk, FallingEmulator

FRONT = (True, True, False, False)
LIMITS = AdviceSettings(band_hz=SQUEAL_BAND, pressure=(1e5, 2e7), error=0.1, hold=3.0,
                        front_share=(0.4, 0.9), rear_force=0.8)
MODEL = falling()


def brakes(front: float = 8e6, rear: float = 3.5e6) -> list[SlidingConditions]:
    """Return four brakes of unlike friction, at the front more pressed on the right."""
    return [SlidingConditions(rotor_speed=10.0, pressure=pressure, friction=friction)
            for pressure, friction in ((front, 0.3), (1.02 * front, 0.31), (rear, 0.29),
                                       (0.97 * rear, 0.3))]


def adviser(settings: AdviceSettings = LIMITS, *, risk: bool = True, most_friction: float = 1.0,
            model: BrakeModel = MODEL) -> SplitAdviser:
    def look_up(at: SlidingConditions, pressures: FloatArray) -> ComplexArray:
        return full_solutions(model, at, pressures, settings.band_hz, Tolerances.of(model))

    return SplitAdviser(model, settings, Tolerances.of(model), look_up=look_up,
                        risk=falling_risk(model, most_friction=most_friction) if risk else None)


def force(at: list[SlidingConditions], pressures: FloatArray) -> tuple[float, float]:
    """Return the brake force of the front axle and of the rear one, over a constant."""
    friction = np.array([one.friction for one in at])
    factors = np.where(FRONT, 1.0, LIMITS.rear_force)
    return tuple((friction * factors * pressures).reshape(2, 2).sum(axis=1))


def risk_at(at: list[SlidingConditions], pressures: FloatArray) -> float:
    """Return the risk that any brake squeals, held for 3 s, member by member."""
    risk = falling_risk(MODEL)
    quiet = np.ones(risk.ensemble.weights.size)
    for one, pressure in zip(at, pressures.tolist(), strict=True):
        quiet *= 1.0 - holding_exceedances(risk, MODEL, 3.0, np.array([pressure]),
                                           one.rotor_speed, one.friction)[0]
    return float(over_members(risk, 1.0 - quiet))


def pressed(at: list[SlidingConditions]) -> FloatArray:
    return np.array([one.pressure for one in at])


@pytest.mark.parametrize(('front', 'rear'), [(8.4e6, 3.5e6), (3.5e6, 8.4e6)])
def test_least_risk_at_unchanged_force(front: float, rear: float) -> None:
    at = brakes(front, rear)
    found = adviser()(at, FRONT)
    assert found.confirmed
    ahead, behind = force(at, pressed(at))
    new_ahead, new_behind = force(at, np.array(found.pressures))
    assert new_ahead + new_behind == pytest.approx(ahead + behind, rel=1e-9)
    assert new_ahead / (ahead + behind) == pytest.approx(found.front_share, rel=1e-9)
    assert found.present == pytest.approx(ahead / (ahead + behind), rel=1e-9)
    assert found.pressures[1] / found.pressures[0] == pytest.approx(1.02)
    present = risk_at(at, pressed(at))
    assert found.least == pytest.approx(risk_at(at, np.array(found.pressures)), abs=1e-9)
    assert found.gain == pytest.approx(present - found.least, abs=1e-9)
    assert found.gain > 0.3
    scale = [np.where(FRONT, share * (ahead + behind) / ahead,
                      (1.0 - share) * (ahead + behind) / behind)
             for share in np.linspace(*LIMITS.front_share, 101)]
    least = min(risk_at(at, pressed(at) * one) for one in scale)
    assert found.least <= least + 0.02
    assert 0.5 < found.confidence <= 1.0
    assert found.reason.startswith(f'squeal risk {found.least:.2f} at front share')


def test_limits_of_share_and_pressure_are_kept() -> None:
    found = adviser(replace(LIMITS, front_share=(0.66, 0.7)))(brakes(), FRONT)
    assert 0.66 <= found.front_share <= 0.7
    most = 7e6
    found = adviser(replace(LIMITS, pressure=(1e5, most)))(brakes(3.5e6, 8e6), FRONT)
    assert max(found.pressures) <= most
    nothing = adviser(replace(LIMITS, pressure=(1e5, 1.1e5)))(brakes(), FRONT)
    assert_unknown(nothing, 'not known at front shares 0.4 to 0.9, 1.00 to 1.10 bar')


def assert_unknown(found: SplitAdvice, reason: str) -> None:
    assert all(math.isnan(value) for value in (found.front_share, found.least, found.gain,
                                               found.confidence))
    assert not found.confirmed
    assert found.reason.startswith(reason)


def test_a_split_that_is_best_already_stays() -> None:
    found = adviser()(brakes(3e6, 2e6), FRONT)  # nothing squeals
    assert (found.front_share, found.gain) == (found.present, 0.0)
    assert found.pressures == pytest.approx(pressed(brakes(3e6, 2e6)))


def test_growth_counts_where_there_is_no_emulator() -> None:
    at = brakes(8.4e6, 2e6)
    found = adviser(risk=False)(at, FRONT)
    assert found.basis == 'growth rate'
    assert found.reason.startswith('growth rate ')
    assert found.gain > 1.0
    assert math.isnan(found.confidence)
    grown = [full_solutions(MODEL, one, np.array([pressure]), SQUEAL_BAND,
                            Tolerances.of(MODEL))[0].real
             for one, pressure in zip(at, found.pressures, strict=True)]
    assert found.least == pytest.approx(max(grown))


def test_what_is_not_known_gives_no_advice() -> None:
    assert_unknown(adviser(most_friction=0.2)(brakes(), FRONT), 'not known at front shares')
    nothing = SplitAdviser(MODEL, LIMITS, Tolerances.of(MODEL))
    assert_unknown(nothing(brakes(), FRONT), 'neither growth emulator nor table')


def test_what_full_solutions_contradict_is_not_advised() -> None:
    """An emulator that is wrong at low speed, at which the rear wheels slip."""

    class Wrong(FallingEmulator):

        def evaluate(self, inputs: FloatArray) -> Any:
            found = super().evaluate(inputs)
            slow = (inputs[..., 0] < math.log(8.0))[..., None]
            return found._replace(growth_rate=np.where(slow, -20.0, found.growth_rate))

    at = [replace(one, rotor_speed=10.0 if ahead else 6.0)
          for one, ahead in zip(brakes(8e6, 3.5e6), FRONT, strict=True)]
    risk = SquealRisk(cast(Any, Wrong(MODEL)), falling_risk(MODEL).ensemble)
    found = SplitAdviser(MODEL, LIMITS, Tolerances.of(MODEL), risk=risk)(at, FRONT)
    assert_unknown(found, 'front share ')
    assert re.search(r'is not confirmed: at .* bar a full solution has \+.* 1/s, not -20 1/s',
                     found.reason)

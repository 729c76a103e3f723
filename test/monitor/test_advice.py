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

"""Quiet pressures of brakes: against closed forms, and scans by full solutions."""

import math

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.monitor.advice import AdviceSettings, PressureAdvice, PressureAdviser
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND, Tolerances
from squeal_core.stability.quiet_intervals import full_solutions
from support.advised_brakes import (
    falling,
    falling_growth,
    falling_risk,
    PRESSURES,
    ridge,
    ridge_pressures,
)

DECAY = 20.0  # 1/s, of `falling`
AT = SlidingConditions(rotor_speed=10.0, pressure=4e6, friction=0.3)


def settings(error: float = 0.0) -> AdviceSettings:
    return AdviceSettings(band_hz=SQUEAL_BAND, pressure=PRESSURES, error=error, hold=3.0)


class OffTable:
    """Look-up by full solutions, off by a growth rate, with answers up to some pressure."""

    def __init__(self, model: BrakeModel, off: float = 0.0, most: float = 1e9) -> None:
        self.model, self.off, self.most = model, off, most

    def __call__(self, at: SlidingConditions, pressures: FloatArray) -> ComplexArray:
        found = full_solutions(self.model, at, pressures, SQUEAL_BAND, Tolerances.of(self.model))
        return np.where(pressures <= self.most, found + self.off, complex(math.nan, math.nan))


def ends(advice: PressureAdvice) -> list[float]:
    return [end.value for one in advice.intervals for end in one]


@pytest.mark.parametrize('off', [-0.09, 0.0, 0.09])
def test_quiet_pressures_on_both_sides_of_a_ridge(off: float) -> None:
    """A table that is off within its error still advises what is stable by full solutions."""
    model = ridge()
    adviser = PressureAdviser(model, settings(error=0.1), Tolerances.of(model),
                              look_up=OffTable(model, off))
    found = adviser(AT)
    low, high = ridge_pressures(AT.friction)
    assert ends(found) == pytest.approx([PRESSURES[0], low, high, PRESSURES[1]], rel=5e-3)
    assert (found.below, found.above) == (ends(found)[1], ends(found)[2])
    assert found.below < low
    assert found.above > high
    assert found.confirmed
    rounded = math.floor(1e-3 * found.below) / 100.0
    assert found.reason.startswith(f'quiet: 1.00 to {rounded:.2f} bar, ')
    assert math.isnan(found.confidence_below)  # without an emulator


def test_what_a_full_solution_does_not_confirm_is_not_advised() -> None:
    model = ridge()
    adviser = PressureAdviser(model, settings(error=0.1), Tolerances.of(model),
                              look_up=OffTable(model, -5.0))
    found = adviser(AT)
    assert not found.confirmed
    assert math.isnan(found.below)
    assert math.isnan(found.above)
    assert 'is not confirmed, as a full solution has a growth rate of +' in found.reason


def test_where_the_table_ends() -> None:
    model = ridge()
    low, high = ridge_pressures(AT.friction)
    adviser = PressureAdviser(model, settings(), Tolerances.of(model),
                              look_up=OffTable(model, most=1.2 * high))
    found = adviser(AT)
    assert found.intervals[-1].high.kind == 'unknown'
    assert '; not known beyond' in found.reason
    alone = PressureAdviser(model, settings(), Tolerances.of(model),
                            look_up=OffTable(model, most=0.9 * low))(AT)
    assert math.isnan(alone.above)


def test_a_brake_that_is_quiet_already() -> None:
    model = ridge()
    at = SlidingConditions(rotor_speed=-10.0, pressure=4e6, friction=0.1)
    found = PressureAdviser(model, settings(), Tolerances.of(model))(at)
    assert (found.below, found.above, ends(found)) == (4e6, 4e6, [*PRESSURES])
    assert found.confirmed


def test_confidence_is_the_probability_not_to_squeal() -> None:
    """Against a sum over members and nodes: E after 3 s at a constant growth rate."""
    model = falling()
    risk = falling_risk(model, scatter=0.0)
    at = SlidingConditions(rotor_speed=10.0, pressure=8e6, friction=0.3)
    found = PressureAdviser(model, settings(), Tolerances.of(model), risk=risk)(at)
    members = risk.ensemble
    rate = falling_growth(model, 10.0, model.contact_pressure(found.below),
                          0.3 + members.friction_bias, members.ln_damping)
    noise = DECAY * np.exp(members.ln_damping)
    energy = np.exp(6.0 * rate) + noise * np.expm1(6.0 * rate) / rate
    squeals = 0.5 * np.log(energy) > members.audible_build_up
    assert 0.1 < squeals.mean() < 0.9
    assert found.confidence_below == pytest.approx(1.0 - squeals.mean())
    unknown = PressureAdviser(model, settings(), Tolerances.of(model),
                              risk=falling_risk(model, most_friction=0.2))(at)
    assert unknown.below == found.below
    assert math.isnan(unknown.confidence_below)


def growth_at(model: BrakeModel, speed: float, pressure: float, friction: float) -> float:
    point = model.operating_point(rotor_speed=speed, pressure=pressure, friction=friction)
    worst = complex_modes(model, point).worst_in(*SQUEAL_BAND)
    assert worst is not None
    return worst.growth_rate


@pytest.mark.parametrize(('speed', 'friction'), [(40.0, 0.5), (5.0, 0.45)])
def test_shipped_brake_against_a_scan_by_full_solutions(
        speed: float, friction: float) -> None:
    damped = BrakeModel.load('kang2009_damped')
    at = SlidingConditions(rotor_speed=speed, pressure=2e6, friction=friction)
    limits = Tolerances.of(damped)
    found = PressureAdviser(damped, settings(), limits)(at)
    scan = np.geomspace(PRESSURES[0], PRESSURES[1], 15)
    growth = np.array([growth_at(damped, speed, pressure, friction) for pressure in scan.tolist()])
    quiet = growth <= limits.growth
    assert quiet.any()
    assert not quiet.all()
    inside = np.zeros(scan.size, bool)
    for low, high in found.intervals:
        inside |= (scan >= low.value) & (scan <= high.value)
    assert (inside == quiet).all()

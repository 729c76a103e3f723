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

"""Reasons why no brake's squeal risk is known or squeals are missed: settings and emulator."""

from collections.abc import Iterator

import numpy as np
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.risk.emulator_records import EmulatorDomain
from squeal_core.risk.growth_emulator import GrowthEmulator
from squeal_core.risk.squeal_risk import LEAST_KNOWN, SquealRisk

NONE = 'none'  # value of the setting `growth_emulator`
NO_EMULATOR = ('no growth emulator of the model; build one before the drive by '
               '`squeal tabulate MODEL --growth-only`')
TURNED_OFF = ('no growth emulator, as the setting growth_emulator is "none"; leave it empty, or '
              'build one by `squeal tabulate MODEL --growth-only`')
NO_FAMILY = ('no mode of the growth emulator is in the squeal band; change squeal_band_low_hz or '
             'squeal_band_high_hz')
_LEAST_RATE = 5.0  # Hz; a squeal often lasts less than a second, and builds up in a part of it
# input of an emulator, setting that its members spread by, what it is a factor on
_SPREADS = ((3, 'contact_stiffness_deviation', 'contact stiffness'),
            (4, 'damping_deviation', 'damping'),
            (5, 'friction_slope_deviation', 'friction slope'))


def why_unknown(risk: SquealRisk | None, settings: MonitorSettings) -> str:
    """Return the reason and remedy for an unknown squeal risk; empty where it is known."""
    if risk is None:
        return TURNED_OFF if settings.growth_emulator == NONE else NO_EMULATOR
    return '' if risk.families.size else NO_FAMILY


def risk_warnings(risk: SquealRisk | None, settings: MonitorSettings) -> tuple[str, ...]:
    """Return, in words with a remedy, the settings that do not suit the squeal risk."""
    result = [] if risk is None else [*_outside(risk, settings)]
    rate = min(settings.rate, settings.risk_rate)
    if rate < _LEAST_RATE:
        name = 'rate' if settings.rate <= settings.risk_rate else 'risk_rate'
        result.append(f'the squeal risk is evaluated {rate:g} times a second, so short squeals '
                      f'are missed; set {name} to {_LEAST_RATE:g} Hz or more')
    return tuple(result)


def _outside(risk: SquealRisk, settings: MonitorSettings) -> Iterator[str]:
    """Yield a warning if most members are outside the emulator's domain at any point."""
    if not isinstance(risk.emulator, GrowthEmulator):
        return
    domain, members = risk.emulator.domain, risk.ensemble
    inputs = members.inputs(1.0, 1.0, 0.0)  # what is spread does not depend on the point
    outside = {index: (inputs[:, index] < domain.low[index]) | (inputs[:, index]
                                                                > domain.high[index])
               for index, _, _ in _SPREADS}
    weight = float(members.weights @ np.any([*outside.values()], axis=0))
    if 1.0 - weight < LEAST_KNOWN:
        told = ', '.join(f'{name} ({_range(domain, index, what)})'
                         for index, name, what in _SPREADS if outside[index].any())
        remedy = 'calibrate within them' if settings.calibration else 'lower the settings'
        yield (f'{100.0 * weight:.0f} % of the ensemble are outside the range of the growth '
               f'emulator, so the squeal risk is not known: {told}; {remedy}, or build an '
               'emulator of a larger range')


def _range(domain: EmulatorDomain, index: int, what: str) -> str:
    low, high = domain.low[index], domain.high[index]
    if index != 5:  # the others are logarithms
        low, high = np.exp(low), np.exp(high)
    return f'{what} {low:.2g} to {high:.2g} times nominal'

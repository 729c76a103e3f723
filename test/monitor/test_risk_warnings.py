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


"""What is said at the start of settings that do not suit the squeal risk."""

from typing import Any

import pytest
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.risk_warnings import NO_FAMILY, risk_warnings, why_unknown
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_risk import ensemble_risk


def said(kang: BrakeModel, **values: Any) -> tuple[str, ...]:
    settings = read_settings({'brakes': ['fl'], **values})
    return risk_warnings(ensemble_risk(kang, settings), settings)


@pytest.mark.parametrize(('values', 'words'), [
    ({'damping_deviation': 2.0}, 'damping_deviation (damping 0.41 to 2.5 times nominal)'),
    ({'contact_stiffness_deviation': 1.0},
     'contact_stiffness_deviation (contact stiffness 0.74 to 1.3 times nominal)'),
    ({'rate': 2.0}, 'evaluated 2 times a second, so short squeals are missed; set rate to 5 Hz'),
    ({'risk_rate': 1.0}, 'set risk_rate to 5 Hz')])
def test_what_does_not_suit_the_risk_is_named(kang: BrakeModel, values: dict[str, float],
                                              words: str) -> None:
    (text,) = said(kang, **values)
    assert words in text


def test_few_members_outside_are_no_warning(kang: BrakeModel) -> None:
    """The risk is that of the others then; what the shipped settings ask for is suitable."""
    assert said(kang) == said(kang, damping_deviation=0.6, rate=5.0) == ()


def test_a_band_without_a_family_is_told(kang: BrakeModel) -> None:
    settings = read_settings({'brakes': ['fl'], 'squeal_band_low_hz': 20e3,
                              'squeal_band_high_hz': 25e3})
    assert why_unknown(ensemble_risk(kang, settings), settings) == NO_FAMILY

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

"""Details of squeal events, by one full solution each and the fixes of the recording."""

from collections.abc import Iterable
import math

import numpy as np
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.results.squeal_events import SquealEvent
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.likely_mechanism import LikelyMechanism
from squeal_ros.recordings.replay.replay import Replay


def with_details(events: Iterable[SquealEvent], replay: Replay) -> list[SquealEvent]:
    """Return events with the mechanism of their worst modes, and where the vehicle was."""
    mechanisms = LikelyMechanism(replay.model, tolerances=Tolerances.of(
        replay.model, growth=replay.settings.growth_threshold))
    detailed = []
    for event in events:
        latitude, longitude = replay.recording.positions.at(round(event.start_s * 1e9))
        detailed.append(event._replace(
            mechanism=_mechanism(event, replay.model, mechanisms),
            latitude_deg=latitude, longitude_deg=longitude))
    return detailed


def _mechanism(event: SquealEvent, model: BrakeModel, mechanisms: LikelyMechanism) -> str:
    """Return the mechanism of an event's worst mode; empty where it is not known."""
    eigenvalue = complex(event.growth_rate_1_s, 2.0 * math.pi * event.frequency_hz)
    conditions = event.rotor_speed_rad_s, event.pressure_pa, event.friction
    if not np.isfinite((eigenvalue, *conditions)).all():
        return ''
    speed, pressure, friction = conditions
    try:
        return mechanisms.label(model.operating_point(
            rotor_speed=speed, pressure=pressure, friction=friction), eigenvalue)
    except np.linalg.LinAlgError:
        return ''

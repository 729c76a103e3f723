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

"""Advice on the topics of the node."""

import math

from std_msgs.msg import Float64
from support.node_runs import vehicle
from support.vehicle import Vehicle

TOPICS = ('quiet_pressure_below', 'quiet_pressure_above')


def values(car: Vehicle) -> dict[str, str]:
    return {item.key: item.value for item in car.status.values}


def test_quiet_pressures_on_topics_and_in_the_diagnostics() -> None:
    with vehicle(model='kang2009_damped') as car:
        heard: dict[str, float] = {}
        for topic in TOPICS:
            car.node.create_subscription(
                Float64, f'squeal_monitor/{car.brake}/{topic}',
                lambda message, topic=topic: heard.__setitem__(topic, message.data), 10)
        car.rotor_speed, car.pressure = 5.0, 3e6
        car.until(lambda: heard.get(TOPICS[0], 0.0) > 5e5 and TOPICS[1] in heard)
        assert 9e5 < heard[TOPICS[0]] < 9.7e5  # by full solutions 9.59 bar
        assert math.isnan(heard[TOPICS[1]])
        car.until(lambda: 'quiet_pressure_reason' in values(car))
        found = values(car)
        assert float(found['quiet_pressure_below_bar']) == 1e-5 * heard[TOPICS[0]]
        assert found['quiet_pressure_confirmed'] == 'True'
        assert 0.0 <= float(found['quiet_confidence_below']) <= 1.0
        car.pressure = 0.0
        car.until(lambda: math.isnan(heard[TOPICS[0]]))

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

"""Ticks of a replay: none is kept, and topics are those of their full names."""

from collections import Counter
from collections.abc import Iterator
import gc
from pathlib import Path

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_core.model.brake_model import BrakeModel  # noqa: E402
from squeal_core.monitor.settings import read_settings  # noqa: E402
from squeal_core.monitor.vehicle_monitor import Assessment  # noqa: E402
from squeal_ros.recordings.replay.replay_outputs import Outputs  # noqa: E402
from support.bags import braking, replay_of, write_bag  # noqa: E402, I100


def test_memory_is_flat_in_the_length_of_the_bag(tmp_path: Path, kang: BrakeModel) -> None:
    """Nothing of a tick is kept: as many objects are alive after 400 ticks as after 100."""
    settings = read_settings({'brakes': ['fl'], 'rate': 100.0})
    outputs, alive = Outputs(tmp_path / 'out.mcap', settings), []

    def watched() -> Iterator[tuple[Assessment, ...]]:
        bag = write_bag(tmp_path / 'bag', braking(4.1, pressure=0.0))
        for number, tick in enumerate(replay_of(bag, settings, kang)):
            if number in (100, 400):
                gc.collect()
                alive.append(len(gc.get_objects()))
            yield tick

    outputs.write(watched())
    before, after = alive
    assert after - before < 150  # one for every second tick


def test_inputs_of_one_topic_under_two_names(tmp_path: Path, kang: BrakeModel) -> None:
    """`joint_states` of one brake and `/joint_states` of another are the same topic."""
    settings = read_settings({'brakes': ['fl', 'fr'], 'fr.rotor_speed.topic': '/joint_states',
                              'fr.rotor_speed.field': 'velocity[name=fl_wheel_joint]',
                              'fr.pressure.topic': 'fl/brake_pressure',
                              'fr.friction.topic': '/fl/friction'})
    ticks = list(replay_of(write_bag(tmp_path / 'bag', braking()), settings, kang))
    assert Counter(a.state for tick in ticks for a in tick) == {'steady': 2 * len(ticks)}

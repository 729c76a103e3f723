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

"""Which of many brake applications squeal, integrated together and each alone."""

import pytest
from squeal_core import BrakeModel
from squeal_core.model.operators import ContactFace
from squeal_core.simulation import first_events, OperatingHistory

FLOOR, THRESHOLD = 1e-8, 80.0  # m, dB: noise has 71 dB, and squeal is heard within 0.1 s
SCALES = (1.0, 0.8, 1.2)


def test_applications_together_squeal_as_each_alone(
        kang: BrakeModel, faces: tuple[ContactFace, ContactFace]) -> None:
    """A silent one, and two with damping of their own, of which the longer one squeals early."""
    histories = []
    for friction, duration in ((0.1, 0.11), (0.6, 0.3), (0.6, 0.13)):
        point = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=friction,
                                     friction_slope=0.0)
        histories.append(OperatingHistory.ramps([point], [point], duration))
    told: list[int] = []
    together, alone = (first_events(
        kang, faces, histories, (1, 2, 3), damping_scales=SCALES, floor=FLOOR,
        threshold=THRESHOLD, together=count, progress=told.append) for count in (3, 1))
    assert told == [3, 1, 2, 3]
    assert together[0] is None
    assert alone[0] is None
    for one, other in zip(together[1:], alone[1:], strict=True):
        assert one is not None
        assert other is not None
        assert one.end < 0.25
        # levels are means of 50 ms, one each 10 ms
        assert one.start == pytest.approx(other.start, abs=0.011)
        assert one.mode == other.mode

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

"""Two records of one drive: where they are the same."""

import math

from squeal_core.monitor.results.history import AssessmentRecord
from squeal_ros.recordings.replay.agreement import agreement

DRIVE = [AssessmentRecord(time_s=float(time), brake=brake, state='steady',
                          rotor_speed_rad_s=40.0 - time, pressure_pa=1e6, friction=0.4,
                          squeal_risk=0.1 * time, instability_probability=0.9,
                          build_up_nepers=2.0, time_to_squeal_s=0.7, growth_rate_1_s=5.0,
                          damping_ratio=-3e-4, worst_frequency_hz=2500.0,
                          friction_margin=math.nan, unstable_frequencies_hz=(2500.0,),
                          unstable_growth_rates_1_s=(5.0,), reason='live')
         for time in range(6) for brake in ('left', 'right')]


def changed(time: float, **values: object) -> list[AssessmentRecord]:
    """Return the drive with other values of the left brake at one time."""
    return [row._replace(**values) if (row.time_s, row.brake) == (time, 'left')  # type: ignore
            else row._replace(reason='replayed') for row in DRIVE]


def test_the_same_numbers_whatever_the_words() -> None:
    """Take NaN as equal to NaN here; reasons may differ."""
    found = agreement(DRIVE, changed(-1.0))
    assert (found.compared, found.same_inputs, found.equal) == (12, 12, 12)
    assert '12 assessments, 12 of 12 with the same samples' in found.in_words


def test_any_other_number_is_not_equal() -> None:
    """The last bit of a growth rate or a margin counts, not the risk alone."""
    for values in ({'growth_rate_1_s': math.nextafter(5.0, 6.0)}, {'friction_margin': 0.1},
                   {'squeal_risk': 0.30001}, {'unstable_frequencies_hz': (2500.0, 3200.0)}):
        found = agreement(DRIVE, changed(3.0, **values))
        assert (found.same_inputs, found.equal) == (12, 11)


def test_a_neighbouring_sample_is_no_difference() -> None:
    """What saw another sample is counted by itself; its risk counts for the largest difference."""
    found = agreement(DRIVE, changed(3.0, rotor_speed_rad_s=38.0, squeal_risk=0.5))
    assert (found.compared, found.same_inputs, found.equal) == (12, 11, 11)
    assert abs(found.largest_difference - 0.2) < 1e-12
    assert '11 of 11 with the same samples equal bit for bit; 1 saw' in found.in_words


def test_a_lost_tick_is_not_compared() -> None:
    lost = [row for row in DRIVE if row.time_s != 4.0]
    for one, other in ((DRIVE, lost), (lost, DRIVE)):
        found = agreement(one, other)
        assert (found.compared, found.same_inputs, found.equal) == (10, 10, 10)

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

"""The tables of a fleet against sums over its recordings."""

import csv
from pathlib import Path

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_ros.recordings.fleet.fleet_tables import Member, write_tables  # noqa: E402, I100
from squeal_ros.recordings.fleet.fleet_vehicles import VehicleRow  # noqa: E402
from support.drive_results import BRAKING, SyntheticDrive  # noqa: E402, I100


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding='utf-8', newline='') as file:
        return list(csv.DictReader(file))


def test_times_of_brakes_add_up_to_those_of_their_recording(tmp_path: Path) -> None:
    """Risk known in 80 % of the braking time, all that was assessed; two brakings of 8 s."""
    result = SyntheticDrive(30.0, name='a').write(tmp_path / 'recordings' / 'a')
    write_tables(tmp_path, [Member('a', tmp_path / 'a.mcap', VehicleRow('a', 'car'),
                                   result=result)], {}, ['csv'])
    recording, = rows(tmp_path / 'recordings.csv')
    brakes = rows(tmp_path / 'brakes.csv')
    for name, part in (('braking_s', 1.0), ('assessed_s', 0.8), ('risk_known_s', 0.8)):
        times = [float(one[name]) for one in brakes]
        assert times == pytest.approx([part * 2.0 * BRAKING] * 4)
        assert float(recording[name]) == pytest.approx(sum(times))

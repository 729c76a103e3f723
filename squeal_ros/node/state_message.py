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

"""
Assessment -> squeal_msgs/BrakeSqueal: one stamped record of a brake at a tick.

Node and replay write the same CDR bytes: a replay needs no ROS, and message objects of rclpy take
ten times as long to make and publish (142 us against 15). `squeal_msgs/` defines the type.
"""

from collections.abc import Mapping
from functools import lru_cache
import struct

from squeal_core.monitor.assessment import State
from squeal_core.monitor.vehicle_monitor import Assessment

NAME = 'state'  # of the topic of a brake
TYPE = 'squeal_msgs/msg/BrakeSqueal'
CODES: Mapping[State, int] = {
    'steady': 1, 'released': 2, 'not sliding': 3, 'stale': 4, 'invalid': 5,
    'outside validated range': 6}
FIELDS = {  # as rclpy names the types of fields; in the order of the bytes
    'header': 'std_msgs/Header', 'brake': 'string', 'state': 'uint8',
    **dict.fromkeys(('squeal_risk', 'instability_probability', 'build_up', 'frequency_hz',
                     'growth_rate', 'damping_ratio', 'friction_margin'), 'double'),
    'mode_numbers': 'sequence<uint32>',
    **dict.fromkeys(('frequencies_hz', 'growth_rates', 'damping_ratios', 'build_ups'),
                    'sequence<double>')}

_BEGIN = struct.Struct('<4siI')  # encapsulation, and the stamp
_LITTLE_ENDIAN = b'\0\1\0\0'


def serialised_state(assessment: Assessment) -> bytes:
    """Return the CDR bytes of a BrakeSqueal; NaN: not known."""
    modes = assessment.flutter
    count = len(modes)
    return b''.join((
        _BEGIN.pack(_LITTLE_ENDIAN, *divmod(assessment.time, 1_000_000_000)),
        _names_and_state(assessment.brake, CODES[assessment.state]),
        _numbers(count).pack(
            assessment.risk, assessment.instability_probability, assessment.build_up,
            assessment.worst_frequency_hz, assessment.growth_rate, assessment.damping_ratio,
            assessment.friction_margin,
            count, *assessment.mode_numbers,
            count, *assessment.unstable_frequencies_hz,
            count, *assessment.unstable_growth_rates,
            count, *[mode.damping_ratio for mode in modes],
            count, *assessment.build_ups)))


@lru_cache(maxsize=1024)
def _names_and_state(brake: str, code: int) -> bytes:
    """Return the empty frame, a brake and a state, up to the doubles: at a multiple of 8."""
    name = brake.encode()
    frame = struct.pack('<I4x', 1)
    data = frame + struct.pack(f'<I{len(name) + 1}sB', len(name) + 1, name, code)
    return data + bytes(-len(data) % 8)


@lru_cache(maxsize=256)
def _numbers(count: int) -> struct.Struct:
    """Return the layout of the numbers with so many modes: lengths before doubles at 8 n + 4."""
    if count == 0:
        return struct.Struct('<7d5I')
    pad = '4x' if count % 2 else ''
    return struct.Struct(f'<7dI{count}II{pad}{count}d' + 3 * f'I4x{count}d')

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

"""When faults begin and end in tests, and from when on no number may be given."""

from squeal_core.monitor.setting_specs import Signal
from support.faults import braking, Fault, SECOND, Stream

# a fault from 2 s on for 3.9 s, seen at 10 Hz; inputs at 20 Hz are stale after 0.5 s
BEGIN = 1000 * SECOND
START, END = BEGIN + 2 * SECOND, BEGIN + 59 * SECOND // 10
STEP, MAX_AGE, STUCK = SECOND // 10, SECOND // 2, SECOND
MEASURED: tuple[Signal, ...] = ('rotor_speed', 'pressure', 'friction')
BY_TABLE: tuple[Signal, ...] = ('rotor_speed', 'pressure', 'temperature')
BOTH: tuple[Signal, ...] = (*MEASURED, 'temperature')
STREAMS = {signals: braking(8.0, rate=20.0, signals=signals) for signals in (
    MEASURED, BY_TABLE, BOTH)}
# a disc may turn backwards: a speed of the other sign is a number like any other
FAIR = {('negative', 'rotor_speed')}


def bad(fault: Fault, signal: Signal, stream: Stream, tick: int) -> bool:
    """Tell whether a fault has lasted past its limit; `stream` is what it left."""
    if fault.kind == 'harmless' or (fault.name, signal) in FAIR:
        return False
    if fault.kind == 'value':
        # bar given as Pa takes half a second to tell from a release
        slow = (fault.name, signal) == ('wrong unit', 'pressure')
        return tick >= START + (3 * SECOND // 5 if slow else 0)
    if fault.kind == 'stuck':
        return tick > START + STUCK
    fresh = [e for e in stream if e.signal == signal and e.time <= tick
             and tick - MAX_AGE <= e.sample.stamp <= tick]
    return not fresh

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

"""Brake signals written into a bag as the player publishes them, without ROS and at once."""

from collections.abc import Iterator
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray
from squeal_core.vehicle.vehicle_model import BrakeSignals
from squeal_ros.recordings.bags.bag_writer import BagWriter
from squeal_ros.recordings.bags.typestore import BagMessages, JAZZY

ZERO_CELSIUS = 273.15
_BLOCK = 4096  # samples that are serialised at once
_SECOND = 1_000_000_000
_STAMP = 4  # offset of a header's stamp: behind what CDR begins with
_MARK = -math.pi * 1e-300  # stands for values in a message whose bytes are then looked at


def write_signals(signals: BrakeSignals, bag: BagWriter, *, origin: int) -> None:
    """
    Write all signals; a message is stamped, and recorded, at its time after the origin.

    Parameters
    ----------
    signals : BrakeSignals
        Of four wheels.
    bag : BagWriter
        Opened.
    origin : int
        Of the drive's time [ns].

    """
    times = origin + np.round(signals.time * 1e9).astype(np.int64)
    topics = _topics(signals)
    for start in range(0, times.size, _BLOCK):
        block = slice(start, start + _BLOCK)
        columns = [[((topic,), kind, data)
                    for data in _serialised(kind, template, times[block], values[block])]
                   for topic, kind, template, values in topics]
        for time, entries in zip(times[block].tolist(), zip(*columns, strict=True), strict=True):
            bag.write_serialised(time, entries)


def _topics(signals: BrakeSignals) -> list[tuple[str, str, Any, FloatArray]]:
    """Return topic, type, a message full of marks, and the values (n, k) of each."""
    make, mark = BagMessages().type, np.full(len(signals.brakes), _MARK)
    none, stamp = np.zeros(0), make('builtin_interfaces/msg/Time')(sec=0, nanosec=0)
    header = make('std_msgs/msg/Header')(stamp=stamp, frame_id='')
    speed = make(kind := 'sensor_msgs/msg/JointState')(
        header=header, name=[f'{brake}_wheel_joint' for brake in signals.brakes], position=none,
        velocity=mark, effort=none)
    result = [('/joint_states', kind, speed, signals.rotor_speed)]
    pressure = make('sensor_msgs/msg/FluidPressure')(
        header=header, fluid_pressure=_MARK, variance=0.0)
    temperature = make('sensor_msgs/msg/Temperature')(
        header=header, temperature=_MARK, variance=0.0)
    friction = make('std_msgs/msg/Float64')(data=_MARK)
    for i, brake in enumerate(signals.brakes):
        result += [(f'/{brake}/{name}', message.__msgtype__, message, values[:, i:i + 1])
                   for name, message, values in (
                       ('brake_pressure', pressure, signals.pressure),
                       ('friction', friction, signals.friction),
                       ('rotor_temperature', temperature, signals.temperature - ZERO_CELSIUS))]
    return result


def _serialised(kind: str, template: Any, times: NDArray[np.int64],
                values: FloatArray) -> Iterator[bytes]:
    """Yield the CDR bytes of a message at each time [ns] with its values (k,) for the marks."""
    data = bytes(JAZZY.serialize_cdr(template, kind, little_endian=True))
    place = data.index(np.float64(_MARK).astype('<f8').tobytes())
    fields: dict[str, tuple[Any, int]] = {
        'value': ((np.dtype('<f8'), values.shape[1]), place)}
    if hasattr(template, 'header'):
        fields['stamp'] = ((np.dtype('<u4'), 2), _STAMP)
    dtype = np.dtype({'names': [*fields], 'formats': [one for one, _ in fields.values()],
                      'offsets': [place for _, place in fields.values()], 'itemsize': len(data)})
    messages = np.frombuffer(bytearray(data * times.size), dtype)
    messages['value'] = values
    if 'stamp' in fields:
        messages['stamp'] = np.stack(np.divmod(times, _SECOND), axis=1)
    whole = messages.tobytes()
    yield from (whole[at:at + len(data)] for at in range(0, len(whole), len(data)))

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
CDR bytes of the output messages, the same that the type store makes of message objects.

A replay writes 21 messages a tick, and objects of rosbags take it longer than the assessments.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache
import math
import struct
from typing import Any

from squeal_ros.node import messages, state_message
from squeal_ros.recordings.bags.bag_writer import Messages
from squeal_ros.recordings.bags.typestore import BagMessages, JAZZY
from squeal_ros.recordings.replay.tick_record import TickRecord

_TIME = struct.Struct('<iI')
_COUNT = struct.Struct('<I')
_ENDS = [bytes(1 + -(size + 1) % 4) for size in range(4)]  # a zero, and then on to a multiple of 4


def serialised_outputs(node: str, record: TickRecord) -> Iterator[Messages]:
    """
    Yield the messages of one tick.

    Parameters
    ----------
    node : str
        Whose topics they are, in full.
    record : TickRecord
        Of the tick.

    """
    layout, before = _number_layout()
    for row, state in zip(record.rows, record.states, strict=True):
        numbers, listed, whole = _topics(node, row.brake)
        yield *numbers, layout.pack(
            before, row.squeal_risk, before, row.instability_probability,
            before, row.build_up_nepers, before, row.growth_rate_1_s, before, row.damping_ratio,
            before, row.friction_margin)
        frequencies = row.unstable_frequencies_hz if row.is_valid else (math.nan,)
        yield *listed, _before_doubles(len(frequencies)) + struct.pack(
            f'<{len(frequencies)}d', *frequencies)
        yield *whole, state
    for name, statuses in (('/diagnostics', record.statuses),
                           (f'{node}/{messages.EVENTS}', record.events)):
        if statuses:
            yield (name,), messages.DIAGNOSTICS_TYPE, _diagnostics(record.time, statuses)


@lru_cache(maxsize=1024)
def _topics(node: str, brake: str) -> list[tuple[tuple[str, ...], str]]:
    """Return topics and type of the messages of a brake: numbers, frequencies, state."""
    numbers = tuple(f'{node}/{brake}/{name}' for name in messages.NUMBERS)
    types = {**messages.TYPES, state_message.NAME: state_message.TYPE}
    return [(numbers, types[messages.NUMBERS[0]]), *(
        ((f'{node}/{brake}/{name}',), kind) for name, kind in types.items()
        if name not in messages.NUMBERS)]


@lru_cache(maxsize=1)
def _number_layout() -> tuple[struct.Struct, bytes]:
    """Return the layout of the Float64 of `messages.NUMBERS`, and the bytes before a value."""
    kind = messages.TYPES[messages.NUMBERS[0]]
    before = _serialised(JAZZY.types[kind](data=0.0), kind)[:-8]
    return struct.Struct('<' + f'{len(before)}sd' * len(messages.NUMBERS)), before


@lru_cache(maxsize=256)
def _before_doubles(count: int) -> bytes:
    """Return the bytes before so many frequencies."""
    whole = _serialised(messages.frequency_list(BagMessages(), [0.0] * count),
                        messages.TYPES['unstable_frequencies'])
    return whole[:len(whole) - 8 * count]


def _serialised(message: Any, kind: str) -> bytes:
    return bytes(JAZZY.serialize_cdr(message, kind, little_endian=True))


def _diagnostics(time: int, statuses: Sequence[messages.StatusTexts]) -> bytes:
    """Return a DiagnosticArray at a time [ns]: every text begins at a multiple of 4."""
    done = b''.join((b'\0\1\0\0', _TIME.pack(*divmod(time, 1_000_000_000)), _text(''),
                     _COUNT.pack(len(statuses))))
    parts, size = [done], len(done)
    for status in statuses:
        level = bytes((status.level,)).ljust(4 - size % 4, b'\0')  # it stands at any place
        body = _status(status)
        parts += (level, body)
        size += len(level) + len(body)
    return b''.join(parts)


def _status(status: messages.StatusTexts) -> bytes:
    """Return a DiagnosticStatus without its level."""
    values = [value.encode() for value in status.values.values()]
    sizes = [*map(len, values)]
    pairs = [b''] * (4 * len(values))
    pairs[::4] = _texts(tuple(status.values))
    pairs[1::4] = [_COUNT.pack(size + 1) for size in sizes]
    pairs[2::4] = values
    pairs[3::4] = [_ENDS[size & 3] for size in sizes]
    if pairs:
        pairs[-1] = pairs[-1][:1]  # the next level stands right behind the last text
    return b''.join((*_texts((status.name,)), _text(status.message),
                     *_texts((status.hardware_id,)), _COUNT.pack(len(values)), *pairs))


def _text(text: str) -> bytes:
    """Return a text with its length before it and zeros up to a multiple of 4 behind it."""
    data = text.encode()
    size = len(data)
    return _COUNT.pack(size + 1) + data + _ENDS[size & 3]


@lru_cache(maxsize=1024)
def _texts(texts: tuple[str, ...]) -> list[bytes]:
    """Return texts that are the same in every tick."""
    return [*map(_text, texts)]

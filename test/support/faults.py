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
Faults of inputs: each turns a stream of received samples into what a faulty input would give.

A fault is pure: it is handed a stream, the signal it befalls and the time it lasts, and returns
another stream. What concerns the transport (`NODE_FAULTS`) tests of the node bring about.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.vehicle_monitor import Sample

SECOND = 1_000_000_000
NODE_FAULTS = ('type changed', 'publisher replaced')


class Event(NamedTuple):
    """A sample and when it is received [ns]."""

    time: int
    signal: Signal
    sample: Sample


Stream = list[Event]
Change = Callable[[Stream, int, int], Iterable[Event]]


@dataclass(frozen=True)
class Fault:
    """
    One fault.

    Parameters
    ----------
    name : str
    change : callable
        (events of the signal meanwhile, start, end) -> events instead.
    kind : str
        'value': seen in each sample; 'stuck': after a while; 'stamp': while no fresh sample
        comes; 'harmless': the assessments stay.
    cause : str
        What the reason says after the signal's name; a regular expression.

    """

    name: str
    change: Change
    kind: str
    cause: str

    def apply(self, stream: Stream, signal: Signal, start: int, end: int) -> Stream:
        """Return the stream with this fault on a signal from `start` to before `end` [ns]."""
        during = [e for e in stream if e.signal == signal and start <= e.time < end]
        others = [e for e in stream if e.signal != signal or not start <= e.time < end]
        # stable: what is received at the same time stays in the order of the stream
        return sorted([*others, *self.change(during, start, end)], key=lambda e: e.time)


def _value(of: Callable[[Signal, float], float]) -> Change:
    return lambda events, start, end: [
        e._replace(sample=Sample(e.sample.stamp, of(e.signal, e.sample.value))) for e in events]


def _stamp(of: Callable[[int], int]) -> Change:
    return lambda events, start, end: [
        e._replace(sample=Sample(of(e.sample.stamp), e.sample.value)) for e in events]


def _kept(keep: Callable[[int], bool]) -> Change:
    """Keep events by the time since the fault began [ns]."""
    return lambda events, start, end: [e for e in events if keep(e.time - start)]


def _stuck(events: Stream, start: int, end: int) -> Iterable[Event]:
    return _value(lambda signal, value: events[0].sample.value)(events, start, end)


def _shuffled(events: Stream, start: int, end: int) -> Iterable[Event]:
    """Four neighbours at a time come in another order."""
    order = np.random.default_rng(5)
    for first in range(0, len(events), 4):
        block = events[first:first + 4]
        for at, which in enumerate(order.permutation(len(block))):
            yield block[at]._replace(sample=block[which].sample)


_UNITS: dict[Signal, Callable[[float], float]] = {
    'rotor_speed': lambda value: value * 60.0 / math.tau,  # rpm
    'pressure': lambda value: value * 1e-5,  # bar
    'friction': lambda value: value * 100.0,  # %
    'temperature': lambda value: value - 273.15}  # degC

RANGE = r'outside its range [-\d.e+]+ to [-\d.e+]+'
OLD = r'is \d+\.\d\d s old: '

FAULTS = {fault.name: fault for fault in (
    Fault('off', lambda *_: [], 'stamp', OLD),
    Fault('stuck', _stuck, 'stuck', r'is .*has been stuck there for [\d.]+ s'),
    Fault('NaN', _value(lambda *_: math.nan), 'value', f'is nan.*{RANGE}'),
    Fault('inf', _value(lambda *_: math.inf), 'value', f'is inf.*{RANGE}'),
    Fault('huge', _value(lambda *_: 1e300), 'value', rf'is 1e\+300.*{RANGE}'),
    Fault('negative', _value(lambda signal, value: -value), 'value', f'is -.*{RANGE}'),
    Fault('wrong unit', _value(lambda signal, value: _UNITS[signal](value)), 'value',
          f'is .*({RANGE}|looks like (bar given as Pa|rpm given as rad/s))'),
    Fault('slow', _kept(lambda since: since % (2 * SECOND) >= 19 * SECOND // 10), 'stamp', OLD),
    Fault('delayed', _stamp(lambda stamp: stamp - 5 * SECOND), 'stamp', OLD),
    Fault('intermittent', _kept(lambda since: since % (2 * SECOND) >= SECOND), 'stamp', OLD),
    Fault('duplicated', lambda events, *_: [e for e in events for _ in range(2)],
          'harmless', ''),
    Fault('out of order', _shuffled, 'harmless', ''),
    Fault('future stamp', _stamp(lambda stamp: stamp + 5 * SECOND), 'stamp',
          r'is .*stamped ahead of time by [45]\.\d\d s'),
    Fault('zero stamp', _stamp(lambda stamp: 0), 'stamp', r'is .*, without a stamp \(zero\)'),
)}


def clock_back(stream: Stream, start: int, by: int) -> Stream:
    """Return a stream whose clock, stamps and receipts, is set back at `start` [ns]."""
    return [e if e.time < start
            else Event(e.time - by, e.signal, Sample(e.sample.stamp - by, e.sample.value))
            for e in stream]


def braking(seconds: float, *, rate: float, signals: Iterable[Signal],
            start: int = 1000 * SECOND, seed: int = 0) -> Stream:
    """Return what healthy, slightly noisy sensors give of a long braking."""
    noise = np.random.default_rng(seed)
    shapes: dict[Signal, tuple[float, float, float]] = {  # first value, change a second, noise
        'rotor_speed': (30.0, -1.0, 0.02), 'pressure': (2e6, 2e4, 2e3),
        'friction': (0.5, -0.002, 1e-3), 'temperature': (310.0, 2.0, 0.1)}
    events = []
    for step in range(round(seconds * rate)):
        since = step / rate
        stamp = start + round(since * SECOND)
        for signal in signals:
            first, slope, spread = shapes[signal]
            value = first + slope * since + spread * noise.standard_normal()
            events.append(Event(stamp, signal, Sample(stamp, value)))
    return events

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
Publishers of one input that contradict each other.

A message does not say who published it. What does is the number that each publisher gives its
messages, or the connection of a recording: samples are sorted by it into one track a publisher.
"""

from collections import deque
from dataclasses import dataclass, field
import math
from typing import NamedTuple

from squeal_core.monitor.setting_specs import Signal

_SHARE = 0.8  # of max_age: the window of comparison, so that its end is within one max_age
_SLICES, _MOST = 16, 8  # of the window, and tracks
# unit of the signal; by so much sound sensors of one quantity may differ around zero
_DIFFERENCE: dict[Signal, float] = {
    'rotor_speed': 0.5, 'pressure': 2e4, 'friction': 0.05, 'temperature': 10.0}


class _Span(NamedTuple):
    """Range of a publisher's values; `low` above `high` where none was a number."""

    low: float = math.inf
    high: float = -math.inf

    @property
    def is_empty(self) -> bool:
        return self.low > self.high


class _Slice(NamedTuple):
    """A short stretch of time from a stamp on [ns]."""

    start: int
    low: float
    high: float


@dataclass
class _Track:
    connection: int
    number: int
    began: int
    stamp: int = 0
    value: float = math.nan
    slices: deque[_Slice] = field(default_factory=lambda: deque(maxlen=_SLICES + 2))

    def add(self, stamp: int, value: float, window: int) -> None:
        self.stamp, self.value = stamp, value
        low, high = (value, value) if math.isfinite(value) else _Span()
        last = self.slices[-1] if self.slices else None
        if last and 0 <= stamp - last.start < window // _SLICES:
            self.slices[-1] = _Slice(last.start, min(low, last.low), max(high, last.high))
        else:
            self.slices.append(_Slice(stamp, low, high))
        while abs(stamp - self.slices[0].start) > window:
            self.slices.popleft()

    def span(self) -> _Span:
        return _Span(min(one.low for one in self.slices), max(one.high for one in self.slices))


class PublisherGuard:
    """
    Detects publishers of one input whose values contradict each other.

    They do while the ranges of values that they gave over the last 0.8 `max_age` are apart, so
    that a delay, noise, or one that samples less often is no contradiction. Both have to go on
    for as long: one that takes over from another contradicts nobody.

    Parameters
    ----------
    signal : str
    tolerance : float
        Relative difference of sound publishers; 0: not looked for.
    max_age : float
        Of the input [s].

    """

    def __init__(self, signal: Signal, tolerance: float, max_age: float) -> None:
        self._absolute, self._relative = _DIFFERENCE[signal], tolerance
        self._window = round(_SHARE * max_age * 1e9)
        self._tracks: list[_Track] = []

    def check(self, stamp: int, value: float, *, number: int, connection: int) -> str:
        """
        Return the contradiction to a sample, in words; '' for none.

        Parameters
        ----------
        stamp : int
            [ns].
        value : float
            The newest one.
        number : int
            That its publisher gave the message; 0: not known.
        connection : int
            Of a recording, one a publisher; 0: not known.

        """
        if not self._relative or not (number or connection):
            return ''
        track = self._track(stamp, value, number, connection)
        track.add(stamp, value, self._window)
        if len(self._tracks) == 1:
            return ''
        self._tracks = [one for one in self._tracks
                        if abs(stamp - one.stamp) <= self._window]
        if abs(stamp - track.began) < self._window:
            return ''
        own = track.span()
        other = next((span for one in self._tracks if one is not track
                      and abs(stamp - one.began) >= self._window
                      and self._apart(own, span := one.span())), None)
        if other is None:
            return ''
        return (f'contradicted by another publisher of the topic, which says {_words(other)}, '
                'until they agree or one of them is silent')

    def _track(self, stamp: int, value: float, number: int, connection: int) -> _Track:
        """Return the track of the publisher: that whose number is the next lower one."""
        tracks = [one for one in self._tracks if one.connection == connection
                  and (connection or one.number < number)]
        if not tracks:
            self._tracks = [*self._tracks[1 - _MOST:], _Track(connection, number, stamp)]
            return self._tracks[-1]
        last = max(one.number for one in tracks)
        result = min((one for one in tracks if one.number == last),
                     key=lambda one: _distance(one.value, value))
        result.number = number
        return result

    def _apart(self, one: _Span, other: _Span) -> bool:
        if one.is_empty or other.is_empty:
            return one.is_empty != other.is_empty
        largest = max(abs(end) for end in (*one, *other))
        gap = max(one.low - other.high, other.low - one.high)
        return gap > self._absolute + self._relative * largest


def _distance(one: float, other: float) -> float:
    """Return the distance of two values; 0 between two that are no numbers."""
    if math.isfinite(one) and math.isfinite(other):
        return abs(one - other)
    return 0.0 if math.isfinite(one) == math.isfinite(other) else math.inf


def _words(span: _Span) -> str:
    if span.is_empty:
        return 'no number'
    return f'{span.low:.4g}' if span.low == span.high else f'{span.low:.4g} to {span.high:.4g}'

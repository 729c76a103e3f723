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
Findings on a bag and the settings: topics, types, fields and stamps that do not fit.

Each finding names the inputs it is of, what is wrong and the remedy, so that a replay in which
nothing was assessed tells why.
"""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
import difflib
import math
from typing import Any

import numpy as np
from squeal_core.common.errors import SquealError
from squeal_core.monitor.brake_settings import InputSettings
from squeal_core.monitor.inputs.reading import MissingValue, Sample
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.node.field_hints import hint, in_words
from squeal_ros.node.field_paths import FieldPath

_OFTEN = 0.1  # of the stamps
_MOST_IDS = 64  # different ones that are kept; more of them are a counter
_YEAR = 365.25 * 86400.0  # s
_ID_FIELDS = ('id', 'can_id', 'arbitration_id', 'pgn', 'identifier', 'wheel_id', 'sensor_id')


@dataclass(frozen=True)
class Finding:
    """
    Something that keeps inputs from being read, or the squeal risk from being known.

    Parameters
    ----------
    inputs : tuple of str
        As the settings name them: `fl.pressure`; of the squeal risk the brakes: `fl`.
    what, remedy : str

    """

    inputs: tuple[str, ...]
    what: str
    remedy: str

    def __str__(self) -> str:
        return f'{", ".join(self.inputs)}: {self.what}; {self.remedy}'


@dataclass
class _Evidence:
    """Counts of the messages and stamps of one input."""

    source: InputSettings
    topic: str  # in full
    path: FieldPath
    messages: int = 0
    unreadable: int = 0
    of_others: int = 0  # of these, about something else
    reason: str = ''
    hint: str = ''
    limit: float = math.inf  # distance of a stamp from the time of recording that is too far [ns]
    nearest: int | None = None  # smallest such distance [ns]
    furthest: int = 0  # [ns]
    far: int = 0  # stamps beyond the limit

    def take(self, offsets: Sequence[int]) -> None:
        """Record samples, whose stamps are so long after their receipt [ns]."""
        self.messages += len(offsets)
        before = [] if self.nearest is None else [self.nearest]
        self.nearest = min((*before, *offsets), key=abs)
        self.furthest = max((self.furthest, *offsets), key=abs)
        self.far += sum(abs(offset) > self.limit for offset in offsets)


@dataclass
class InputFindings:
    """
    Collects, while a bag is replayed, its misfits with the settings.

    Parameters
    ----------
    settings : MonitorSettings
    namespace : str
        Where the settings' relative topics are in the bag.

    """

    settings: MonitorSettings
    namespace: str = '/'
    _seen: dict[tuple[str, Signal], _Evidence] = field(default_factory=dict)
    _ids: defaultdict[str, Counter[object]] = field(default_factory=lambda: defaultdict(Counter))

    def __post_init__(self) -> None:
        for brake in self.settings.brakes:
            for signal, source in brake.inputs.items():
                self._seen[brake.name, signal] = _Evidence(
                    source, absolute(source.topic, self.namespace), FieldPath.parse(source.field),
                    limit=1e9 * max(source.max_age, self.settings.stamp_tolerance))

    @property
    def wanted(self) -> dict[str, str]:
        """Type of each topic of the settings, in full."""
        return {seen.topic: seen.source.type for seen in self._seen.values()}

    def message(self, topic: str, message: Any) -> None:
        """
        Record a message before its values are read.

        Raises
        ------
        SquealError
            For raw frames of several ids on one topic, which a field path would mix.

        """
        value, raw = _id_of(message)
        ids = self.message_of(topic, value)
        if raw and len(ids) > 1:
            names = [f'{brake}.{signal}' for (brake, signal), seen in self._seen.items()
                     if seen.topic == topic]
            raise SquealError(
                f'{topic}: carries raw frames of several ids ({in_words(map(_as_id, ids))}), and '
                f'{", ".join(names)} would mix them; a field path cannot choose an id, so decode '
                'the bus into one topic a signal first and name that')

    def message_of(self, topic: str, identity: object, count: int = 1) -> Counter[object]:
        """Record messages about something, None where they do not say of what."""
        ids = self._ids[topic]
        if identity is not None and len(ids) <= _MOST_IDS:
            ids[identity] += count
        return ids

    def evidence(self, brake: str, signal: Signal) -> '_Evidence':
        """Return the evidence on an input, to be updated with its samples."""
        return self._seen[brake, signal]

    def value(self, brake: str, signal: Signal, sample: Sample | MissingValue, message: Any,
              received: int) -> None:
        """Record the value that an input got from a message received at a time [ns]."""
        seen = self._seen[brake, signal]
        if isinstance(sample, MissingValue):
            seen.messages += 1
            if seen.unreadable == seen.of_others and not (sample.is_other and seen.unreadable):
                seen.reason, seen.hint = sample.reason, hint(seen.path, message)
            seen.unreadable += 1
            seen.of_others += sample.is_other
            return
        seen.take([sample.stamp - received])

    def listed(self, types: Mapping[str, Counter[str]], undecodable: Mapping[str, tuple[int, str]]
               ) -> list[Finding]:
        """Return the findings, given the types and undecodable messages of each topic."""
        merged: dict[tuple[str, str], list[str]] = {}
        for (brake, signal), seen in self._seen.items():
            for what, remedy in self._of_input(seen, types, undecodable):
                merged.setdefault((what, remedy), []).append(f'{brake}.{signal}')
        return [Finding(tuple(inputs), *said) for said, inputs in merged.items()]

    def _of_input(self, seen: _Evidence, types: Mapping[str, Counter[str]],
                  undecodable: Mapping[str, tuple[int, str]]) -> Iterator[tuple[str, str]]:
        topic, source = seen.topic, seen.source
        if topic not in types:
            yield f'topic {topic} is not in the bag', self._nearest_topics(topic, source, types)
            return
        others = [name for name in types[topic] if not same_type_name(name, source.type)]
        if others and len(others) == len(types[topic]):
            yield (f'topic {topic} is of type {" and ".join(others)} in the bag and '
                   f'{source.type} in the settings', f'set its type: {others[0]}')
            return
        if topic in undecodable:
            count, why = undecodable[topic]
            yield (f'{count} messages on {topic} cannot be decoded ({why})',
                   f'check that they are whole and of type {source.type}')
        elif not seen.messages:
            yield f'topic {topic} has no message in the bag', 'check that it was recorded'
        unreadable = seen.unreadable
        if unreadable < seen.messages:  # another publisher gives the value
            unreadable -= seen.of_others
        if unreadable:
            yield (f'{unreadable} of {seen.messages} messages on {topic} do not hold the '
                   f'value ({seen.reason})', seen.hint or 'correct the field')
        yield from self._clock(seen)
        if not any(kind == 'lookup' for kind, _, _ in seen.path.steps):
            yield from self._mixed(topic)

    def _clock(self, seen: _Evidence) -> Iterator[tuple[str, str]]:
        if seen.nearest is not None and abs(seen.nearest) > seen.limit:
            side = 'behind' if seen.nearest < 0 else 'ahead of'
            yield (f'the stamps on {seen.topic} are {_duration(abs(seen.nearest) * 1e-9)} or more '
                   f'{side} the times of recording, so they are of another clock',
                   'set its stamp: receipt')
        elif seen.far > _OFTEN * seen.messages:
            side = 'behind' if seen.furthest < 0 else 'ahead of'
            yield (f'{seen.far} of {seen.messages} stamps on {seen.topic} are up to '
                   f'{_duration(abs(seen.furthest) * 1e-9)} {side} the times of recording, so '
                   'one of the two clocks was set, or they are of another',
                   'set its stamp: receipt, if the times of recording are right')

    def _mixed(self, topic: str) -> Iterator[tuple[str, str]]:
        ids = self._ids.get(topic, Counter())
        if 1 < len(ids) <= _MOST_IDS and ids.total() >= 2 * len(ids):
            yield (f'messages on {topic} are of several ids ({in_words(map(_as_id, ids))}), and '
                   'a field path takes them all as one signal',
                   'give each signal a topic of its own')

    def _nearest_topics(self, topic: str, source: InputSettings,
                        types: Mapping[str, Counter[str]]) -> str:
        prefix = self._namespace_in(types)
        if prefix and absolute(source.topic, prefix) in types:
            return f'its topics are in the namespace {prefix}: give --namespace {prefix}'
        same = [name for name, kinds in types.items()
                if any(same_type_name(kind, source.type) for kind in kinds)]
        end = topic.rpartition('/')[2]
        near = list(dict.fromkeys((
            *(name for name in same if name.endswith(topic)),
            *difflib.get_close_matches(topic, same, n=3, cutoff=0.6),
            *difflib.get_close_matches(topic, types, n=3, cutoff=0.7),
            *(name for name in same if name.rpartition('/')[2] == end))))
        if near:
            return f'nearest in the bag: {in_words(near)}'
        if same:
            return f'topics of its type in the bag: {in_words(sorted(same))}'
        return f'topics in the bag: {in_words(sorted(types)) or "none"}'

    def _namespace_in(self, types: Mapping[str, Any]) -> str:
        """Return the namespace in which the relative topics are, if it is another."""
        relative = {seen.source.topic for seen in self._seen.values()
                    if not seen.source.topic.startswith('/')}
        votes = Counter(name[:-len(topic) - 1] or '/' for topic in relative for name in types
                        if name.endswith(f'/{topic}'))
        own = self.namespace.rstrip('/') or '/'
        best = max(votes, key=lambda prefix: (votes[prefix], prefix == own), default='')
        return '' if best == own else best


def absolute(topic: str, namespace: str) -> str:
    """Return a topic as a bag names it."""
    return topic if topic.startswith('/') else f'/{namespace.strip("/")}/{topic}'.replace(
        '//', '/')


def full_type_name(name: str) -> str:
    """Return `pkg/msg/Name` of `pkg/Name`, which is short for it."""
    return name if name.count('/') != 1 else name.replace('/', '/msg/')


def same_type_name(one: str, other: str) -> bool:
    """Return whether two names are of one type."""
    return full_type_name(one) == full_type_name(other)


def _id_of(message: Any) -> tuple[object, bool]:
    """Return the identity of messages on one topic, and whether they are raw frames."""
    identity, varies = identity_of(message)
    data = getattr(message, 'data', None)
    return identity, varies and getattr(data, 'dtype', None) == np.uint8


def identity_of(message: Any) -> tuple[object, bool]:
    """Return the identity of messages on one topic, None for none; whether it is a number."""
    for name in _ID_FIELDS:
        value = getattr(message, name, None)
        if isinstance(value, int) and not isinstance(value, bool):
            return value, True
    frame = getattr(getattr(message, 'header', None), 'frame_id', None)
    return (frame or None), False


def _as_id(value: object) -> str:
    return f'0x{value:X}' if isinstance(value, int) else str(value)


def _duration(seconds: float) -> str:
    if seconds >= 0.1 * _YEAR:
        return f'{seconds / _YEAR:.1f} years'
    return f'{seconds:.3g} s' if seconds < 1e4 else f'{math.floor(seconds / 3600.0)} h'

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

"""Fields of messages -> samples. Works on any message object: rclpy's and rosbags' alike."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
import math
import re
from typing import Any

import numpy as np
from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.brake_settings import InputSettings
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_monitor import MissingValue, Sample

_STEP = re.compile(r'\.?([A-Za-z_]\w*)|\[(\d{1,9})\]|\[([A-Za-z_]\w*)=([^\]]+)\]')
_OF_JOINTS = ('position', 'velocity', 'effort')  # of a JointState, as long as its `name`
_NUMBERS = (float, int, np.floating, np.integer, np.bool_)


class FieldError(ValueError):
    """A message without the field that a path names."""


class OtherMessageError(FieldError):
    """A sound message that is about something else: other joints, or no velocities at all."""


@dataclass(frozen=True)
class FieldPath:
    """
    Path of a number in a message: `a.b`, `[2]`, `velocity[name=front_left_wheel_joint]`.

    The last form takes the index at which the list `name` holds the text; both lists have to be
    of one length. So have they, like those of a JointState, for an index by number.
    """

    text: str
    steps: tuple[tuple[str, str | int, str], ...]

    @classmethod
    def parse(cls, text: str) -> 'FieldPath':
        """Raise ConfigurationError, naming the place, for a text that is no path."""
        steps: list[tuple[str, str | int, str]] = []
        at = 0
        while at < len(text):
            match = _STEP.match(text, at)
            if match is None or (match[1] and bool(steps) != text.startswith('.', at)):
                raise ConfigurationError(
                    'field', f'{text!r} is no field path (from {text[at:]!r})',
                    'write a.b, a[2] or a[name=text]')
            if match[1]:
                steps.append(('attribute', match[1], ''))
            elif match[2]:
                steps.append(('index', int(match[2]), ''))
            else:
                steps.append(('lookup', match[3], match[4]))
            at = match.end()
        if not steps or steps[0][0] != 'attribute':
            raise ConfigurationError('field', f'{text!r} is no field path', 'name a field first')
        return cls(text, tuple(steps))

    def read(self, message: Any) -> float:
        """Return the number; raise FieldError with the reason where there is none."""
        owner, value, of = message, message, ''
        for kind, name, key in self.steps:
            try:
                if kind == 'attribute':
                    owner, value = value, getattr(value, str(name))
                elif kind == 'index':
                    if of in _OF_JOINTS:
                        self._check_lengths(value, getattr(owner, 'name', ()), 'name')
                    value = value[name]
                else:
                    value = value[self._index(value, getattr(owner, str(name)), str(name), key)]
            except AttributeError:
                raise FieldError(f'{self.text}: the message has no field {name!r}') from None
            except IndexError:
                raise FieldError(f'{self.text}: the list is too short') from None
            except (KeyError, TypeError):
                raise FieldError(f'{self.text}: is no list') from None
            of = str(name) if kind == 'attribute' else ''
        if isinstance(value, np.ndarray) and value.ndim == 0:
            value = value[()]
        if not isinstance(value, _NUMBERS):
            raise FieldError(f'{self.text}: is no number but {type(value).__name__}')
        try:
            return float(value)
        except OverflowError:
            return math.copysign(math.inf, value)

    def key(self, message: Any) -> tuple[str | int, ...]:
        """Return names and indices that lead to the number in a message that holds it."""
        key: list[str | int] = []
        owner, value = message, message
        for kind, name, text in self.steps:
            if kind == 'attribute':
                owner, value = value, getattr(value, str(name))
                key.append(name)
                continue
            index = int(name) if kind == 'index' else list(getattr(owner, str(name))).index(text)
            value = value[index]
            key.append(index)
        return tuple(key)

    def _index(self, values: Any, names: Any, where: str, key: str) -> int:
        """Return the index of a name; raise FieldError where there is none, or not one."""
        names = list(names)
        if key not in names:
            raise OtherMessageError(f'{self.text}: no {key!r} in the list {where!r}')
        if len(values) == 0:
            raise OtherMessageError(f'{self.text}: the list is empty')
        self._check_lengths(values, names, where)
        if names.count(key) > 1:
            raise FieldError(f'{self.text}: {key!r} is {names.count(key)} times in the list '
                             f'{where!r}')
        return int(names.index(key))

    def _check_lengths(self, values: Any, names: Any, where: str) -> None:
        """Raise FieldError for lists that do not belong together."""
        if isinstance(names, str) or len(names) in (0, len(values)) or len(values) == 0:
            return  # an empty list is not given
        raise FieldError(f'{self.text}: {len(values)} values for {len(names)} in the list '
                         f'{where!r}')


def stamp_of(message: Any, received: int) -> int:
    """
    Return the time a message holds for [ns]: its header's stamp, or that of its receipt.

    A zero stamp is none, and so is one that is no time.
    """
    stamp = getattr(getattr(message, 'header', None), 'stamp', None)
    try:
        return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec) or received  # type: ignore
    except (AttributeError, TypeError, ValueError, OverflowError):
        return received


@dataclass
class _Sight:
    """Latest messages of an input's topic with and without its value [ns of receipt]."""

    last: int | None = None  # message with the value
    without: int | None = None  # first message about something else since

    def see(self, received: int) -> None:
        self.last, self.without = received, None

    def misses(self, received: int, max_age: int) -> bool:
        """Take a message about something else; return whether the value is missed by now."""
        for time in (self.last, self.without):
            if time is not None and received < time:  # the clock was set back
                self.last = self.without = None
        if self.without is None:
            self.without = received
        since = self.without if self.last is None else self.last
        return received - since > max_age


@dataclass(frozen=True)
class Source:
    """One input of one brake, and where messages of its topic hold it."""

    brake: str
    signal: Signal
    settings: InputSettings
    path: FieldPath
    zero: float  # taken off, in the unit of the input
    sight: _Sight = field(default_factory=_Sight, compare=False)

    def sample(self, message: Any, received: int, number: int, connection: int) -> Sample:
        """Return the sample in a message received at a time [ns]."""
        return self.sample_of(self.path.read(message), stamp_of(message, received), received,
                              number, connection)

    def sample_of(self, value: float, stamp: int, received: int, number: int,
                  connection: int) -> Sample:
        """Return the sample of a value as the message has it, and of its header's stamp."""
        return Sample(stamp if self.settings.stamp == 'header' else received,
                      self.in_unit(value), number, connection)

    def in_unit(self, value: Any) -> Any:
        """Return a value as the message has it, or an array of them, in the unit of the input."""
        return self.settings.scale * value + self.settings.offset - self.zero


@dataclass
class Router:
    """
    Assignment of topics to the inputs of brakes that they feed.

    Parameters
    ----------
    types : mapping
        Message type of each topic.

    """

    types: dict[str, str]
    _inputs: Mapping[str, list[Source]]
    problems: Counter[str] = field(default_factory=Counter)

    @classmethod
    def of(cls, settings: MonitorSettings, problems: Counter[str] | None = None) -> 'Router':
        """
        Return a router that counts on in `problems`, if they are given.

        Raises
        ------
        ConfigurationError
            For a bad field path or a topic of two types.

        """
        types: dict[str, str] = {}
        inputs: defaultdict[str, list[Source]] = defaultdict(list)
        for brake in settings.brakes:
            for signal, source in brake.inputs.items():
                where = f'{brake.name}.{signal}'
                if types.setdefault(source.topic, source.type) != source.type:
                    raise ConfigurationError(
                        f'{where}.type', f'{source.topic} is {types[source.topic]} elsewhere and '
                        f'{source.type} here', 'give a topic one type')
                try:
                    path = FieldPath.parse(source.field)
                except ConfigurationError as error:
                    raise ConfigurationError(where, *str(error).split('; ', 1)) from None
                zero = settings.ambient_pressure if source.reference == 'absolute' else 0.0
                inputs[source.topic].append(Source(brake.name, signal, source, path, zero))
        return cls(types, inputs, Counter() if problems is None else problems)

    def sources(self, topic: str) -> list[Source]:
        """Return the inputs that a topic feeds."""
        return self._inputs[topic]

    def samples(self, topic: str, message: Any, received: int, number: int = 0,
                connection: int = 0) -> Iterator[tuple[str, Signal, Sample | MissingValue]]:
        """
        Yield (brake, signal, sample) for a message; unreadable ones count in `problems`.

        A message about something else, as of a second publisher of other joints, is no problem as
        long as others hold the value.

        Parameters
        ----------
        topic : str
            As the settings name it.
        message : object
            As it was received.
        received : int
            Time of receipt [ns].
        number, connection : int
            As of `Sample`.

        """
        for source in self._inputs[topic]:
            result: Sample | MissingValue
            try:
                result = source.sample(message, received, number, connection)
                source.sight.see(received)
            except FieldError as error:
                is_other = isinstance(error, OtherMessageError)
                if not is_other or source.sight.misses(
                        received, round(source.settings.max_age * 1e9)):
                    self.problems[f'{topic}: {error}'] += 1
                result = MissingValue(str(error), is_other)
            yield source.brake, source.signal, result

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

"""Recorded messages -> samples; messages that differ in numbers alone are not decoded."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple

from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_monitor import MissingValue, Sample
from squeal_ros.node.field_paths import Router, Source
from squeal_ros.recordings.bag_reader import Bag, Record
from squeal_ros.recordings.findings import absolute, identity_of, InputFindings
from squeal_ros.recordings.message_layout import Key, LayoutError, MessageLayout

_MOST_LAYOUTS = 4  # of a topic and type; messages of others are decoded
_STAMP: tuple[Key, ...] = (('header', 'stamp', 'sec'), ('header', 'stamp', 'nanosec'))

Samples = list[tuple[str, Signal, Sample | MissingValue]]


class _KnownLayout(NamedTuple):
    layout: MessageLayout
    identity: object
    sources: Sequence[Source]
    stamped: bool

    def samples(self, record: Record) -> list[tuple[str, Signal, Sample]] | None:
        """Return the samples of a message of this layout; None for one of another."""
        numbers = self.layout.read(record.data)
        if numbers is None:
            return None
        stamp, time = record.time, record.time
        if self.stamped:
            *numbers, seconds, nanoseconds = numbers
            stamp = seconds * 1_000_000_000 + nanoseconds or time
        samples = []
        for source, value in zip(self.sources, numbers, strict=True):
            source.sight.see(time)
            samples.append((source.brake, source.signal, source.sample_of(
                float(value), stamp, time, 0, record.publisher)))
        return samples


class SampleReader:
    """
    Reads the samples of a bag's messages, and notes what does not fit the settings.

    Parameters
    ----------
    bag : Bag
    settings : MonitorSettings
    found : InputFindings
    namespace : str
        Where the settings' relative topics are in the bag.

    """

    def __init__(self, bag: Bag, settings: MonitorSettings, found: InputFindings,
                 namespace: str) -> None:
        self._bag, self._found = bag, found
        self._router = Router.of(settings)
        self._topics: defaultdict[str, list[str]] = defaultdict(list)  # of the settings, by bag's
        for topic in self._router.types:
            self._topics[absolute(topic, namespace)].append(topic)
        self._layouts: defaultdict[Any, list[_KnownLayout]] = defaultdict(list)

    def samples(self, record: Record) -> Sequence[tuple[str, Signal, Sample | MissingValue]]:
        """
        Return brake, signal and sample of all that a message holds.

        Raises
        ------
        SquealError
            For raw frames of several ids on one topic.

        """
        topic = record.topic
        layouts = self._layouts[topic, record.store]
        for known in layouts:
            samples = known.samples(record)
            if samples is not None:
                self._found.message_of(topic, known.identity)
                for brake, signal, sample in samples:
                    self._found.evidence(brake, signal).take(sample, record.time)
                return samples
        return self._decoded(record, layouts)

    def _decoded(self, record: Record, layouts: list[_KnownLayout]) -> Samples:
        decoded = self._bag.decode(record)
        if decoded is None:
            return []
        message, length, data = decoded
        self._found.message(record.topic, message)
        samples = [one for name in self._topics[record.topic] for one in self._router.samples(
            name, message, record.time, connection=record.publisher)]
        for brake, signal, sample in samples:
            self._found.value(brake, signal, sample, message, record.time)
        if len(layouts) < _MOST_LAYOUTS and data == record.data and all(
                isinstance(sample, Sample) for _, _, sample in samples):
            layouts += self._layout_of(record, message, length, samples)
        return samples

    def _layout_of(self, record: Record, message: Any, length: int,
                   samples: Samples) -> list[_KnownLayout]:
        """Return the layout of a message, if it gives the samples that decoding gives."""
        identity, varies = identity_of(message)
        if varies:
            return []
        sources = list(chain(*(self._router.sources(name) for name in self._topics[record.topic])))
        stamped = hasattr(getattr(message, 'header', None), 'stamp')
        keys = [source.path.key(message) for source in sources]
        try:
            known = _KnownLayout(
                MessageLayout(record.store, record.type_name, record.data, length,
                              [*keys, *(_STAMP if stamped else ())]), identity, sources, stamped)
            same = repr(known.samples(record)) == repr(samples)  # text, so that NaN equals NaN
        except LayoutError:
            return []
        return [known] * same

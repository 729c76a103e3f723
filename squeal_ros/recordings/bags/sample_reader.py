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
from itertools import chain, compress, repeat
from typing import Any, NamedTuple

import numpy as np
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_monitor import Sample
from squeal_ros.node.field_paths import Router, Source
from squeal_ros.recordings.bags.bag_reader import Bag, Record
from squeal_ros.recordings.bags.message_layout import FieldKey, LayoutError, MessageLayout
from squeal_ros.recordings.findings import absolute, identity_of, InputFindings
from squeal_ros.recordings.recording import Samples

_MOST_LAYOUTS = 4  # of a topic and type; messages of others are decoded
_STAMP: tuple[FieldKey, ...] = (('header', 'stamp', 'sec'), ('header', 'stamp', 'nanosec'))


class _KnownLayout(NamedTuple):
    layout: MessageLayout
    identity: object
    sources: Sequence[Source]
    stamped: bool

    def samples(self, records: Sequence[Record]) -> tuple[Any, list[list[Sample]]]:
        """Return whether messages are of this layout, and their samples of each source."""
        fits, numbers = self.layout.read([record.data for record in records])
        alike = list(compress(records, fits))
        times = [record.time for record in alike]
        stamps = times
        if self.stamped:
            *numbers, seconds, nanoseconds = numbers
            stamps = [second * 1_000_000_000 + nanosecond or time for second, nanosecond, time
                      in zip(seconds.tolist(), nanoseconds.tolist(), times, strict=True)]
        publishers = [record.publisher for record in alike]
        result = []
        with np.errstate(all='ignore'):  # as Python's own numbers are multiplied
            for source, values in zip(self.sources, numbers, strict=True):
                own = stamps if source.settings.stamp == 'header' else times
                result.append([*map(Sample, own, source.in_unit(values.astype(float)).tolist(),
                                    repeat(0), publishers)])
        return fits, result


class SampleReader:
    """
    Reads the samples of a bag's messages, and records misfits with the settings.

    Parameters
    ----------
    bag : Bag
    settings : MonitorSettings
    result : InputFindings
    namespace : str
        Where the settings' relative topics are in the bag.

    """

    def __init__(self, bag: Bag, settings: MonitorSettings, result: InputFindings,
                 namespace: str) -> None:
        self._bag, self._found = bag, result
        self._router = Router.of(settings)
        self._topics: defaultdict[str, list[str]] = defaultdict(list)  # of the settings, by bag's
        for topic in self._router.types:
            self._topics[absolute(topic, namespace)].append(topic)
        self._layouts: defaultdict[Any, list[_KnownLayout]] = defaultdict(list)

    def samples(self, records: Sequence[Record]) -> list[Samples]:
        """
        Return brake, signal and sample of all that each message holds.

        Raises
        ------
        SquealError
            For raw frames of several ids on one topic.

        """
        result: list[Samples] = [[] for _ in records]
        alike: defaultdict[Any, list[int]] = defaultdict(list)
        for place, record in enumerate(records):
            alike[record.topic, record.store, len(record.data)].append(place)
        for (topic, store, _), places in alike.items():
            layouts, tried = self._layouts[topic, store], 0
            while places:
                for known in layouts[tried:]:
                    places = self._read(known, records, places, result)
                tried, done = len(layouts), 0
                while done < len(places) and len(layouts) == tried:
                    place, done = places[done], done + 1
                    result[place] = self._decoded(records[place], layouts)
                places = places[done:]
        return result

    def _read(self, known: _KnownLayout, records: Sequence[Record], places: list[int],
              result: list[Samples]) -> list[int]:
        """Read the messages of a layout at once; return the places of all others."""
        chosen = [records[place] for place in places]
        if not chosen or len(chosen[0].data) != known.layout.length:
            return places
        fits, columns = known.samples(chosen)
        alike = list(compress(places, fits))
        if not alike:
            return places
        times = [records[place].time for place in alike]
        self._found.message_of(chosen[0].topic, known.identity, len(alike))
        for source, samples in zip(known.sources, columns, strict=True):
            brake, signal = source.brake, source.signal
            source.sight.see(times[-1])
            self._found.evidence(brake, signal).take(
                [sample.stamp - time for sample, time in zip(samples, times, strict=True)])
            for place, sample in zip(alike, samples, strict=True):
                result[place].append((brake, signal, sample))
        return list(compress(places, ~fits))

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
            fits, read = known.samples([record])
        except LayoutError:
            return []
        again = [(source.brake, source.signal, *one)
                 for source, one in zip(sources, read, strict=True)]
        return [known] * bool(fits.all() and repr(again) == repr(samples))  # NaN equals NaN there

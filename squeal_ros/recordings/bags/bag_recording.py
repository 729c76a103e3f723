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

"""A recorded bag of ROS as a recording: samples of the inputs that the settings name."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.recordings.bags.bag_reader import Bag, BagError, Record
from squeal_ros.recordings.bags.sample_reader import SampleReader
from squeal_ros.recordings.findings import Finding, InputFindings
from squeal_ros.recordings.positions import FIX_TYPE, Positions
from squeal_ros.recordings.recording import Samples
from squeal_ros.recordings.signals.column_units import contradiction, unit_of_field
from squeal_ros.recordings.signals.signals_file import Signals

_AT_ONCE, _BYTES_AT_ONCE = 1024, 1_000_000  # messages that are read at once, and their size


class BagRecording:
    """
    A recorded bag, read through the inputs of settings.

    Parameters
    ----------
    bag : Bag
    settings : MonitorSettings
    namespace : str
        Where the settings' relative topics are in the bag.
    signals : Signals, optional
        That the settings are changed by.
    about : sequence of str
        What else is to be said of it.

    """

    def __init__(self, bag: Bag, settings: MonitorSettings, namespace: str = '/',
                 signals: Signals | None = None, about: Sequence[str] = ()) -> None:
        self._bag = bag
        self._about = [*about, *(
            note for source in (signals.sources if signals else ()) for note in contradiction(
                source, f'{source.name} {source.field}',
                unit_of_field(source.type, source.field)))]
        self._found = InputFindings(settings, namespace)
        self._reader = SampleReader(bag, settings, self._found, namespace)
        self.positions = Positions()

    @property
    def path(self) -> Path:
        """Return the path of the bag, file or folder."""
        return self._bag.path

    @property
    def kind(self) -> str:
        """Return the kind of bag."""
        return self._bag.kind

    @property
    def notes(self) -> list[str]:
        """Return notes on the bag, as far as it was read."""
        return [*self._about, *self._bag.notes]

    @property
    def findings(self) -> list[Finding]:
        """Return the findings on the bag and the settings, as far as it was read."""
        return self._found.listed(self._bag.types, self._bag.undecodable)

    @property
    def messages(self) -> int:
        """Return the number of messages on the input topics."""
        return sum(self._bag.types[topic].total() for topic in self._found.wanted
                   if topic in self._bag.types)

    def samples(self) -> Iterator[tuple[int, Samples]]:
        """
        Yield the time of recording [ns] and the samples of each message.

        Raises
        ------
        BagError
            For a bag that cannot be read, or has no message on the topics of the settings.

        """
        wanted, types = self._found.wanted, self._bag.types
        if not types:
            raise BagError(self.path, 'holds no topic', 'check that it was recorded')
        if not set(wanted) & set(types):
            raise self._nothing('has none of the topics')
        fixes = {topic: FIX_TYPE for topic in types if topic not in wanted and FIX_TYPE in
                 types[topic]}
        read = False
        records: list[Record] = []
        size = 0
        for record in self._bag.records({**wanted, **fixes}):
            if record.topic in fixes:
                self._take_position(record)
                continue
            read = True
            records.append(record)
            size += len(record.data)
            if len(records) == _AT_ONCE or size > _BYTES_AT_ONCE:
                yield from self._read(records)
                records, size = [], 0
        yield from self._read(records)
        if not read:
            raise self._nothing('has no message to read on the topics')

    def _read(self, records: Sequence[Record]) -> Iterator[tuple[int, Samples]]:
        return zip([record.time for record in records], self._reader.samples(records),
                   strict=True)

    def _take_position(self, record: Record) -> None:
        decoded = self._bag.decode(record)
        if decoded is not None:
            fix = decoded[0]
            self.positions.take(record.time, fix.latitude, fix.longitude, fix.status.status)

    def _nothing(self, what: str) -> BagError:
        findings = self.findings
        more = f'; and {len(findings) - 3} more of this kind' if len(findings) > 3 else ''
        return BagError(
            self.path, f'{what} {", ".join(sorted(self._found.wanted))}',
            '; '.join(f'{result.what}: {result.remedy}' for result in findings[:3]) + more)

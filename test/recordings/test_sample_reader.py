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

"""Samples read by the layout of messages against those of decoded ones, damaged ones too."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_core.monitor.settings import MonitorSettings, read_settings  # noqa: E402
from squeal_ros.recordings.bags import sample_reader  # noqa: E402
from squeal_ros.recordings.bags.bag_reader import Bag, Record  # noqa: E402
from squeal_ros.recordings.bags.message_layout import LayoutError, MessageLayout  # noqa: E402
from squeal_ros.recordings.findings import InputFindings  # noqa: E402
from support.bags import (  # noqa: E402, I100
    braking,
    Entry,
    FLOAT,
    FRAME,
    header,
    JOINTS,
    make,
    PRESSURE,
    START,
    STORE,
    WHEELS,
    write_bag,
)

WHEEL = {'fl.rotor_speed.topic': 'wheels', 'fl.rotor_speed.type': WHEELS,
         'fl.rotor_speed.field': 'speed', 'fl.pressure.topic': 'wheels',
         'fl.pressure.type': WHEELS, 'fl.pressure.field': 'pressures[1]'}


def settings_of(**more: Any) -> MonitorSettings:
    return read_settings({'brakes': ['fl'], **more})


def message(random: np.random.Generator) -> tuple[str, str, Any]:
    """Return topic, type and content of a message; names and lengths now and then differ."""
    frame = random.choice(['', 'base', 'bäse_link'], p=[0.9, 0.05, 0.05])
    head, value = header(int(random.integers(0, 2**60)), str(frame)), float(random.normal())
    names = list(random.permutation(['fl_wheel_joint', 'a', 'steering'])) if (
        random.random() < 0.1) else ['a', 'fl_wheel_joint']
    numbers = random.normal(size=len(names) - (random.random() < 0.05))
    kinds: list[tuple[str, str, Any]] = [
        ('/joint_states', JOINTS, make(JOINTS, header=head, name=names, effort=np.zeros(0),
                                       position=numbers[:random.integers(0, 2)],
                                       velocity=numbers)),
        ('/fl/brake_pressure', PRESSURE, make(PRESSURE, header=head, fluid_pressure=value,
                                              variance=0.0)),
        ('/fl/friction', FLOAT, make(FLOAT, data=random.choice([value, np.nan, np.inf]))),
        ('/wheels', WHEELS, make(WHEELS, header=head, speed=np.float32(value).item(),
                                 pressures=np.array([value, 2.0], dtype=np.float32)))]
    return kinds[random.integers(len(kinds))]


def damaged(data: bytes, random: np.random.Generator) -> bytes:
    """Return the bytes, now and then with one changed, cut off or with a tail."""
    fate = random.random()
    if fate < 0.05:
        at = int(random.integers(len(data)))
        return data[:at] + bytes([random.integers(256)]) + data[at + 1:]
    if fate < 0.08:
        return data[:random.integers(len(data))]
    return data + bytes(random.integers(0, 256, 8, dtype=np.uint8)) if fate < 0.12 else data


def records(seed: int, count: int) -> Iterator[Record]:
    random = np.random.default_rng(seed)
    for number in range(count):
        topic, kind, content = message(random)
        data = bytes(STORE.serialize_cdr(content, kind, little_endian=random.random() < 0.9))
        yield Record(topic, START + number, damaged(data, random), number % 3, kind, STORE)


def read(bag: Bag, settings: MonitorSettings, stream: Iterator[Record]) -> str:
    """Return all that is read, counted and found, in words."""
    found = InputFindings(settings)
    reader = sample_reader.SampleReader(bag, settings, found, '/')
    every = list(stream)
    samples = [one for start in range(0, len(every), 150)
               for one in reader.samples(every[start:start + 150])]
    types = {topic: Counter([kind]) for topic, kind in found.wanted.items()}
    ids = {topic: sorted(count.items()) for topic, count in sorted(found._ids.items())}
    return repr((samples, bag.undecodable, found.listed(types, bag.undecodable), ids))


@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('more', [{}, WHEEL, {'fl.pressure.stamp': 'receipt'}],
                         ids=['standard', 'wheels', 'receipt'])
def test_the_same_samples_as_of_decoded_messages(
        seed: int, more: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    settings, path = settings_of(**more), write_bag(tmp_path / 'bag', braking(0.1))
    fast = read(Bag(path), settings, records(seed, 400))
    monkeypatch.setattr(sample_reader, '_MOST_LAYOUTS', 0)
    decoded: list[Record] = []
    monkeypatch.setattr(Bag, 'decode', lambda bag, record, whole=Bag.decode: decoded.append(
        record) or whole(bag, record))
    assert fast == read(Bag(path), settings, records(seed, 400))
    assert 'cannot be decoded' in fast
    assert len(decoded) == 400


def test_messages_alike_are_decoded_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, settings = write_bag(tmp_path / 'bag', braking(2.0)), settings_of()
    decoded: Counter[str] = Counter()
    monkeypatch.setattr(Bag, 'decode', lambda bag, record, whole=Bag.decode: decoded.update(
        [record.topic]) or whole(bag, record))
    bag = Bag(path)
    found = InputFindings(settings)
    reader = sample_reader.SampleReader(bag, settings, found, '/')
    assert sum(map(len, reader.samples([*bag.records(found.wanted)]))) == 120
    assert set(decoded.values()) == {1}


def test_ids_are_counted_of_every_message(tmp_path: Path) -> None:
    """A message that names an id as a number is decoded: each may be of another."""
    frames = [Entry('/can', FRAME, START + n, make(
        FRAME, header=header(START + n), id=n % 2, dlc=8, data=np.zeros(8, dtype=np.uint8)))
        for n in range(4)]
    bag = Bag(write_bag(tmp_path / 'bag', frames))
    settings = settings_of(**{'fl.pressure.topic': '/can', 'fl.pressure.type': FRAME,
                              'fl.pressure.field': 'data[0]'})
    reader = sample_reader.SampleReader(bag, settings, InputFindings(settings), '/')
    first, second, *_ = bag.records({'/can': FRAME})
    assert [len(samples) for samples in reader.samples([first])] == [1]
    with pytest.raises(ValueError, match='raw frames of several ids'):
        reader.samples([second])


@pytest.mark.parametrize('key', [('data', 0), ('layout',), ('nothing',), ('data', 0, 'x')])
def test_no_layout_where_there_is_no_number(key: tuple[Any, ...]) -> None:
    data = bytes(STORE.serialize_cdr(make(FLOAT, data=1.5), FLOAT))
    with pytest.raises(LayoutError):
        MessageLayout(STORE, FLOAT, data, len(data), [key])
    fits, [numbers] = MessageLayout(STORE, FLOAT, data, len(data), [('data',)]).read([data])
    assert (fits.tolist(), numbers.tolist()) == ([True], [1.5])

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
Places of a message's numbers among its bytes, so that messages alike need no decoding.

The bytes of a CDR message that are no numbers (lengths, texts) tell where its numbers are. As long
as they stay the same, a number is read from its place, of many messages at once; for any other
message the place is looked up anew, from its definition.
"""

from collections.abc import Mapping, Sequence
import struct
from typing import Any

try:
    from rosbags.interfaces import Nodetype
    from rosbags.typesys.store import Typestore
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error
import numpy as np

_HEADER = 4  # bytes of the encapsulation, from whose end alignment counts
_CODES = {'byte': 'B', 'char': 'B', 'int8': 'b', 'uint8': 'B', 'int16': 'h', 'uint16': 'H',
          'int32': 'i', 'uint32': 'I', 'float32': 'f', 'int64': 'q', 'uint64': 'Q',
          'float64': 'd'}
_MOST_PARTS = 1000  # numbers, texts and lists of a message; one with more is decoded

FieldKey = tuple[str | int, ...]  # 'header', 'stamp', 'sec'


class LayoutError(ValueError):
    """A message whose layout is not followed."""


class _Walk:
    """Follows a message through its definition and notes where its numbers are."""

    def __init__(self, store: Typestore, data: bytes) -> None:
        self._store, self._data = store, data
        self._order = '<' if data[1] else '>'
        self.end = _HEADER
        # place, code, entries (0: no list)
        self.numbers: dict[FieldKey, tuple[int, str, int]] = {}
        self.fixed = [(0, _HEADER)]  # ranges of lengths and texts

    def message(self, name: str, key: FieldKey) -> None:
        for field, (kind, detail) in self._store.fielddefs[name][1]:
            if kind == Nodetype.ARRAY:
                self._items(detail[0], detail[1], (*key, field))
            elif kind == Nodetype.SEQUENCE:
                self._items(detail[0], self._length(), (*key, field))
            else:
                self._item((kind, detail), (*key, field))

    def _items(self, item: Any, count: int, key: FieldKey) -> None:
        if item[0] == Nodetype.BASE and item[1][0] != 'string':
            if count:
                self._number(item[1][0], key, count)
            return
        if count > _MOST_PARTS:
            raise LayoutError(f'a list of {count} items')
        for number in range(count):
            self._item(item, (*key, number))

    def _item(self, item: Any, key: FieldKey) -> None:
        kind, detail = item
        if kind == Nodetype.NAME:
            self.message(detail, key)
        elif detail[0] == 'string':
            self._fix(self._length())
        else:
            self._number(detail[0], key, 0)

    def _number(self, name: str, key: FieldKey, count: int) -> None:
        code = _CODES.get(name)
        if code is None or len(self.numbers) >= _MOST_PARTS:
            raise LayoutError(f'{name} at {key}')
        size = struct.calcsize(f'={code}')
        self._align(size)
        self.numbers[key] = self.end, code, count
        self.end += max(count, 1) * size

    def _length(self) -> int:
        self._align(4)
        length: int = struct.unpack_from(f'{self._order}I', self._data, self.end)[0]
        self._fix(4)
        return length

    def _fix(self, size: int) -> None:
        start, stop = self.fixed[-1]
        if stop == self.end:
            self.fixed[-1] = start, stop + size
        else:
            self.fixed.append((self.end, self.end + size))
        self.end += size

    def _align(self, size: int) -> None:
        self.end += -(self.end - _HEADER) % size


class MessageLayout:
    """
    The places of some numbers in messages that differ from a given one in numbers alone.

    Parameters
    ----------
    store : Typestore
        Has the definition of the type.
    type_name : str
    data : bytes
        A message that can be decoded.
    length : int
        Its length as it was decoded; there may be more bytes behind.
    keys : sequence of tuple
        Names and indices that lead to each number.

    Raises
    ------
    LayoutError
        For a message whose layout is not followed, or that does not hold the numbers.

    """

    def __init__(self, store: Typestore, type_name: str, data: bytes, length: int,
                 keys: Sequence[FieldKey]) -> None:
        walk = _Walk(store, data)
        try:
            walk.message(type_name, ())
        except (struct.error, KeyError, RecursionError) as error:
            raise LayoutError(str(error)) from None
        if walk.end != length:
            raise LayoutError(f'{walk.end} bytes of {length}')
        self.length = len(data)
        self._fixed = np.concatenate([np.arange(start, stop) for start, stop in walk.fixed])
        self._expected = np.frombuffer(data, np.uint8)[self._fixed]
        order = '<' if data[1] else '>'
        self._numbers = [(place, np.dtype(f'{order}{code}')) for place, code in (
            _place(walk.numbers, key) for key in keys)]

    def read(self, messages: Sequence[bytes]) -> tuple[Any, list[Any]]:
        """
        Return whether messages are of this layout (n,), and their numbers (k,) of each key.

        Parameters
        ----------
        messages : sequence of bytes
            Each of `length` bytes.

        """
        table = np.frombuffer(b''.join(messages), np.uint8).reshape(len(messages), self.length)
        fits = (table[:, self._fixed] == self._expected).all(axis=1)
        alike = table[fits]
        return fits, [alike[:, place:place + kind.itemsize].copy().view(kind)[:, 0]
                      for place, kind in self._numbers]


def _place(numbers: Mapping[FieldKey, tuple[int, str, int]], key: FieldKey) -> tuple[int, str]:
    """Return place and code of a number: one of its own, or of a list."""
    if key in numbers and not numbers[key][2]:
        return numbers[key][:2]
    *outer, index = key
    place, code, count = numbers.get(tuple(outer), (0, '', 0))
    if not isinstance(index, int) or not 0 <= index < count:
        raise LayoutError(f'no number at {key}')
    return place + index * struct.calcsize(f'={code}'), code

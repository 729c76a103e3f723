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
Damaged files by number: what a mutant is depends on the file and on a random generator alone.

Bytes flipped, cut, spliced; lines lost, doubled, moved; and, with checksums and a hash that are
right again, other values and another structure inside.
"""

import contextlib
import copy
import io
import json
import math
import random
from typing import Any
import zipfile

import numpy as np
from squeal_core.common.npz_archive import content_hash
import yaml

NASTY: list[Any] = [
    None, True, '', 'x', 'nan', '1e9', math.nan, math.inf, -math.inf, 0, -1, 0.0, 1e-300, 1e300,
    10**400, 2**63, [], {}, [[]], [1.0, 'x'], {'value': 1.0}, {'value': {}, 'source': []},
    list(range(5000)), 'long ' * 5000, '../../etc/passwd', '\x00', 'a\nb', {'': None}, [None] * 3]
TOKENS = [b'!!python/object/apply:os.system ["false"]', b'&a ', b'*a', b'<<: ', b'? ',
          b'[' * 3000, b'{' * 900, b'- ', b'\t', b'\x00', b'\xff\xfe', b'\xef\xbb\xbf', b'---\n',
          b'...\n', b': ', b'"', b"'", b'|', b'>', b'%YAML 9.9\n', b'!!binary x', b'2001-01-01',
          b'0x' + b'9' * 9000, b'1_0', b'190:20:30', b'=', b'~', b'yes', b'\xe2\x80\xa8', b'#',
          b'1e999', b'.nan']


def damaged(data: bytes, draw: random.Random, extra: list[bytes]) -> bytes:
    """Return bytes with one to three wounds."""
    for _ in range(draw.choice([1, 1, 2, 3])):
        at, size = draw.randrange(len(data) + 1), draw.choice([1, 1, 2, 8, 64, 1024])
        other = draw.randrange(len(data) + 1)
        way = draw.randrange(7)
        if way == 0:  # bits turned
            data = data[:at] + bytes(b ^ 1 << draw.randrange(8) for b in data[at:at + size]) + (
                data[at + size:])
        elif way == 1:
            data = data[:at]
        elif way == 2:  # a piece lost
            data = data[:at] + data[at + size:]
        elif way == 3:  # a piece of elsewhere put in
            data = data[:at] + data[other:other + size] + data[at:]
        elif way == 4:  # a piece of elsewhere over it
            data = data[:at] + data[other:other + size] + data[at + size:]
        elif way == 5:
            data = data[:at] + draw.choice(extra) + data[at:]
        else:
            data = data[:at] + draw.randbytes(size) + data[at + size:]
    return data


def lines_moved(data: bytes, draw: random.Random) -> bytes:
    lines = data.split(b'\n')
    for _ in range(draw.choice([1, 1, 2, 5])):
        i, j = draw.randrange(len(lines)), draw.randrange(len(lines))
        way = draw.randrange(4)
        if way == 0:
            lines[i], lines[j] = lines[j], lines[i]
        elif way == 1:
            lines.insert(j, lines[i])
        elif way == 2 and len(lines) > 1:
            del lines[i]
        else:
            lines[i % len(lines)] = b' ' * draw.randrange(5) + lines[i % len(lines)].lstrip()
    return b'\n'.join(lines)


def places(tree: Any, found: list[tuple[Any, Any]] | None = None) -> list[tuple[Any, Any]]:
    """Return every (container, key) of a tree."""
    found = [] if found is None else found
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(
        tree, list) else ()
    for key, value in items:
        found.append((tree, key))
        places(value, found)
    return found


def rebuilt(tree: Any, draw: random.Random) -> Any:
    """Change values and structure of a tree of plain data, in place."""
    for _ in range(draw.choice([1, 1, 2, 3])):
        spots = places(tree)
        if not spots:
            return tree
        owner, key = draw.choice(spots)
        value, way = owner[key], draw.randrange(6)
        if way == 0:
            del owner[key]
        elif way == 1 and isinstance(owner, dict):  # under another name
            owner[draw.choice([f'{key}s', str(key).upper(), '', 7, draw.choice(spots)[1]])] = (
                owner.pop(key))
        elif way == 2 and type(value) in (int, float) and not abs(value) > 1e100:
            owner[key] = draw.choice([-value, value * 10.0**draw.randint(-12, 12), value + 1])
        elif way == 3:  # what stands elsewhere, as a copy
            other, name = draw.choice(spots)
            owner[key] = json.loads(json.dumps(other[name], default=str))
        elif way == 4:
            owner[key] = draw.choice(
                [[value], {'value': value}, str(value)[:9999], [value, value]])
        else:
            owner[key] = copy.deepcopy(draw.choice(NASTY))
    return tree


def mutant_of_text(data: bytes, draw: random.Random) -> bytes:
    way = draw.randrange(3)
    if way == 0:
        return damaged(data, draw, TOKENS)
    if way == 1:
        return lines_moved(data, draw)
    tree = rebuilt(yaml.safe_load(data), draw)
    return yaml.safe_dump(tree, allow_unicode=draw.random() < 0.5).encode('utf-8', 'replace')


def mutant_of_archive(data: bytes, draw: random.Random) -> bytes:
    """Damage an archive from outside, or what is in it, so that the checksums are right."""
    way = draw.randrange(4)
    if way == 0:
        return damaged(data, draw, [b'PK\x03\x04', b'PK\x01\x02', b'PK\x05\x06', b'\xff' * 4])
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    if way == 1:
        name = draw.choice(list(members))
        # mostly where the array says what it is
        head = draw.choice([128, 128, len(members[name])])
        members[name] = damaged(members[name][:head], draw, [b'9' * 9, b'\x93NUMPY\x02\x00']) + (
            members[name][head:])
        return zipped(members)
    with np.load(io.BytesIO(data)) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(str(arrays.pop('header')))
    if way == 2:
        header = rebuilt(header, draw)
    else:
        name = draw.choice(list(arrays))
        arrays[name] = changed(arrays[name], draw)
    if isinstance(header, dict) and draw.random() < 0.95:
        # an array of something else than numbers may have no hash
        with contextlib.suppress(TypeError, ValueError):
            header['hash'] = content_hash(header, arrays)
    file = io.BytesIO()
    np.savez_compressed(file, header=np.array(json.dumps(header)), **arrays)
    return file.getvalue()


def zipped(members: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, 'w', zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return file.getvalue()


def changed(array: Any, draw: random.Random) -> Any:
    """Return an array with other values, of another shape or of another type."""
    way = draw.randrange(7)
    if way == 0 and array.size:
        array = array.copy()
        for _ in range(draw.choice([1, 3, 50])):
            array.flat[draw.randrange(array.size)] = draw.choice([0, 1, 7, 255])
        return array
    if way == 1 and array.size and array.dtype.kind == 'f':
        array = array.copy()
        array.flat[draw.randrange(array.size)] = draw.choice(
            [math.nan, math.inf, 1e300, -1e300, 5e-324, -1.0])
        return array
    if way == 2:
        return (array * 10.0**draw.randint(-30, 30)).astype(array.dtype)
    if way == 3:
        return draw.choice([array[:-1], array[:0], array.ravel(), array[None], array.T[::-1]])
    if way == 4:
        return np.concatenate([array, array])
    if way == 5:
        return array.astype(draw.choice(['f4', 'f8', 'i8', '>f8', 'c16', 'U8', 'S8', 'O']))
    side = draw.choice([0, 1, 100, 2000 if array.ndim < 3 else 200])
    return np.zeros((side,) * max(array.ndim, 1), array.dtype)

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
NumPy archives (.npz) of plain arrays and a JSON header, for all files of our own.

Header and array layouts are compared with what is wanted, and with a bound on the whole, before a
byte of the data is read.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import hashlib
import json
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from squeal_core.common.errors import LocatedError, short_repr, SquealError
from squeal_core.common.npz_reader import ArrayLayout, MAX_BYTES, npz_reader, NpzReader
from squeal_core.common.output import output_file

MAX_HEADER = 16_000_000  # bytes of the header in memory, four a character
MAX_DEPTH = 50  # of mappings and lists in it
_CHUNK = 1 << 20  # values that are hashed at a time

Header: TypeAlias = dict[str, Any]
Arrays: TypeAlias = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class ArchiveKind:
    """
    One kind of our own files: its marks, and the error for bad ones.

    Parameters
    ----------
    noun : str
        Such as 'model file'.
    contents : str
        What is in it, such as 'model'.
    format : str
        What the header states under 'format'.
    schemas : range
        The versions that are read.
    error : type of LocatedError
    again : str
        Remedy for a damaged file.
    renew : str
        Remedy for a file of another version.
    missing : callable
        Of the path: gives the remedy for a file that is not there.
    most_bytes : int
        Of one array.
    hashed : bool
        Whether the header holds a hash over all contents.
    earlier : tuple of str
        What headers of earlier versions state under 'format'.

    """

    noun: str
    contents: str
    format: str  # noqa: A003
    schemas: range
    error: type[LocatedError]
    again: str
    renew: str
    missing: Callable[[Path], str]
    most_bytes: int = MAX_BYTES
    hashed: bool = True
    earlier: tuple[str, ...] = ()


Wanted: TypeAlias = Callable[[Header], Mapping[str, str]]
"""Of a header: the arrays to read and their types, as '<f8', or 'U' for texts of any length; a
name that ends in '?' may be missing."""
CheckShapes: TypeAlias = Callable[[Header, Mapping[str, tuple[int, ...]]], None]
"""Raises a SquealError for shapes that do not fit the header or each other."""


def write_archive(path: str | Path, kind: ArchiveKind, header: Header, arrays: Mapping[str, Any],
                  *, overwrite: bool = True) -> None:
    """
    Write header and arrays; the file appears whole or not at all.

    Raises
    ------
    LocatedError
        Of the kind, for contents that could not be read again.
    OutputError
        Where the file cannot be written.

    """
    header = {'format': kind.format, **header}
    try:
        if kind.hashed:
            header['hash'] = content_hash(header, arrays)
        text = np.array(json.dumps(header))
    except (TypeError, ValueError, RecursionError) as error:
        raise kind.error(path, f'cannot hold this header ({error})',
                         'give texts, numbers, lists and mappings') from None
    most = max((np.asarray(array).nbytes for array in arrays.values()), default=0)
    total = text.nbytes + sum(np.asarray(array).nbytes for array in arrays.values())
    if most > kind.most_bytes or total > MAX_BYTES or text.nbytes > MAX_HEADER:
        raise kind.error(path, f'would hold {total / 1e6:.0f} MB, with a header of '
                         f'{text.nbytes / 1e6:.0f} MB; {MAX_BYTES / 1e6:.0f} and '
                         f'{MAX_HEADER / 1e6:.0f} MB are read', 'write less into one file')
    if _depth(header) > MAX_DEPTH:
        raise kind.error(path, f'cannot hold a header nested more than {MAX_DEPTH} deep',
                         'give flatter mappings')
    with output_file(path, overwrite=overwrite) as partial, partial.open('wb') as file:
        np.savez_compressed(file, header=text, **arrays)


def read_archive(path: str | Path, kind: ArchiveKind, wanted: Wanted,
                 check_shapes: CheckShapes = lambda *_: None) -> tuple[Header, Arrays]:
    """
    Read header and arrays; refuse files of another kind in one line.

    Raises
    ------
    LocatedError
        Of the kind: which file, what is wrong with it, and what to do.

    """
    path = Path(path)
    _refuse_missing(path, kind)
    try:
        with npz_reader(path, kind.error) as reader:
            header = _header(path, kind, reader)
            arrays = _arrays(path, kind, reader, header, wanted(header), check_shapes)
    except kind.error:
        raise
    except OSError as error:
        raise kind.error(path, f'cannot be read ({error.strerror})', 'check path and rights'
                         ) from None
    except Exception as error:  # whatever a damaged archive makes zipfile, zlib or numpy say
        raise kind.error(
            path, f'is damaged or no {kind.noun} ({type(error).__name__}: {str(error)[:120]})',
            kind.again) from None
    if kind.hashed and content_hash(header, arrays) != header['hash']:
        raise kind.error(path, 'was altered: its contents do not match its hash', kind.again)
    return header, arrays


def is_archive(path: str | Path, kind: ArchiveKind) -> bool:
    """Return whether a file is an archive of a kind, of whatever version, by its header."""
    try:
        with npz_reader(path, kind.error) as reader:
            return _stated(Path(path), kind, reader).get('format') in (kind.format, *kind.earlier)
    except Exception:  # noqa: BLE001 - whatever else the file is
        return False


def content_hash(header: Mapping[str, Any], arrays: Mapping[str, Any]) -> str:
    """Return SHA-256 over the header without its hash, and over every array."""
    digest = hashlib.sha256()
    plain = {key: value for key, value in header.items() if key != 'hash'}
    digest.update(json.dumps(plain, sort_keys=True).encode())
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        digest.update(f'{name}{array.shape}'.encode())
        flat = array.reshape(-1)
        for start in range(0, flat.size, _CHUNK):  # a whole copy may be twice as large
            digest.update(flat[start:start + _CHUNK].astype('<f8').tobytes())
    return digest.hexdigest()


def _refuse_missing(path: Path, kind: ArchiveKind) -> None:
    try:
        path.stat()
    except FileNotFoundError:
        raise kind.error(path, 'does not exist', kind.missing(path)) from None
    except (OSError, ValueError):
        return  # the opener says it


def _stated(path: Path, kind: ArchiveKind, reader: NpzReader) -> Header:
    """Return the header of an archive, of whatever kind."""
    if 'header' not in reader.names:
        names = short_repr(', '.join(sorted(reader.names)))
        raise kind.error(path, f'has no header, so it is no {kind.noun}; it holds {names}',
                         kind.again)
    layout = reader.layout('header')
    if layout.dtype.kind != 'U' or layout.shape != () or layout.nbytes > MAX_HEADER:
        raise _wrong_layout(path, kind, 'header', layout)
    header = json.loads(str(reader.array('header')))
    return header if isinstance(header, dict) else {}


def _header(path: Path, kind: ArchiveKind, reader: NpzReader) -> Header:
    header = _stated(path, kind, reader)
    stated, schema = header.get('format'), header.get('schema')
    if stated not in (kind.format, *kind.earlier):
        raise kind.error(path, f'is no {kind.noun}: its header says {short_repr(stated)}, not '
                         f'{kind.format!r}', kind.again)
    if stated != kind.format or type(schema) is not int or schema not in kind.schemas:
        version = ('an earlier version' if stated != kind.format or (
            type(schema) is int and schema < kind.schemas[0]) else 'another version')
        raise kind.error(path, f'was written by {version} (format {short_repr(schema)}; this one '
                         f'reads {kind.schemas[-1]})', kind.renew)
    if kind.hashed and not isinstance(header.get('hash'), str):
        raise kind.error(path, 'has no hash', kind.again)
    if _depth(header) > MAX_DEPTH:
        raise ValueError(f'a header nested more than {MAX_DEPTH} deep')
    return header


def _arrays(path: Path, kind: ArchiveKind, reader: NpzReader, header: Header,
            wanted: Mapping[str, str], check_shapes: CheckShapes) -> Arrays:
    """Check all layouts, then read."""
    layouts: dict[str, ArrayLayout] = {}
    for name, code in wanted.items():
        optional, name = name.endswith('?'), name.removesuffix('?')
        if name not in reader.names:
            if optional:
                continue
            raise kind.error(path, f'has no {name}, so it is no {kind.noun}', kind.again)
        layouts[name] = layout = reader.layout(name)
        right = layout.dtype.kind == 'U' if code == 'U' else layout.dtype == np.dtype(code)
        if not right or layout.nbytes > kind.most_bytes:
            raise _wrong_layout(path, kind, name, layout)
    total = sum(layout.nbytes for layout in layouts.values())
    if total > MAX_BYTES:
        raise kind.error(path, f'holds {total / 1e6:.0f} MB, more than the '
                         f'{MAX_BYTES / 1e6:.0f} that are read', kind.again)
    try:
        check_shapes(header, {name: layout.shape for name, layout in layouts.items()})
    except SquealError as error:
        raise kind.error(path, f'holds no usable {kind.contents} ({error})', kind.again) from None
    return {name: reader.array(name) for name in layouts}


def _wrong_layout(path: Path, kind: ArchiveKind, name: str, layout: ArrayLayout) -> LocatedError:
    return kind.error(
        path, f'{name} is an array {short_repr(layout.shape)} of {str(layout.dtype)[:40]} and '
        f'{layout.nbytes / 1e6:.1f} MB, which no {kind.noun} has', kind.again)


def _depth(value: Any) -> int:
    """Return the depth of nested mappings and lists, without recursion; stops counting early."""
    depth, level = 0, [value]
    while level and depth <= MAX_DEPTH:
        depth += 1
        level = [item for outer in level if isinstance(outer, dict | list | tuple)
                 for item in (outer.values() if isinstance(outer, dict) else outer)
                 if isinstance(item, dict | list | tuple)]
    return depth

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
Definitions of recorded messages: the bag's own, a folder's, a workspace's, the standard ones.

They are looked for in that order. A bag may hold another version of a type than is installed here,
so its own definition always wins.
"""

from collections.abc import Iterator, Mapping
import os
from pathlib import Path
import re
from typing import Any

try:
    from rosbags.interfaces import Connection, MessageDefinitionFormat, Nodetype
    from rosbags.typesys import get_types_from_idl, get_types_from_msg, get_typestore, Stores
    from rosbags.typesys.store import Typestore
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error

from squeal_core.common.bounded_reader import read_text_bounded
from squeal_core.common.errors import in_one_line, LocatedError
from squeal_ros.recordings.bags.bag_bounds import least_size
from squeal_ros.recordings.findings import full_type_name

_STANDARD = get_typestore(Stores.ROS2_JAZZY)
_SEPARATOR = re.compile(r'^={80}[ \t]*\n', re.MULTILINE)
_HEADER = re.compile(r'(MSG|IDL): *(\S+)[ \t]*\n')
_PREPROCESSOR = re.compile(
    r'^[ \t]*#[ \t]*(include|if|ifdef|ifndef|elif|else|endif|define|undef|pragma)\b[^\n]*$',
    re.MULTILINE)
_HEADER_TYPE = 'std_msgs/msg/Header'
_MOST_BYTES = 1_000_000  # of one definition file
_MOST_FILES = 100_000  # looked through in a folder of definitions
_LONGEST_ARRAY = 1_000_000  # entries of an array of fixed length


class DefinitionError(LocatedError):
    """A message type without a definition that can be used."""


class MessageDefinitions:
    """
    Finds the definitions of recorded messages.

    Parameters
    ----------
    folder : path, optional
        Folder of `.msg` or `.idl` files, in packages or flat.

    Raises
    ------
    DefinitionError
        For what is no folder, or holds no definitions.

    """

    def __init__(self, folder: str | Path | None = None) -> None:
        self._folder = None if folder is None else Path(folder)
        self._files: dict[str, list[Path]] = {}
        self.notes: dict[str, str] = {}  # by type: whose definition stands in
        if self._folder is not None:
            if not self._folder.is_dir():
                raise DefinitionError(self._folder, 'is no folder', 'give a folder of .msg files')
            for path in definition_files(self._folder):
                self._files.setdefault(path.stem, []).append(path)
            if not self._files:
                raise DefinitionError(self._folder, 'holds no .msg or .idl file',
                                      'give a folder of .msg files')

    def store_for(self, connection: Connection, recorded: str, bag: object) -> Typestore:
        """
        Return a store that decodes the messages of a connection.

        Parameters
        ----------
        connection : Connection
            Of the bag.
        recorded : str
            Hash of the type as it was recorded; empty where it is not known.
        bag : object
            Named in errors.

        Raises
        ------
        DefinitionError
            Naming the type that no definition is found for, and where one may come from.

        """
        wanted, own, fault = full_type_name(connection.msgtype), dict[str, Any](), ''
        try:
            own = _parse(connection)
        except Exception as error:  # the parsers let assertions and key errors through
            fault = f' that can be read ({in_one_line(error, 120)})'
        if wanted not in own:
            own = {}
        needed = self._needed(wanted, own, fault, bag)
        store = _store_of(wanted, needed, bag)
        if not own:
            _check_version(store, wanted, recorded, bag)
        return store

    def _needed(self, wanted: str, own: Mapping[str, Any], fault: str,
                bag: object) -> dict[str, Any]:
        """Return the fields of a type and of all that it contains."""
        needed: dict[str, Any] = {}
        pending = [wanted]
        while pending:
            name = pending.pop()
            if name in needed:
                continue
            fields = own.get(name) or self._elsewhere(name, noted=name == wanted and not own)
            if fields is None:
                raise _missing(bag, wanted, name, fault)
            needed[name] = fields
            pending.extend(_references(fields))
        return needed

    def _elsewhere(self, name: str, *, noted: bool) -> Any:
        """Return the fields of a type that the bag does not define; None if nothing does."""
        package, _, base = name.partition('/msg/')
        for path in (*self._in_folder(package, base), *_in_workspace(package, base)):
            text = read_text_bounded(path, _MOST_BYTES, DefinitionError)
            try:
                result = _parse_block(text, name, idl=path.suffix == '.idl').get(name)
            except Exception as error:
                raise DefinitionError(
                    path, f'is no message definition ({in_one_line(error, 120)})',
                    'correct or remove it') from None
            if result is not None:
                return result
        result = _STANDARD.fielddefs.get(name)
        if result is not None and noted:
            self.notes[name] = (f'the bag holds no definition of {name}; that of ROS 2 Jazzy '
                                'is used')
        return result

    def _in_folder(self, package: str, base: str) -> list[Path]:
        """Return the folder's files for a type, the ones in its package's folder first."""
        def rank(path: Path) -> int:
            names = [part.name for part in path.resolve().parents][:2]
            folder = names[1] if names[0] in ('msg', 'idl') and len(names) > 1 else names[0]
            return 0 if folder == package else 1

        ranked = sorted(self._files.get(base, []), key=rank)
        return [path for path in ranked if rank(path) == 0 or path.resolve().parent in (
            (self._folder or path).resolve(), (self._folder or path).resolve() / 'msg')]


def _store_of(wanted: str, needed: dict[str, Any], bag: object) -> Typestore:
    """Return a store of types, after their size was found to be one that can be decoded."""
    try:
        least_size(wanted, needed)
    except ValueError as error:
        raise DefinitionError(bag, f'has a type that cannot be decoded ({error})',
                              'record it with a type of usual size') from None
    store = get_typestore(Stores.EMPTY)
    try:
        store.register(needed)
    except Exception as error:  # a type with parts that rosbags does not know
        raise DefinitionError(
            bag, f'its definition of {wanted} cannot be used ({in_one_line(error, 120)})',
            'give one of known types (--types FOLDER), or leave the topic out') from None
    if hasattr(store, 'max_sequence_length'):
        store.max_sequence_length = 16 * _LONGEST_ARRAY
    return store


def _check_version(store: Typestore, name: str, recorded: str, bag: object) -> None:
    """Refuse a definition from elsewhere that is of another version than was recorded."""
    if recorded.startswith('RIHS01_') and store.hash_rihs01(name) != recorded:
        raise DefinitionError(
            bag, f'was recorded with another version of {name} than the one found here',
            'give a folder of the .msg files it was recorded with (--types FOLDER)')


def _missing(bag: object, wanted: str, name: str, fault: str) -> DefinitionError:
    inside = '' if name == wanted else f', which {wanted} contains'
    return DefinitionError(bag, f'holds no definition of {name}{fault}{inside}',
                           'give a folder of its .msg files (--types FOLDER), or source a '
                           'workspace that has them')


def definition_files(folder: Path) -> Iterator[Path]:
    """Yield the files in a folder that define message types; refuse one of too many files."""
    seen = 0
    for parent, _, names in os.walk(folder):
        for name in names:
            seen += 1
            if seen > _MOST_FILES:
                raise DefinitionError(folder, f'holds more than {_MOST_FILES} files',
                                      'give the folder of the .msg files alone')
            if name.endswith(('.msg', '.idl')):
                yield Path(parent) / name


def _in_workspace(package: str, base: str) -> Iterator[Path]:
    """Yield the definition in the sourced workspaces, if there is one."""
    for prefix in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep):
        for suffix in ('msg', 'idl'):
            path = Path(prefix, 'share', package, 'msg', f'{base}.{suffix}')
            if prefix and path.is_file():
                yield path


def _parse(connection: Connection) -> dict[str, Any]:
    """Return the types that a recorded definition defines: empty where there is none."""
    idl = connection.msgdef.format == MessageDefinitionFormat.IDL
    text = connection.msgdef.data.replace('\r\n', '\n')
    if connection.msgdef.format == MessageDefinitionFormat.NONE or not text.strip():
        return {}
    types: dict[str, Any] = {}
    for block in _SEPARATOR.split(text):
        header = _HEADER.match(block)
        if header:
            types |= _parse_block(block[header.end():], header[2], idl=header[1] == 'IDL')
        elif block.strip():
            types |= _parse_block(block, full_type_name(connection.msgtype), idl=idl)
    if _HEADER_TYPE in types:  # that of ROS 1 has a `seq`, which rosbags leaves out
        constants, fields = types[_HEADER_TYPE]
        types[_HEADER_TYPE] = constants, [field for field in fields if field[0] != 'seq']
    return types


def _parse_block(text: str, name: str, *, idl: bool) -> Mapping[str, Any]:
    """Return the types in one definition; IDL may have lines of a preprocessor."""
    text = text.replace('\r\n', '\n')
    types: Mapping[str, Any] = (
        get_types_from_idl(_PREPROCESSOR.sub('', text)) if idl
        else get_types_from_msg(text if text.endswith('\n') else f'{text}\n', name))
    for kind, (_, fields) in types.items():
        for field, description in fields:
            _check_length(f'{kind}.{field}', description)
    return types


def _check_length(where: str, description: Any) -> None:
    kind, detail = description
    if kind == Nodetype.ARRAY and detail[1] > _LONGEST_ARRAY:
        raise DefinitionError(where, f'is an array of {detail[1]} entries',
                              f'give a type with at most {_LONGEST_ARRAY}')


def _references(fields: Any) -> Iterator[str]:
    """Yield the names of the types that a type contains."""
    for _, (kind, detail) in fields[1]:
        if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            kind, detail = detail[0]
        if kind == Nodetype.NAME:
            yield detail

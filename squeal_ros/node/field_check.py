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

"""Checks that field paths name numbers of their message types, before any message comes."""

from collections.abc import Callable, Mapping
import re
from typing import TypeAlias

from squeal_core.common.errors import ConfigurationError, did_you_mean
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.node.field_paths import FieldPath

# names of fields and their types (`double`, `sequence<double>`, `double[9]`, `pkg/Name`) by type
FieldsOf: TypeAlias = Callable[[str], Mapping[str, str]]

_LIST = re.compile(r'sequence<(?P<item>[^,>]+(?:<\d+>)?)(?:, (?P<most>\d+))?>|'
                   r'(?P<element>.+)\[(?P<count>\d+)\]')
_NUMBERS = ('float', 'double', 'long double', 'boolean', 'int8', 'int16', 'int32', 'int64',
            'uint8', 'uint16', 'uint32', 'uint64', 'char')
_BYTES = ('uint8', 'octet', 'char', 'int8')
_RAW_PACKAGES = ('can_msgs', 'ros2_socketcan_msgs')
_IDS = ('id', 'can_id', 'arbitration_id')


def check_fields(settings: MonitorSettings, fields_of: FieldsOf,
                 warn: Callable[[str], None]) -> None:
    """
    Check the field path of every input against its message type.

    Parameters
    ----------
    settings : MonitorSettings
        Of the monitor.
    fields_of : callable
        Fields of a message type; raises ConfigurationError for one that is not known.
    warn : callable
        Given a text for a path that is possible and hardly meant.

    Raises
    ------
    ConfigurationError
        Naming the key, the path, and the fields that there are.

    """
    for brake in settings.brakes:
        for signal, source in brake.inputs.items():
            where = f'{brake.name}.{signal}'
            if source.type.partition('/')[0] in _RAW_PACKAGES:
                raise _raw(f'{where}.type', source.type)
            try:
                fields_of(source.type)
            except ConfigurationError as error:
                raise ConfigurationError(f'{where}.{error.where}', error.what, error.remedy
                                         ) from None
            try:
                doubt = check_path(FieldPath.parse(source.field), source.type, fields_of)
            except ConfigurationError as error:
                raise ConfigurationError(f'{where}.field', error.what, error.remedy) from None
            if doubt:
                warn(f'{where}.field: {doubt}')


def check_path(path: FieldPath, type_name: str, fields_of: FieldsOf) -> str:
    """Raise ConfigurationError unless a path leads to a number; return a doubt, or ''."""
    owner, kind, place, element = type_name, type_name, '', False
    for step, name, _ in path.steps:
        if step == 'attribute':
            owner, kind = kind, _field(path, kind, str(name), place, fields_of)
            place, element = f'{place}.{name}'.lstrip('.'), False
            continue
        item, count = _item(kind)
        if not item:
            raise _wrong(path, f'{place} is {kind}, no list', f'leave [{name}] off')
        if step == 'lookup':
            names = fields_of(owner)
            if _item(names.get(str(name), ''))[0] not in ('string', 'wstring'):
                texts = [n for n, k in names.items() if _item(k)[0] in ('string', 'wstring')]
                raise _wrong(path, f'{owner} has no list {name!r} of texts',
                             f'name one of {", ".join(texts)}' if texts else
                             f'write {place}[2], counted from 0')
        elif count is not None and int(name) >= count:
            raise _wrong(path, f'{place} has {count} elements', f'count from 0 to {count - 1}')
        kind, place, element = item, f'{place}[{name}]', True
    return _check_number(path, owner, kind, place, element, fields_of)


def _field(path: FieldPath, kind: str, name: str, place: str, fields_of: FieldsOf) -> str:
    """Return the type of a field of a message."""
    if _item(kind)[0]:
        raise _wrong(path, f'{place} is a list ({kind})', f'write {place}[0].{name}')
    if '/' not in kind:
        raise _wrong(path, f'{place} is {kind} and has no fields', f'leave .{name} off')
    fields = fields_of(kind)
    if name not in fields:
        raise _wrong(path, f'{kind} has no field {name!r}', f'use one of {", ".join(fields)}'
                     f'{did_you_mean(name, fields)}')
    return fields[name]


def _check_number(path: FieldPath, owner: str, kind: str, place: str, element: bool,
                  fields_of: FieldsOf) -> str:
    item, _ = _item(kind)
    if item:
        raise _wrong(path, f'{place} is a list ({kind})',
                     f'write {place}[0], or {place}[name=TEXT] where a list of names is beside it')
    if '/' in kind:
        inner = [f'{place}.{name}' for name in fields_of(kind)]
        raise _wrong(path, f'{place} is a message ({kind})', f'use one of {", ".join(inner)}')
    if element and kind in _BYTES:
        if any(name in _IDS for name in fields_of(owner)):
            raise _raw('field', path.text)
        return (f'{path.text!r} is a single byte ({kind}); a field path can put no bytes together '
                'and pick no id: decode raw frames first')
    if kind not in _NUMBERS:
        raise _wrong(path, f'{place} is {kind}, no number', 'name a field that is a number')
    return ''


def _item(kind: str) -> tuple[str, int | None]:
    """Return type and count of the elements of a list; '' for what is no list."""
    match = _LIST.fullmatch(kind)
    if match is None:
        return '', None
    return match['item'] or match['element'], int(match['count']) if match['count'] else None


def _raw(where: str, name: str) -> ConfigurationError:
    return ConfigurationError(
        where, f'is {name!r}, raw bytes of all ids on a bus: a field path can pick neither an id '
        'nor a 16-bit word', 'decode the frames first, and name the topic of the decoded value')


def _wrong(path: FieldPath, what: str, remedy: str) -> ConfigurationError:
    return ConfigurationError('field', f'is {path.text!r}, and {what}', remedy)

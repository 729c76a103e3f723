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


"""Fields that a message offers where a field path of the settings does not fit it."""

from typing import Any

from squeal_core.common.errors import nearest_word
from squeal_core.common.wording import listed
from squeal_ros.node.field_paths import FieldPath

_MOST_NAMES = 12  # listed of what there is


def hint(path: FieldPath, message: Any) -> str:
    """Return the fields that a message offers where a field path does not fit it."""
    owner, value = message, message
    for kind, name, key in path.steps:
        try:
            if kind == 'attribute':
                owner, value = value, getattr(value, str(name))
            elif kind == 'index':
                value = value[name]
            else:
                names = [str(entry) for entry in getattr(owner, str(name))]
                if key not in names:
                    return _instead(key, names, f'the message has in its list {name!r}: ')
                if len(value) != len(names):
                    return (f'have its source send as many values as there are in {name!r}: '
                            f'{len(value)} and {len(names)} now')
                value = value[names.index(key)]
        except AttributeError:
            return _instead(str(name), _fields(value if kind == 'attribute' else owner),
                            'its fields are: ')
        except IndexError:
            return f'its list has {len(value)} entries, counted from 0'
        except (KeyError, TypeError, ValueError):
            break
    fields = _fields(value)
    if fields:
        return f'name one of its fields: {in_words(fields)}'
    if hasattr(value, '__len__') and not isinstance(value, str):
        return f'name one of its {len(value)} entries: {path.text}[0]'
    return f'name a number; fields of the message: {in_words(_fields(message))}'


def _instead(wrong: str, names: list[str], before: str) -> str:
    near = nearest_word(wrong, names)
    meant = f'do you mean {near!r}? ' if near else ''
    return f'{meant}{before}{in_words(names) or "nothing"}'


def _fields(value: Any) -> list[str]:
    return [name for name in getattr(value, '__dataclass_fields__', {})
            if not name.startswith('__')]


def in_words(names: Any) -> str:
    """Return names in a line, the first of them where there are many."""
    return listed(names, _MOST_NAMES)

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

"""Strict reading of a YAML file key by key; errors name file, line and key."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from squeal_core.common.bounded_reader import ErrorOf
from squeal_core.common.errors import did_you_mean, printable, short_repr, SquealError
from squeal_core.common.yaml_reader import read_yaml_with_lines


class YamlSection:
    """
    One mapping of a YAML file, read key by key; `finish` refuses keys that were not read.

    Parameters
    ----------
    path : path
        Of the file.
    error_of : callable
        Makes the errors that are raised, of where, what and remedy.
    lines : mapping
        As `read_yaml_with_lines` returns them.
    keys : tuple of str
        That lead to the mapping.
    content : object
        What stands there; None: nothing.

    """

    def __init__(self, path: Path, error_of: ErrorOf, lines: Mapping[tuple[str, ...], int],
                 keys: tuple[str, ...], content: Any) -> None:
        self._path, self._error_of, self._lines, self._keys = path, error_of, lines, keys
        self._used: set[str] = set()
        if content is None:
            content = {}
        if not isinstance(content, Mapping):
            raise self.error('', f'is {short_repr(content)}', 'write keys and values')
        self.content = {str(key): value for key, value in content.items()}

    @classmethod
    def of_file(cls, path: Path, error_of: ErrorOf) -> 'YamlSection':
        """Return the whole content of a file."""
        content, lines = read_yaml_with_lines(path, error_of)
        return cls(path, error_of, lines, (), content)

    def where(self, key: str = '') -> str:
        """Return file, line and path of a key, or of the mapping."""
        keys = (*self._keys, *filter(None, [key]))
        line = next((self._lines[keys[:n]] for n in range(len(keys), 0, -1)
                     if keys[:n] in self._lines), 1)
        return f'{self._path}, line {line}' + (f', {printable(".".join(keys))}' if keys else '')

    def error(self, key: str, what: str, remedy: str) -> SquealError:
        """Return the error of a key."""
        return self._error_of(self.where(key), what, remedy)

    def take(self, key: str) -> Any:
        """Return the value at a key; None where there is none."""
        self._used.add(key)
        return self.content.get(key)

    def section(self, key: str) -> 'YamlSection':
        """Return the mapping at a key; an empty one where there is none."""
        self._used.add(key)
        return YamlSection(self._path, self._error_of, self._lines,
                           (*self._keys, key), self.content.get(key))

    def sections(self, key: str) -> list['YamlSection']:
        """Return the mappings in the list at a key, or the one that stands there alone."""
        self._used.add(key)
        value = self.content.get(key)
        return [YamlSection(self._path, self._error_of, self._lines, (*self._keys, key), one)
                for one in (value if isinstance(value, list) else [value])]

    def text(self, key: str, default: str | None = '', choices: tuple[str, ...] = ()) -> str:
        """Return a text; numbers are texts, too, as in `column: 3` and `unit: 1`."""
        self._used.add(key)
        value = self.content.get(key, default)
        if value is None:
            raise self.error(key, 'is missing', 'add it')
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise self.error(key, f'is {short_repr(value)}', 'write a text, in quotes')
        text = str(value)
        if choices and text not in choices and text != default:
            raise self.error(key, f'is {short_repr(text)}', f'write one of {", ".join(choices)}'
                             f'{did_you_mean(text, choices)}')
        return text

    def number(self, key: str, default: float, low: float = -1e12, high: float = 1e12) -> float:
        """Return a number in a range."""
        self._used.add(key)
        value = self.content.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not (
                low <= value <= high):
            raise self.error(key, f'is {short_repr(value)}',
                             f'write a number from {low:g} to {high:g}')
        return float(value)

    def count(self, key: str, most: int) -> int | None:
        """Return a whole number from 0, or None where there is none."""
        self._used.add(key)
        if key not in self.content:
            return None
        value = self.number(key, 0.0, 0.0, most)
        if value % 1.0:
            raise self.error(key, f'is {value:g}', 'write a whole number')
        return int(value)

    def finish(self, known: tuple[str, ...] = ()) -> None:
        """Refuse keys that were not asked for and are not among the known ones."""
        allowed = self._used | set(known)
        for key in self.content:
            if key not in allowed:
                raise self.error(str(key), f'unknown key (value {short_repr(self.content[key])})',
                                 f'use {", ".join(sorted(allowed))}{did_you_mean(key, allowed)}')

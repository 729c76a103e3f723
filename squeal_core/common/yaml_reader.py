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

"""YAML as plain data: bounded, no Python tags, no key twice, one error for all that can fail."""

from pathlib import Path
from typing import Any

from squeal_core.common.bounded_reader import ErrorOf, read_bounded
from squeal_core.common.errors import in_one_line, short_repr
from squeal_core.common.yaml_scalars import BOOLEANS, number

MAX_BYTES = 1_000_000
MAX_NODES = 20_000  # keys, values, lists and mappings: the settings of MAX_BRAKES have half of it
MAX_DEPTH = 30
MAX_TEXT = 10_000  # characters of one key or value
_TEXT, _INTEGER, _REAL, _BOOLEAN, _TIME = (
    f'tag:yaml.org,2002:{name}' for name in ('str', 'int', 'float', 'bool', 'timestamp'))


def read_yaml(path: str | Path, error_of: ErrorOf, *, most_bytes: int = MAX_BYTES,
              most_nodes: int = MAX_NODES, ros: bool = False) -> Any:
    """
    Return the content of a YAML file, with numbers as ROS reads them.

    Parameters
    ----------
    path : path
        Where the file is.
    error_of : callable
        Makes the caller's error of where, what and remedy; raised for what is no plain YAML.
    most_bytes, most_nodes : int
        Of the file; of keys, values, lists and mappings in it.
    ros : bool
        Whether it is a ROS parameter file: every key is a text, `y` and `n` are true and false.

    """
    return _read(path, error_of, most_bytes, most_nodes, ros)[0]


def read_yaml_with_lines(path: str | Path, error_of: ErrorOf
                         ) -> tuple[Any, dict[tuple[str, ...], int]]:
    """Return the content of a YAML file, as `read_yaml`, and the line of each key by its path."""
    content, node = _read(path, error_of, MAX_BYTES, MAX_NODES)
    lines: dict[tuple[str, ...], int] = {}
    _note_lines(node, (), lines)
    return content, lines


def _note_lines(node: Any, where: tuple[str, ...], lines: dict[tuple[str, ...], int]) -> None:
    if getattr(node, 'id', '') == 'mapping':
        for key, value in node.value:
            lines[(*where, str(key.value))] = key.start_mark.line + 1
            _note_lines(value, (*where, str(key.value)), lines)


def _loader(yaml: Any, base: Any, ros: bool) -> Any:
    """Return the class that makes plain data of a text."""
    class Loader(base):  # type: ignore[misc]
        """Reads numbers as ROS, and refuses a key given twice, which a reader would not notice."""

        def resolve(self, kind: Any, value: str, implicit: Any) -> Any:
            tag = super().resolve(kind, value, implicit)
            if kind is not yaml.ScalarNode or not implicit[0]:
                return tag
            if number(value) is not None:
                return _REAL
            if ros and value in ('y', 'Y', 'n', 'N'):
                return _BOOLEAN
            return _TEXT if tag in (_INTEGER, _REAL, _TIME) else tag

        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            seen: set[str] = set()
            for key, _ in node.value:
                if key.value in seen:
                    raise yaml.YAMLError(f'{short_repr(key.value)} twice in the mapping at line '
                                         f'{node.start_mark.line + 1}')
                seen.add(str(key.value))
                if ros:
                    key.tag = _TEXT
            return super().construct_mapping(node, deep)

    def construct_number(_: Any, node: Any) -> int | float:
        result = number(node.value)
        if result is None:
            raise yaml.YAMLError(f'{short_repr(node.value)} in line {node.start_mark.line + 1} is '
                                 'no number')
        return result

    Loader.add_constructor(_REAL, construct_number)
    Loader.add_constructor(_INTEGER, construct_number)
    Loader.add_constructor(_BOOLEAN, lambda _, node: BOOLEANS[node.value.lower()])
    return Loader


def _read(path: str | Path, error_of: ErrorOf, most_bytes: int, most_nodes: int,
          ros: bool = False) -> tuple[Any, Any]:
    """Return the content of a YAML file and the node it was made of."""
    import yaml

    base: Any = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)  # C's is ten times as fast
    data = read_bounded(path, most_bytes, error_of)
    try:
        text = data.decode('utf-8')
        _check_events(yaml, text, base, most_nodes)
        loader = _loader(yaml, base, ros)(text)  # a SafeLoader: plain data only
        try:
            node = loader.get_single_node()
            return (None if node is None else loader.construct_document(node)), node
        finally:
            loader.dispose()
    except Exception as error:  # PyYAML lets ValueError, KeyError, RecursionError and more out
        text = in_one_line(error, 200)
        raise error_of(path, f'is not YAML this can read ({text})', 'mend it') from None


def _check_events(yaml: Any, text: str, loader: Any, most_nodes: int) -> None:
    """Refuse, before anything is built, what no description has: bombs and endless nesting."""
    depth = count = 0
    for event in yaml.parse(text, loader):
        line = event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent):
            raise yaml.YAMLError(f'an alias (*) in line {line}')
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        elif isinstance(event, yaml.ScalarEvent) and len(event.value) > MAX_TEXT:
            raise yaml.YAMLError(f'a text of {len(event.value)} characters in line {line}')
        count += isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent)
        if depth > MAX_DEPTH or count > most_nodes:
            raise yaml.YAMLError(f'more than {most_nodes} keys and values, or nested more than '
                                 f'{MAX_DEPTH} deep, in line {line}')

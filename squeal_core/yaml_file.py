"""YAML as plain data: bounded, no Python tags, no key twice, one error for all that can fail."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from squeal_core.errors import quoted, SquealError

MAX_BYTES = 1_000_000


def read_yaml(path: str | Path, error_of: Callable[[object, str, str], SquealError]) -> Any:
    """Return the content of a YAML file.

    Parameters
    ----------
    path : path
    error_of : callable
        Makes the caller's error of where, what and remedy; raised for what is no plain YAML.
    """
    import yaml

    class Loader(yaml.SafeLoader):
        """Refuses what a description has no need of and a reader would not notice."""

        def compose_node(self, parent: Any, index: Any) -> Any:
            if self.check_event(yaml.AliasEvent):
                raise yaml.YAMLError(f'an alias (*) in line {self.line + 1}')
            return super().compose_node(parent, index)

        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            seen: set[str] = set()
            for key, _ in node.value:
                if key.value in seen:
                    raise yaml.YAMLError(f'{quoted(key.value)} twice in the mapping at line '
                                         f'{node.start_mark.line + 1}')
                seen.add(str(key.value))
            return super().construct_mapping(node, deep)

    try:
        with open(path, 'rb') as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        text = getattr(error, 'strerror', None) or error
        raise error_of(path, f'cannot be read ({text})', 'check the path') from None
    if len(data) > MAX_BYTES:
        raise error_of(path, f'has more than {MAX_BYTES} bytes', 'keep it shorter')
    try:
        return yaml.load(data.decode('utf-8'), Loader)  # a SafeLoader: plain data only
    except Exception as error:  # PyYAML lets ValueError, KeyError, RecursionError and more out
        text = ' '.join(str(error).split())[:200]
        raise error_of(path, f'is not YAML this can read ({text})', 'mend it') from None

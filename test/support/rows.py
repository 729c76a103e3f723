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

"""One test for a table of cases: all rows are tried, and those that fail are reported together."""

from collections.abc import Callable, Iterable
import functools
import inspect
from typing import Any

import pytest

_SHOWN = 60  # characters of an argument in a report


def each(names: str | tuple[str, ...], rows: Iterable[Any]) -> Callable[[Any], Any]:
    """
    Decorate a test that is called with each row of a table in turn.

    Written like `pytest.mark.parametrize`, of which it makes one test; two of them try every pair.
    Fixtures are shared by all rows: for cases that change them, parametrize.

    Parameters
    ----------
    names : str or tuple of str
        Arguments of the test that a row gives values of.
    rows : iterable
        A value for a single name, else as many values as names; or a `pytest.param` of these.

    """
    keys = (names,) if isinstance(names, str) else tuple(names)
    table = [_values(row, len(keys)) for row in rows]
    assert table, 'a table without rows'

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        signature = inspect.signature(test)

        @functools.wraps(test)
        def run(**fixtures: Any) -> None:
            failed = []
            for row in table:
                try:
                    test(**fixtures, **dict(zip(keys, row, strict=True)))
                except (Exception, pytest.fail.Exception) as error:
                    failed.append(f'{_shown(keys, row)}: {type(error).__name__}: {error}')
            if failed:
                pytest.fail(f'{len(failed)} of {len(table)} rows\n' + '\n'.join(failed),
                            pytrace=False)

        run.__signature__ = signature.replace(parameters=[  # type: ignore[attr-defined]
            p for name, p in signature.parameters.items() if name not in keys])
        return run
    return decorate


def _values(row: Any, count: int) -> tuple[Any, ...]:
    if hasattr(row, 'marks'):  # of pytest.param
        row = row.values[0] if count == 1 else row.values
    values = (row,) if count == 1 else tuple(row)
    assert len(values) == count, values
    return values


def _shown(keys: tuple[str, ...], row: tuple[Any, ...]) -> str:
    return ', '.join(f'{key}={repr(value)[:_SHOWN]}' for key, value in zip(keys, row, strict=True))

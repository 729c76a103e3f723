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

"""One error class an area; each says in one line what, which value, where, and the remedy."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
import difflib
import reprlib
from typing import Any

_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 60
_REPR.maxlevel = 2


def short_repr(value: Any) -> str:
    """Return a value as an error may quote it: short, whatever its size."""
    try:
        return _REPR.repr(value)
    except ValueError:  # integers of thousands of digits
        return f'a {type(value).__name__} of great length'


def printable(value: object, most: int = 99) -> str:
    """Return a value in one short line without control characters."""
    text = value if isinstance(value, str) and len(value) <= most else short_repr(value)
    return ''.join(letter if letter.isprintable() else
                   letter.encode('unicode_escape').decode('ascii') for letter in text)


def in_one_line(text: object, most: int | None = None) -> str:
    """Return a text, as of a foreign error, in one line of at most so many characters."""
    return ' '.join(str(text).split())[:most]


def nearest_word(wrong: Any, known: Iterable[str]) -> str:
    """Return the known word nearest to a wrong one, in either case; '' where none is near."""
    folded = {word.casefold(): word for word in reversed(list(dict.fromkeys(known)))}
    text = str(wrong)[:80].casefold()
    near = difflib.get_close_matches(text, folded, n=1, cutoff=0.6)
    return folded[near[0]] if near else ''


def did_you_mean(wrong: Any, known: Iterable[str]) -> str:
    """Return ' (did you mean ...?)' with the known word nearest to a wrong one; '' without one."""
    near = nearest_word(wrong, known)
    return f' (did you mean {near}?)' if near else ''


class SquealError(ValueError):
    """Base of the errors that a caller's input can cause."""

    def __init__(self, text: str) -> None:
        super().__init__(in_one_line(text))


@contextmanager
def solver_errors(what: str, remedy: str = '') -> Iterator[None]:
    """
    Raise whatever solvers raise for one brake, as for an invalid mesh, as a SquealError.

    Parameters
    ----------
    what : str
        What failed; the solver's words follow it.
    remedy : str
        What to do.

    """
    try:
        yield
    except (SquealError, ImportError, MemoryError):
        raise
    except Exception as error:
        raise SquealError(f'{what} ({type(error).__name__}: {str(error)[:120]})'
                          + (remedy and f'; {remedy}')) from error


class LocatedError(SquealError):
    """An error at a place: a key's path or a file."""

    def __init__(self, where: object, what: str, remedy: str) -> None:
        super().__init__(f'{where}: {what}; {remedy}')
        self.where, self.what, self.remedy = where, what, remedy


class BrakeDescriptionError(LocatedError):
    """A brake description that cannot be used."""


class ConfigurationError(LocatedError):
    """A monitor configuration that cannot be used."""


class ModelFileError(LocatedError):
    """A model file that cannot be read or written."""


class TableFileError(LocatedError):
    """A table file that cannot be read, written or used with a model."""


class ModelError(SquealError):
    """Arrays that do not make a brake model."""


class OperatingPointError(SquealError):
    """An operating point at which the linearisation does not hold."""

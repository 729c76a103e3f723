"""One error class an area; each says in one line what, which value, where, and the remedy."""

import reprlib
from typing import Any

_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 60
_REPR.maxlevel = 2


def quoted(value: Any) -> str:
    """Return a value as an error may quote it: short, whatever its size."""
    try:
        return _REPR.repr(value)
    except ValueError:  # integers of thousands of digits
        return f'a {type(value).__name__} of great length'


class SquealError(ValueError):
    """Base of the errors that a caller's input can cause."""

    def __init__(self, text: str) -> None:
        super().__init__(' '.join(text.split()))


class PlacedError(SquealError):
    """An error at a place: a key's path or a file."""

    def __init__(self, where: object, what: str, remedy: str) -> None:
        super().__init__(f'{where}: {what}; {remedy}')


class BrakeDescriptionError(PlacedError):
    """A brake description that cannot be used."""


class ConfigurationError(PlacedError):
    """A monitor configuration that cannot be used."""


class ModelFileError(PlacedError):
    """A model file that cannot be read or written."""


class TableFileError(PlacedError):
    """A file of anchors that cannot be read, written or used with a model."""


class ModelError(SquealError):
    """Arrays that do not make a brake model."""


class OperatingPointError(SquealError):
    """An operating point at which the linearisation does not hold."""

"""One error class an area; each says what, which value, where, and the remedy."""


class SquealError(ValueError):
    """Base of the errors that a caller's input can cause."""


class BrakeDescriptionError(SquealError):
    """A brake description that cannot be used."""

    def __init__(self, where: str, what: str, remedy: str) -> None:
        super().__init__(f'{where}: {what}; {remedy}')


class ModelError(SquealError):
    """Arrays that do not make a brake model."""


class ModelFileError(SquealError):
    """A model file that cannot be read or written."""

    def __init__(self, path: object, what: str, remedy: str) -> None:
        super().__init__(f'{path}: {what}; {remedy}')


class OperatingPointError(SquealError):
    """An operating point at which the linearisation does not hold."""


class ConfigurationError(SquealError):
    """A monitor configuration that cannot be used."""

    def __init__(self, where: str, what: str, remedy: str) -> None:
        super().__init__(f'{where}: {what}; {remedy}')

"""Where the shipped files are: models, brakes, vehicles, drive cycles, the monitor's settings."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def config_folder() -> Path:
    """Return the folder `config/` of the checkout, or of the prefix this is installed in."""
    checkout = _PACKAGE.parent / 'config'
    if (checkout / 'models').is_dir():
        return checkout
    for prefix in _PACKAGE.parents:
        installed = prefix / 'share' / 'squeal_ros' / 'config'
        if installed.is_dir():
            return installed
    return checkout


def find(kind: str, name: str, suffix: str) -> Path:
    """Return a path as it is; for a bare name, that of the shipped file of this kind."""
    if name in names(kind, suffix):
        return config_folder() / kind / f'{name}{suffix}'
    return Path(name)


def names(kind: str, suffix: str) -> list[str]:
    """Return the names of the shipped files of a kind."""
    return sorted(path.stem for path in (config_folder() / kind).glob(f'*{suffix}'))

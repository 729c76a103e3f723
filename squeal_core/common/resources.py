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

"""Paths of shipped files, by kind, and of the user's cache."""

import os
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


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


def table_files(suffix: str = '.npz') -> list[Path]:
    """
    Return the shipped tables and what is beside them, by the suffix of their names.

    Where $SQUEAL_TABLES is set, those in that folder; '': none.
    """
    folder = os.environ.get('SQUEAL_TABLES')
    if folder == '':
        return []
    return sorted((config_folder() / 'tables' if folder is None else Path(folder)
                   ).glob(f'*{suffix}'))


def cache_folder() -> Path:
    """Return $XDG_CACHE_HOME/squeal_ros, or ~/.cache/squeal_ros."""
    base = os.environ.get('XDG_CACHE_HOME')
    return (Path(base) if base else Path.home() / '.cache') / 'squeal_ros'

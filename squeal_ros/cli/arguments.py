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

"""Conversion of a command's options for the library, and checks before long work."""

import argparse
from collections.abc import Sequence
from dataclasses import fields
import math
from pathlib import Path

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common import resources
from squeal_core.common.errors import did_you_mean, short_repr, SquealError
from squeal_core.common.output import check_target, OutputError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.studies.point_options import PointOptions

MOST_WORKERS = 256
PLOT_SUFFIXES = ('.png', '.svg', '.pdf')
DEFAULT_SPEED = 5.0  # rad/s, of sweeps and of sensitivity


def operating_point(model: BrakeModel, options: argparse.Namespace) -> OperatingPoint:
    """Make the operating point that the options describe."""
    return point_options(options).at(model)


def point_options(options: argparse.Namespace) -> PointOptions:
    """Return the options of an operating point."""
    return PointOptions(**{item.name: getattr(options, item.name)
                           for item in fields(PointOptions)})


def check_output(option: str, path: str | Path | None, suffixes: Sequence[str] = (), *,
                 force: bool = False, folder: bool = False,
                 inputs: Sequence[str | Path] = ()) -> None:
    """
    Refuse a file that could not or should not be written, before the work that it is for.

    Parameters
    ----------
    option : str
        As the user wrote it.
    path : path, optional
        Where the file is.
    suffixes : sequence of str
        Of the formats that are known; none: any.
    force : bool
        Whether an existing file may be replaced.
    folder : bool
        Whether the output is a folder.
    inputs : sequence of paths
        What the command reads, which is never replaced.

    """
    if path is None:
        return
    if suffixes and Path(path).suffix not in suffixes:
        raise SquealError(f'{option}: {path} is of no kind that is known; end it in '
                          f'{", ".join(suffixes)}')
    try:
        check_target(path, overwrite=force, folder=folder, inputs=inputs)
    except OutputError as error:
        raise SquealError(f'{option}: {error}') from None


def check_workers(count: int) -> None:
    """Raise SquealError for an invalid number of workers."""
    if not 0 <= count <= MOST_WORKERS:
        raise SquealError(f'--workers: is {count}; give 0 (this process) to {MOST_WORKERS}')


def positive(name: str, value: float) -> float:
    """Return a value, or raise SquealError if it is not positive and finite."""
    if not (math.isfinite(value) and value > 0.0):
        raise SquealError(f'{name}: is {value}; give a positive number')
    return value


def is_there(path: Path) -> bool:
    """Return whether there is something at a path."""
    try:
        return path.exists()
    except (OSError, ValueError):  # a name too long, a NUL
        return False


def is_description(name: str) -> bool:
    """Return whether a brake is given by its description, and not by a model."""
    return Path(name).suffix.lower() in ('.yaml', '.yml')


def shipped(kind: str, name: str, suffix: str) -> Path:
    """Return the path of a file that is there, or of the shipped one of that name."""
    path = resources.find(kind, name, suffix)
    if not is_there(path):
        known = resources.names(kind, suffix)
        raise SquealError(
            f'{short_repr(name)}: there is no such file, and none of {kind} that are '
            f'shipped; give a path, or one of {", ".join(known)}{did_you_mean(name, known)}')
    return path

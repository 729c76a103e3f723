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

"""Saving of figures: whole or not at all, in the format of the suffix."""

from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

from squeal_core.common.output import output_file

FigureTarget: TypeAlias = str | Path | BinaryIO
"""Target of a figure: a path, or an open file, which gets a PNG."""


def save_figure(figure: Any, target: FigureTarget, *, dpi: int, overwrite: bool = True) -> None:
    """
    Save a figure.

    Parameters
    ----------
    figure : matplotlib Figure
        What was drawn.
    target : path or binary file
        A path's suffix is its format; an open file gets a PNG.
    dpi : int
        Dots an inch.
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    OutputError
        Where the file cannot be written.

    """
    if not isinstance(target, str | Path):
        figure.savefig(target, dpi=dpi, format='png')
        return
    with output_file(target, overwrite=overwrite) as partial:
        figure.savefig(partial, dpi=dpi, format=Path(target).suffix[1:].lower() or 'png')

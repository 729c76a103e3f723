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

"""Modal results of other finite element packages, read to `NodalModes`."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from squeal_core.common.errors import short_repr
from squeal_core.modes.nodal_modes import NodalModes
from squeal_core.modes.readers import (
    frd,
    listing,
    nastran_h5,
    nastran_op2,
    normalising,
    placing,
    table,
    unv,
    vtu,
)
from squeal_core.modes.readers.placing import Axis
from squeal_core.modes.readers.raw import RawModes, ReaderError

__all__ = ['FORMATS', 'ReaderError', 'read_modes']

FORMATS: dict[str, Callable[[Path], RawModes]] = {
    'unv': unv.read, 'frd': frd.read, 'nastran_h5': nastran_h5.read,
    'nastran_op2': nastran_op2.read, 'table': table.read, 'listing': listing.read, 'vtu': vtu.read}
_SUFFIXES = {
    '.unv': 'unv', '.uff': 'unv', '.frd': 'frd', '.h5': 'nastran_h5', '.op2': 'nastran_op2',
    '.csv': 'table', '.txt': 'table', '.rpt': 'listing', '.lis': 'listing', '.vtu': 'vtu'}


def read_modes(path: str | Path, *, format: str | None = None, length_unit: str = 'm',  # noqa: A002, E501
               mass_unit: str = 'kg', axis: Axis = 'z',
               origin: Sequence[float] = (0.0, 0.0, 0.0),
               modal_mass: float | Sequence[float] | None = None, density: float | None = None,
               total_mass: float | None = None, frequencies_hz: Sequence[float] | None = None,
               mass_tolerance: float = 0.05) -> NodalModes:
    """
    Return the natural modes that another package has written, in SI units.

    Parameters
    ----------
    path : path
        Where the file is.
    format : str
        One of `FORMATS`; by the suffix if left out.
    length_unit : str
        Of the coordinates: 'm', 'mm' or 'inch'.
    mass_unit : str
        Of the model that the shapes were normalised in: 'kg', 't' (mm, N, MPa), 'g', 'lb' or
        'slinch' (inch, lbf).
    axis : str
        The axis of the file that the brake turns about. From 'x', the file's y, z, x become our
        x, y, z; from 'y', its z, x, y: cyclic, so that right hands stay right hands.
    origin : (3,) floats
        A point on that axis, in axes and units of the file.
    modal_mass : float or (N,) floats
        Of the shapes, in `mass_unit`: 1 for mass-normalised ones. The file's own if left out.
    density : float
        [kg/m^3]. The modal masses are integrated over the elements then, if there are any, and
        used, or held against those that are stated.
    total_mass : float
        Of a free component [kg], to be held against its rigid modes.
    frequencies_hz : (N,) floats
        [Hz], for files that do not state them, or too coarsely.
    mass_tolerance : float
        How far masses may differ, relative; packages with lumped masses need some.

    Returns
    -------
    NodalModes
        Mass normalised. Modes below 1 Hz, or a thousandth of the highest frequency (10 Hz at
        most), are exact rigid motions of a frequency of exactly zero.

    Raises
    ------
    ReaderError
        One line: which file and place, what is wrong with it, and what to do.

    Examples
    --------
    >>> from squeal_core import read_modes
    >>> modes = read_modes('pad.frd', length_unit='mm', mass_unit='t')
    >>> modes.angular_frequencies.size
    9

    """
    path = Path(path)
    raw = _reader(path, format)(path)
    hertz = placing.frequencies(raw, frequencies_hz)
    where, shapes = placing.placed(raw, length_unit, axis, origin)
    unit = placing.choice(raw, 'mass_unit', mass_unit, placing.MASS_UNITS_KG)
    stated = normalising.stated_masses(raw.source, hertz.size, modal_mass, raw.modal_masses, unit)
    modes = NodalModes(where, 2.0 * np.pi * hertz, shapes, raw.elements, source=raw.source)
    return normalising.normalised(modes, stated, density, total_mass, mass_tolerance)


def _reader(path: Path, format: str | None) -> Callable[[Path], RawModes]:  # noqa: A002
    name = _SUFFIXES.get(path.suffix.lower(), '') if format is None else format
    if name not in FORMATS:
        what = (f'has the suffix {short_repr(path.suffix)}' if format is None
                else f'format is {short_repr(format)}')
        raise ReaderError(path, what, f'give format: one of {", ".join(FORMATS)}')
    return FORMATS[name]

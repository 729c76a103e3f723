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

"""Conversion of a file's units and axes to ours: metres, kilograms, the rotation axis along z."""

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import short_repr
from squeal_core.modes.readers.raw import RawModes, ReaderError

Axis: TypeAlias = Literal['x', 'y', 'z']

LENGTH_UNITS_M = {'m': 1.0, 'mm': 1e-3, 'inch': 0.0254}
# slinch: lbf s^2 / inch, the unit of mass of models in pounds of force and inches
MASS_UNITS_KG = {'kg': 1.0, 't': 1e3, 'g': 1e-3, 'lb': 0.45359237, 'slinch': 175.12683524647636}
# old axes that become x, y and z: cyclic, so that right hands stay right hands
_CYCLES = {'x': (1, 2, 0), 'y': (2, 0, 1), 'z': (0, 1, 2)}

# below this, a mode is taken as rigid, its frequency as zero: prestress and coarse solvers leave
# some Hz, a thousandth of what the file reaches; no component bends as slowly
RIGID_HZ, _RIGID_PART, _MOST_RIGID_HZ = 1.0, 1e-3, 10.0
_MOST_RIGID = 6
_HIGHEST_HZ = 1e6
_SMALLEST_M, _LARGEST_M = 1e-3, 10.0


def placed(raw: RawModes, length_unit: str, axis: str,
           origin: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """
    Return coordinates [m] and shapes, the axis of rotation along z through the origin.

    Parameters
    ----------
    raw : RawModes
        As the file gives them.
    length_unit : str
        Of the coordinates and of `origin`: 'm', 'mm' or 'inch'.
    axis : str
        The axis of the file that the brake turns about: 'x', 'y' or 'z'.
    origin : (3,) floats
        A point on it, in axes and units of the file.

    """
    unit = choice(raw, 'length_unit', length_unit, LENGTH_UNITS_M)
    if raw.length_unit_m and abs(raw.length_unit_m / unit - 1.0) > 1e-3:
        raise ReaderError(raw.source, f'says that its lengths are in units of '
                          f'{raw.length_unit_m:.6g} m, but length_unit is {length_unit!r}',
                          'give the unit of the file')
    cycle = list(choice(raw, 'axis', axis, _CYCLES))
    point = np.array(origin, dtype=float)
    if point.shape != (3,) or not np.all(np.isfinite(point)):
        raise ReaderError(raw.source, f'origin is {short_repr(origin)}',
                          'give x, y and z of a point '
                          'on the axis of rotation, in units of the file')
    where = (unit * (raw.coordinates - point))[:, cycle]
    extent = float(np.ptp(where, axis=0).max())
    if not _SMALLEST_M <= extent <= _LARGEST_M:
        raise ReaderError(raw.source, f'spans {extent:.3g} m with length_unit {length_unit!r}, '
                          f'which no brake does', 'give the length_unit of the file: '
                          f'{", ".join(LENGTH_UNITS_M)}')
    return where, raw.shapes[:, :, cycle]


def choice(raw: RawModes, name: str, value: str, choices: dict[str, Any]) -> Any:
    """Return the value that a word stands for."""
    if value not in choices:
        raise ReaderError(raw.source, f'{name} is {short_repr(value)}',
                          f'give one of {", ".join(choices)}')
    return choices[value]


def frequencies(raw: RawModes, given_hz: Sequence[float] | None) -> FloatArray:
    """Return frequencies [Hz]: those given, or those of the file; rigid ones exactly zero."""
    result = raw.frequencies_hz if given_hz is None else np.array(given_hz, dtype=float)
    if result is None:
        raise ReaderError(raw.source, 'does not state frequencies', 'give frequencies_hz')
    if result.shape != (len(raw.shapes),):
        raise ReaderError(raw.source, f'has {len(raw.shapes)} modes but {result.size} frequencies',
                          'give one each mode')
    finite = result[np.isfinite(result)]
    limit = float(np.clip(_RIGID_PART * np.abs(finite).max(initial=0.0), RIGID_HZ,
                          _MOST_RIGID_HZ))
    bad = ~np.isfinite(result) | (result <= -limit) | (result > _HIGHEST_HZ)
    if bad.any():
        raise ReaderError(raw.source, f'mode {bad.argmax() + 1} has {result[bad.argmax()]} Hz',
                          'give real normal modes of a stable component, frequencies in Hz')
    hertz = np.where(np.abs(result) < limit, 0.0, result)
    fall = np.flatnonzero(np.diff(hertz) < 0.0)
    if fall.size:
        raise ReaderError(raw.source, f'mode {fall[0] + 2} has {hertz[fall[0] + 1]} Hz after '
                          f'{hertz[fall[0]]} Hz', 'give the modes of one analysis, rising')
    rigid = int(np.count_nonzero(hertz == 0.0))
    if rigid > _MOST_RIGID:
        raise ReaderError(raw.source, f'has {rigid} modes below {limit:.1f} Hz, but one free '
                          'component has six', 'give one component without mechanisms, '
                          'frequencies in Hz')
    return hertz

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

"""Files of the advice map: CSV, and C arrays for a control unit; the numbers of both are equal."""

from collections.abc import Callable, Iterator
from itertools import product
import math
from pathlib import Path

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import LocatedError, printable
from squeal_core.common.output import OutputFiles
from squeal_core.studies.advice_map import AdviceMap, NOTICE

FORMATS = ('.csv', '.c', '.h')
_LINE = 5  # numbers


class AdviceFileError(LocatedError):
    """An advice map that cannot be written."""


def write_advice_map(result: AdviceMap, *paths: str | Path, overwrite: bool = False) -> None:
    """
    Write a map as CSV or as C99 source, by the suffix; all files or none.

    Raises
    ------
    AdviceFileError
        For another suffix, or C without any risk.
    OutputError
        Where a file cannot be written.

    """
    with OutputFiles(overwrite=overwrite) as files:
        for path in map(Path, paths):
            if path.suffix not in FORMATS:
                raise AdviceFileError(path, 'is of no kind that is known',
                                      f'end it in {", ".join(FORMATS)}')
            if path.suffix != '.csv' and np.isnan(result.risk).all():
                raise AdviceFileError(path, 'would hold no risk', 'write a .csv, which has growth '
                                      'rates, or build the growth emulator of the model')
            lines = _csv(result) if path.suffix == '.csv' else _c(result)
            files.add(path).partial.write_text('\n'.join([*lines, '']), encoding='ascii')


def _about(result: AdviceMap) -> Iterator[str]:
    yield NOTICE
    for name, text in result.about.items():
        yield f'{name}: {printable(text, 300)}'
    for name, axis in result.axes.items():
        yield f'axis {name}: {axis.size} values, {axis[0]:.6g} to {axis[-1]:.6g}'


def _csv(result: AdviceMap) -> Iterator[str]:
    yield from (f'# {line}' for line in _about(result))
    yield ','.join([*result.axes, 'risk', 'growth_rate_1_s'])
    values = zip(product(*(axis.tolist() for axis in result.axes.values())),
                 result.risk.ravel().tolist(), result.growth_rate.ravel().tolist(), strict=True)
    for place, risk, growth in values:
        yield ','.join([*map(_number, place), _risk(risk), _number(growth)])


def _c(result: AdviceMap) -> Iterator[str]:
    yield '/*'
    for line in (*_about(result), 'risk: squeal_risk[pressure][rotor speed][friction]; '
                 'NAN: not known, which is neither quiet nor squeal'):
        yield f' * {line.replace("*/", "* /")}'
    yield ' */'
    yield '#include <math.h>'
    for name, axis in result.axes.items():
        yield from _array(f'squeal_{name}[{axis.size}]', axis, _number)
    shape = ''.join(f'[{axis.size}]' for axis in result.axes.values())
    yield from _array(f'squeal_risk{shape}', result.risk, _risk)
    yield _LOOK_UP.format(*result.risk.shape)


def _array(declared: str, values: FloatArray, text: Callable[[float], str]) -> Iterator[str]:
    yield f'static const float {declared} = {{'
    yield from _rows(values, '    ', text)
    yield '};'


def _rows(values: FloatArray, indent: str, text: Callable[[float], str]) -> Iterator[str]:
    """Yield the elements of an array, nested as its axes are, in lines."""
    if values.ndim > 1:
        for row in values:
            yield f'{indent}{{'
            yield from _rows(row, f'{indent}  ', text)
            yield f'{indent}}},'
        return
    numbers = ['NAN,' if math.isnan(value) else f'{text(value)}f,' for value in values.tolist()]
    for start in range(0, len(numbers), _LINE):
        yield indent + ' '.join(numbers[start:start + _LINE])


def _number(value: float) -> str:
    return f'{value:.6e}'  # with a decimal point, as C wants it


def _risk(value: float) -> str:
    """Return a risk, nothing where it is not known; six digits, as floats end at 1e-38."""
    return '' if math.isnan(value) else f'{value:.6f}'


_LOOK_UP = """
static int squeal_place(const float *axis, int count, float value, float *part)
{{
    int i = 0;
    if (!(value >= axis[0] && value <= axis[count - 1])) {{
        return -1;
    }}
    while (i < count - 2 && value > axis[i + 1]) {{
        ++i;
    }}
    *part = (value - axis[i]) / (axis[i + 1] - axis[i]);
    return i;
}}

/* Risk, linear between the points of the axes; NAN: not known, or outside the axes. */
float squeal_risk_at(float pressure_pa, float rotor_speed_rad_s, float friction)
{{
    float part[3], risk = 0.0f;
    const int p = squeal_place(squeal_pressure_pa, {}, pressure_pa, &part[0]);
    const int s = squeal_place(squeal_rotor_speed_rad_s, {}, rotor_speed_rad_s, &part[1]);
    const int f = squeal_place(squeal_friction, {}, friction, &part[2]);
    int corner;
    if (p < 0 || s < 0 || f < 0) {{
        return NAN;
    }}
    for (corner = 0; corner < 8; ++corner) {{
        const int i = corner & 1, j = (corner >> 1) & 1, k = corner >> 2;
        const float weight = (i ? part[0] : 1.0f - part[0]) * (j ? part[1] : 1.0f - part[1])
                             * (k ? part[2] : 1.0f - part[2]);
        if (weight > 0.0f) {{ /* what is not known on the other side does not matter */
            risk += weight * squeal_risk[p + i][s + j][f + k];
        }}
    }}
    return risk;
}}"""

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

"""Plain scalars of YAML as ROS reads them in a parameter file: more numbers than in YAML 1.1."""

import math
import re

BOOLEANS = {**dict.fromkeys(('y', 'yes', 'true', 'on'), True),
            **dict.fromkeys(('n', 'no', 'false', 'off'), False)}
_INTEGER = re.compile(r'[+-]?(?:(0[xX][0-9a-fA-F]+)|(0[0-7]*)|[1-9][0-9]*)')
_DECIMAL = re.compile(r'[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?', re.ASCII)
_HEXADECIMAL = re.compile(r'[+-]?0[xX](?:[0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)'
                          r'(?:[pP][+-]?\d+)?', re.ASCII)
_NOT_FINITE = re.compile(r'[+-]?(?:\.(?:inf|Inf|INF)|(?i:inf|infinity|nan))|\.(?:nan|NaN|NAN)')
_LEAST = 2.0**-1022  # below, C's strtod gives a range error


def number(text: str) -> int | float | None:
    """
    Return the number that a plain scalar is, None for a text.

    As C's strtol (with base 0) and strtod, by which rcl_yaml_param_parser reads them: `1e5` and
    `inf` are numbers, `017` is octal, and `1_000`, `12:30` and what no double can hold are texts.
    """
    if match := _INTEGER.fullmatch(text):
        whole = int(text, 16 if match[1] else 8 if match[2] else 10)
        if -2**63 <= whole < 2**63:
            return whole
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace('.', ''))
    return _real(text)


def _real(text: str) -> float | None:
    try:
        if _DECIMAL.fullmatch(text):
            value = float(text)
        elif _HEXADECIMAL.fullmatch(text):
            value = float.fromhex(text)
        else:
            return None
    except OverflowError:
        return None
    is_zero = not re.search('[1-9a-fA-F]', re.split('[pP]|(?<![xX])[eE]', text)[0])
    return value if math.isfinite(value) and (abs(value) >= _LEAST or is_zero) else None

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

"""Array types, their conversion in records, and their display."""

from dataclasses import fields
import reprlib
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray: TypeAlias = NDArray[np.float64]
RealArray: TypeAlias = NDArray[np.floating[Any]]  # of single or double precision
ComplexArray: TypeAlias = NDArray[np.complex128]
IndexArray: TypeAlias = NDArray[np.intp]

_BRIEF = reprlib.Repr()
_BRIEF.maxother = _BRIEF.maxstring = 60
_BRIEF.maxtuple = _BRIEF.maxlist = 3


def readonly(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """Return a read-only copy of `values`, so that a frozen record stays frozen."""
    array = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array


def repr_with_shapes(record: Any) -> str:
    """
    Return a dataclass in one line, its arrays by shape and long values cut short.

    Use it as the `__repr__` of a record of arrays.
    """
    parts = (f'{item.name}={_short(getattr(record, item.name))}'
             for item in fields(record) if item.repr)
    return f'{type(record).__name__}({", ".join(parts)})'


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f'<{"x".join(map(str, value.shape))} {value.dtype}>'
    if isinstance(value, dict):
        return f'{{{", ".join(f"{key!r}: {_short(item)}" for key, item in value.items())}}}'
    return ' '.join(_BRIEF.repr(value).split())

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

"""
LAPACK's eigenvalues while other threads run: numpy's `eigvals` keeps all of them waiting.

The routine is the one that SciPy offers to compiled code, called as one of C's is: Python's lock
is free for as long as it takes.
"""

import ctypes
from ctypes import byref, c_char, c_int
from typing import Any

import numpy as np
from scipy.linalg import cython_lapack
from squeal_core.common.arrays import ComplexArray, FloatArray

_WORK = 64  # numbers for each row: room for the largest blocks that LAPACK would take
_NONE = c_char(b'N')  # no vectors
# prototypes of our own: those of ctypes.pythonapi are everybody's
_NAME = ctypes.PYFUNCTYPE(ctypes.c_char_p, ctypes.py_object)(
    ('PyCapsule_GetName', ctypes.pythonapi))
_POINTER = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(
    ('PyCapsule_GetPointer', ctypes.pythonapi))


def _routine(name: str, arguments: int) -> Any:
    """Return one of LAPACK's routines, given the addresses of its arguments."""
    capsule = cython_lapack.__pyx_capi__[name]
    address = _POINTER(capsule, _NAME(capsule))
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * arguments)(address)


_dgeev = _routine('dgeev', 14)


def eigvals(matrix: FloatArray) -> ComplexArray:
    """
    Return the eigenvalues of a real matrix (n, n), in no particular order.

    Raises
    ------
    numpy.linalg.LinAlgError
        Where it is not square, entries are not finite, or the iteration does not converge.

    """
    if matrix.ndim != 2 or len(matrix) != len(matrix.T):
        raise np.linalg.LinAlgError(f'a matrix of shape {matrix.shape} has no eigenvalues')
    if not np.isfinite(matrix).all():
        raise np.linalg.LinAlgError('a matrix with entries that are not finite has no eigenvalues')
    rows, leading, one, info = (c_int(i) for i in (len(matrix), max(1, len(matrix)), 1, 0))
    overwritten = np.array(matrix, dtype=float, order='F')
    real, imaginary = np.empty((2, rows.value))
    work = np.empty(max(1, _WORK * rows.value))
    _dgeev(byref(_NONE), byref(_NONE), byref(rows), overwritten.ctypes, byref(leading),
           real.ctypes, imaginary.ctypes, None, byref(one), None, byref(one),
           work.ctypes, byref(c_int(work.size)), byref(info))
    if info.value:
        raise np.linalg.LinAlgError('eigenvalues did not converge')
    roots: ComplexArray = real + 1j * imaginary
    return roots

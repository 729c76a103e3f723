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

"""Real shapes from complex ones: some programs write normal modes as complex numbers."""

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.modes.readers.raw import ReaderError

_OUT_OF_PHASE = 1e-3  # fraction of a shape that may be out of phase with the rest


def real_shape(shape: ComplexArray, where: str) -> FloatArray:
    """
    Return a complex shape whose points all move in one phase as a real one.

    Parameters
    ----------
    shape : complex array
        As the file gives it.
    where : str
        Place in the file, for the error.

    Raises
    ------
    ReaderError
        For a truly complex mode: it belongs to a damped, rotating or rubbing component.

    """
    largest = float(np.abs(shape).max(initial=0.0))
    if not 0.0 < largest < np.inf:  # refused elsewhere, with its node
        return np.asarray(shape.real)
    turned = shape * np.exp(-0.5j * np.angle(np.sum((shape / largest)**2)))
    left, size = np.linalg.norm(turned.imag), np.linalg.norm(turned)
    if left > _OUT_OF_PHASE * size:
        raise ReaderError(where, f'has a complex mode: {left / size:.2g} of its displacement is '
                          f'out of phase with the rest, more than {_OUT_OF_PHASE:g}',
                          'export real normal modes, without damping, friction and rotation')
    return np.asarray(turned.real)

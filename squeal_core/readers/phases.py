"""Real shapes from complex ones: some programs write normal modes as complex numbers."""

import numpy as np

from squeal_core.arrays import ComplexArray, FloatArray
from squeal_core.readers.raw import ReaderError

_OUT_OF_PHASE = 1e-3  # fraction of a shape that may be out of phase with the rest


def real_shape(shape: ComplexArray, where: str) -> FloatArray:
    """Return a complex shape whose points all move in one phase as a real one.

    Parameters
    ----------
    shape : complex array
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

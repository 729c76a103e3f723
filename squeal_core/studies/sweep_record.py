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

"""The record of a sweep: modes at the points of a grid."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from squeal_core.common.arrays import ComplexArray, FloatArray, readonly, repr_with_shapes
from squeal_core.common.errors import short_repr
from squeal_core.stability.eigensolution import Kind, SQUEAL_BAND
from squeal_core.stability.parameter_paths import PARAMETERS

KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True, eq=False, kw_only=True)
class Sweep:
    """
    Modes at the points of a grid; at points not done, NaN and empty texts.

    Parameters
    ----------
    axes : dict
        Values of one or two parameters; the last one runs fastest over the points.
    points : (M, 5) array
        Operating points, columns as `parameter_paths.PARAMETERS`.
    eigenvalues : (M, N) complex array
        In order of index: the eigenvalue with Im >= 0 of each mode [1/s].
    kinds : (M, N) array of str
    identities : (M, N) array of str
        As '25' or '25/26'; in a sweep that was not tracked the index.
    about : dict
        'model', 'rotation', 'friction_law', 'tracked', 'nominal_contact_stiffness',
        'damping_scale' where it is not 1.

    """

    axes: dict[str, FloatArray]
    points: FloatArray
    eigenvalues: ComplexArray
    kinds: NDArray[np.str_]
    identities: NDArray[np.str_]
    about: dict[str, Any]

    __repr__ = repr_with_shapes

    @property
    def done(self) -> NDArray[np.bool_]:
        """Return whether each point was solved, (M,)."""
        return np.asarray(self.kinds[:, 0] != '')

    @property
    def complete(self) -> bool:
        """Return whether every point was solved."""
        return bool(self.done.all())

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the numbers of values along the axes."""
        return tuple(len(values) for values in self.axes.values())

    @property
    def unstable(self) -> NDArray[np.bool_]:
        """Return whether each mode is unstable, (M, N)."""
        return np.isin(self.kinds, ('flutter', 'divergence'))

    @property
    def frequencies_hz(self) -> FloatArray:
        return np.asarray(np.abs(self.eigenvalues.imag) / (2.0 * np.pi))

    def column(self, parameter: str) -> FloatArray:
        """Return a parameter at each point, (M,)."""
        return np.asarray(self.points[:, PARAMETERS.index(parameter)])

    def largest_growth(self, low_hz: float = SQUEAL_BAND[0],
                       high_hz: float = SQUEAL_BAND[1]) -> FloatArray:
        """
        Return the largest growth rate [1/s] of the oscillating modes in a band, as the grid.

        NaN where not done, -inf where no mode is in the band.
        """
        inside = np.isin(self.kinds, ('flutter', 'stable')) & (
            self.frequencies_hz >= low_hz) & (self.frequencies_hz <= high_hz)
        growth = np.where(inside, self.eigenvalues.real, -np.inf).max(axis=1)
        return np.asarray(np.where(self.done, growth, np.nan).reshape(self.shape))

    def of(self, number: int) -> ComplexArray:
        """
        Return the eigenvalue (M,) of the mode that carries a number; NaN where it was not found.

        Of modes that merged each number gets one, the lowest number the least stable; see
        `merged`.
        """
        result = np.full(len(self.points), complex(np.nan, np.nan))
        for place, text in enumerate(self.names(number).tolist()):
            if text:
                same = self.eigenvalues[place, self.identities[place] == text]
                rank = min(text.split('/').index(str(number)), same.size - 1)
                result[place] = same[np.argsort(-same.real, kind='stable')[rank]]
        return result

    def names(self, number: int) -> NDArray[np.str_]:
        """Return the identity (M,) that holds a number, as '25' or '25/26'; '' where none does."""
        return np.array([next((text for text in dict.fromkeys(row) if str(number) in
                               text.split('/')), '') for row in self.identities.tolist()])

    def merged(self, number: int) -> NDArray[np.bool_]:
        """Return whether a mode's number is merged with others at each point, (M,)."""
        return np.char.find(self.names(number), '/') >= 0


def make_sweep(*, axes: Mapping[str, ArrayLike], points: ArrayLike, growth_rates: ArrayLike,
               angular_frequencies: ArrayLike, kinds: ArrayLike, identities: ArrayLike,
               about: dict[str, Any]) -> Sweep:
    """Return a record of arrays that fit together; ValueError where they do not."""
    grid = {name: readonly(values) for name, values in axes.items()}
    places = readonly(points)
    growth = np.asarray(growth_rates, float)
    count = int(np.prod([values.size for values in grid.values()]))
    if not 1 <= len(grid) <= 2 or not set(grid) <= set(PARAMETERS):
        raise ValueError(f'axes are {short_repr(list(grid))}')
    eigenvalues = growth + 1j * np.asarray(angular_frequencies, float)
    texts = [readonly(values, str) for values in (kinds, identities)]
    shape = eigenvalues.shape
    if (places.shape != (count, len(PARAMETERS)) or len(shape) != 2 or shape[0] != count
            or any(text.shape != shape for text in texts) or shape[1] < 1):
        raise ValueError(f'{count} points by the axes, arrays of shapes {places.shape}, '
                         f'{shape}, {texts[0].shape}, {texts[1].shape}')
    if not set(np.unique(texts[0]).tolist()) <= {*KINDS, ''}:
        raise ValueError(f'kinds are {short_repr(np.unique(texts[0]).tolist())}')
    return Sweep(axes=grid, points=places, eigenvalues=readonly(eigenvalues, complex),
                 kinds=texts[0], identities=texts[1], about=dict(about))

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

"""Columns of figures of a spectrum at the points of a grid, as arrays."""

from collections.abc import Mapping

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.stability.eigensolution import Tolerances

COLUMNS = ('growth_rate', 'frequency_hz', 'damping_ratio', 'mode', 'squeal_modes',
           'flutter_modes', 'divergent_modes', 'error', 'source')
"""Of each point: growth rate [1/s], frequency, damping ratio and number of the least stable mode
in the band; flutter modes in the band, in all; divergent ones; largest error of growth that full
solutions have found near the point [1/s]; source."""
FULL, EXPANSION, IMPOSSIBLE = 1.0, 2.0, 3.0  # sources; 0: not done
_TURN = 2.0 * np.pi


def columns_of(eigenvalues: ComplexArray, modes: int, limits: Tolerances,
               band: tuple[float, float]) -> Mapping[str, FloatArray]:
    """
    Return the figures `COLUMNS` of spectra.

    Parameters
    ----------
    eigenvalues : (P, n) complex array
        Eigenvalues in any order [1/s]; those with Im < 0 may be missing.
    modes : int
        N of the model.
    limits : Tolerances
        What counts as oscillation and growth.
    band : (2,) floats
        [Hz]

    """
    oscillating, growing = eigenvalues.imag > limits.oscillation, eigenvalues.real > limits.growth
    hertz = eigenvalues.imag / _TURN
    inside = oscillating & (hertz >= band[0]) & (hertz <= band[1])
    growth = np.where(inside, eigenvalues.real, -np.inf)
    rows, worst = np.arange(len(eigenvalues)), growth.argmax(axis=1)
    least = np.where(inside.any(axis=1), eigenvalues[rows, worst], complex(np.nan, np.nan))
    above = (oscillating & (eigenvalues.imag > least.imag[:, None])).sum(axis=1)
    still = np.abs(eigenvalues.imag) <= limits.oscillation
    return {
        'growth_rate': least.real, 'frequency_hz': least.imag / _TURN,
        'damping_ratio': -least.real / np.abs(least),
        'mode': np.where(np.isnan(least.real), np.nan, modes - above),
        'squeal_modes': (inside & growing).sum(axis=1).astype(float),
        'flutter_modes': (oscillating & growing).sum(axis=1).astype(float),
        'divergent_modes': (still & growing).sum(axis=1).astype(float)}

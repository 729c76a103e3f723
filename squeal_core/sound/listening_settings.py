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

"""Criteria of squeal in a sound, and the scale of its levels."""

from dataclasses import dataclass
import math
import re

from squeal_core.common.checks import check_number
from squeal_core.common.errors import SquealError
from squeal_core.stability.eigensolution import SQUEAL_BAND

REFERENCE_PRESSURE = 20e-6  # Pa
REFERENCE_ACCELERATION = 1e-6  # m/s^2, of ISO 1683
_GRAVITY = 9.80665  # m/s^2


@dataclass(frozen=True)
class LevelScale:
    """
    Scale from samples to levels.

    Parameters
    ----------
    quantity : str
        `full scale`, `pressure` or `acceleration`.
    at_full_scale : float
        Pa or m/s^2 at a sample of 1.0; of `full scale` it is 1.

    """

    quantity: str = 'full scale'
    at_full_scale: float = 1.0

    @property
    def offset_db(self) -> float:
        """Return the level [dB] to add to 10 lg of a mean square of samples."""
        if self.quantity == 'full scale':
            return 20.0 * math.log10(math.sqrt(2.0))  # a sine at full scale has 0 dB
        return 20.0 * math.log10(self.at_full_scale / (
            REFERENCE_PRESSURE if self.quantity == 'pressure' else REFERENCE_ACCELERATION))

    @property
    def unit(self) -> str:
        """Return the unit of levels, in words."""
        return {'full scale': 'dB(A) re a sine at full scale', 'pressure': 'dB(A) re 20 uPa',
                'acceleration': 'dB re 1 um/s^2'}[self.quantity]

    @property
    def is_weighted(self) -> bool:
        """Return whether levels are A-weighted."""
        return self.quantity != 'acceleration'

    @property
    def usual_threshold(self) -> float:
        """Level from which on a tone is an event [dB]: 70 dB(A) as in SAE J2521; 1 m/s^2."""
        return {'full scale': -70.0, 'pressure': 70.0, 'acceleration': 120.0}[self.quantity]

    @property
    def least_background(self) -> float:
        """Level that any recording of a moving vehicle reaches; below, nothing was heard [dB]."""
        return {'full scale': -90.0, 'pressure': 15.0, 'acceleration': 60.0}[self.quantity]

    @classmethod
    def parse(cls, text: str) -> 'LevelScale':
        """
        Return the scale that a calibration gives: `2.5Pa`, `124dB`, `50g`, `490m/s2`.

        Raises
        ------
        SquealError
            For anything else.

        """
        parts = re.fullmatch(r'([-+.\deE]+)\s*(Pa|dB|m/s2|m/s\^2|g)', text.strip())
        try:
            value = float(parts[1]) if parts else math.nan
        except ValueError:
            value = math.nan
        if not (parts and math.isfinite(value) and (value > 0.0 or parts[2] == 'dB')
                and abs(value) < 1e6):
            raise SquealError(
                f'--calibration: is {text!r}; give what a sample of full scale is, as 2.5Pa, '
                '490m/s2 or 50g, or the sound pressure level of a sine that reaches it, as 124dB')
        if parts[2] == 'dB':
            return cls('pressure', math.sqrt(2.0) * REFERENCE_PRESSURE * 10.0 ** (0.05 * value))
        if parts[2] == 'Pa':
            return cls('pressure', value)
        return cls('acceleration', value * (_GRAVITY if parts[2] == 'g' else 1.0))


@dataclass(frozen=True)
class ListeningSettings:
    """
    Criteria of squeal.

    Parameters
    ----------
    band : (float, float)
        Of its frequency [Hz].
    prominence : float
        Over the spectral neighbourhood [dB].
    threshold : float
        Its level at the loudest [dB]; NaN: the usual one of the scale.
    shortest : float
        Its duration [s].
    scale : LevelScale
        Of the samples.

    """

    band: tuple[float, float] = SQUEAL_BAND
    prominence: float = 15.0
    threshold: float = math.nan
    shortest: float = 0.1
    scale: LevelScale = LevelScale()

    def __post_init__(self) -> None:
        check_number('--band: LOW', self.band[0], least=500.0, most=100e3)
        check_number('--band: HIGH', self.band[1], above=self.band[0], most=100e3)
        check_number('--prominence', self.prominence, least=10.0, most=60.0)
        check_number('--shortest', self.shortest, least=0.05, most=60.0)
        if math.isnan(self.threshold):
            object.__setattr__(self, 'threshold', self.scale.usual_threshold)
        check_number('--threshold', self.threshold, least=-200.0, most=300.0)

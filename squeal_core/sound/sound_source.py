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

"""A sound file that can be read block by block, whatever its format."""

from collections.abc import Iterator
from dataclasses import dataclass, field
import hashlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.bounded_reader import open_bounded
from squeal_core.sound.sound_errors import SoundError
from squeal_core.sound.wav_header import ClockTime

MAX_BYTES = 1_000_000_000_000

Samples = NDArray[np.float32]


@dataclass(frozen=True)
class SoundFile:
    """
    A sound file that can be read.

    Parameters
    ----------
    path : Path
    rate, channels, frames : int
        Samples a second, channels, samples of each.
    coding : str
        In words, as `24 bit`.
    step : float
        Between two neighbouring values, of full scale; 0 for floats.
    started : ClockTime, optional
        When it starts, where the file says it.
    notes : list of str
        What is wrong with the file; reading may add to it.

    """

    path: Path
    rate: int
    channels: int
    frames: int
    coding: str
    step: float
    started: ClockTime | None = None
    notes: list[str] = field(default_factory=list)

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.frames / self.rate

    def blocks(self, frames: int) -> Iterator[Samples]:
        """Yield samples (n, channels) of full scale 1, at most so many of each channel."""
        raise NotImplementedError

    def sha256(self) -> str:
        """Return the hash of the file."""
        with open_bounded(self.path, MAX_BYTES, SoundError) as file:
            digest = hashlib.sha256()
            while data := file.read(1 << 20):
                digest.update(data)
            return digest.hexdigest()

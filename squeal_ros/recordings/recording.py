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

"""Interface of a recording of any format for a replay."""

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from squeal_core.common.errors import LocatedError
from squeal_core.monitor.inputs.reading import MissingValue, Sample
from squeal_core.monitor.setting_specs import Signal
from squeal_ros.recordings.findings import Finding
from squeal_ros.recordings.positions import Positions

Samples = list[tuple[str, Signal, Sample | MissingValue]]
"""Brake, signal and sample of all that a message or a row holds."""


class RecordingError(LocatedError):
    """A recording that is not there, or of no format that is read."""


class Recording(Protocol):
    """Samples of the inputs of settings, in order of recording, and notes on them."""

    @property
    def path(self) -> Path:
        """Return the file or folder."""

    @property
    def kind(self) -> str:
        """Return 'rosbag2', 'rosbag1', 'csv' or 'mdf'."""

    @property
    def notes(self) -> list[str]:
        """Return notes on the recording, as far as it was read."""

    @property
    def findings(self) -> list[Finding]:
        """Return the findings on the recording and the settings, as far as it was read."""

    @property
    def messages(self) -> int:
        """Return the number of messages or rows to be read, or an estimate."""

    @property
    def positions(self) -> Positions:
        """Return the positions of the vehicle, as far as the recording was read."""

    def samples(self) -> Iterator[tuple[int, Samples]]:
        """
        Yield the time of recording [ns] and the samples of each message.

        Raises
        ------
        SquealError
            For a recording that cannot be read, or holds none of the inputs.

        """

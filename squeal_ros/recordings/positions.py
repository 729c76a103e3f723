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

"""Positions of the vehicle by the fixes of a recording."""

from array import array
import bisect
from collections.abc import Sequence
import math

from squeal_core.common.errors import short_repr

FIX_TYPE = 'sensor_msgs/msg/NavSatFix'

_NO_FIX = 0  # a smaller status of NavSatStatus
_LONGEST_AGE = 5_000_000_000  # ns; a car moves 150 m meanwhile


class Positions:
    """
    Positions over the time of recording; empty where the recording has no fix.

    They are taken as the recording is read, and known up to where it was read.
    """

    def __init__(self) -> None:
        self._times, self._latitudes, self._longitudes = array('q'), array('d'), array('d')

    def __len__(self) -> int:
        return len(self._times)

    def missing(self, names: Sequence[str]) -> list[str]:
        """Return a note where columns that are named gave no position."""
        return [] if len(self) or not names else [
            f'position: {" and ".join(map(short_repr, names))} have no row with numbers of both, '
            'so none is known; check columns and units']

    def take(self, time: int, latitude: float, longitude: float, status: int = 0) -> None:
        """
        Take a fix; one without a position, at 0, 0, or before the last one, is passed over.

        Parameters
        ----------
        time : int
            Of recording [ns].
        latitude, longitude : float
            [deg].
        status : int
            As of sensor_msgs/NavSatStatus; negative: no fix.

        """
        known = (status >= _NO_FIX and abs(latitude) <= 90.0 and abs(longitude) <= 360.0
                 and not latitude == longitude == 0.0)  # as receivers write before a fix
        if known and not (self._times and time < self._times[-1]):
            self._times.append(time)
            self._latitudes.append(latitude)
            self._longitudes.append(longitude)

    def at(self, time: int) -> tuple[float, float]:
        """
        Return latitude and longitude [deg] at a time [ns]; NaN where they are not known.

        Between two fixes they are interpolated, after the last one it holds; for 5 s at most.
        """
        after = bisect.bisect_right(self._times, time)
        if not after or time - self._times[after - 1] > _LONGEST_AGE:
            return math.nan, math.nan
        last = self._latitudes[after - 1], self._longitudes[after - 1]
        if after == len(self) or self._times[after] - self._times[after - 1] > _LONGEST_AGE:
            return last
        north, east = self._latitudes[after] - last[0], self._longitudes[after] - last[1]
        if abs(east) > 180.0:  # over the date line
            return last
        part = (time - self._times[after - 1]) / (self._times[after] - self._times[after - 1])
        return last[0] + part * north, last[1] + part * east

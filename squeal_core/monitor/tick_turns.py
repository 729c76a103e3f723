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

"""Ticks at which periodic work is due, for several brakes in turn."""


def is_due(time: int, period: int, interval: int, place: int = 0, count: int = 1) -> bool:
    """
    Return whether a tick is the first one in an interval of absolute time.

    Whatever the ticks before, so that the same things are due in a replay of any part of a drive.

    Parameters
    ----------
    time : int
        The tick [ns].
    period : int
        Between ticks [ns].
    interval : int
        From one time to the next [ns]; 0: never.
    place, count : int
        Which of so many, whose intervals begin one after the other; by default one alone.

    """
    if not interval:
        return False
    shifted = time + place * interval // count
    return shifted // interval != (shifted - period) // interval

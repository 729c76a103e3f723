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

"""Detection of silent input topics: pure, of counts and steady times handed in [ns]."""

from collections.abc import Mapping

FIRST = 5_000_000_000  # ns of silence after which it is said
AGAIN = 60_000_000_000  # ns until it is said again


class Silence:
    """
    Tells when to log topics that never brought a message, and inputs that all fell silent.

    A single topic that brought messages and stops is no matter of this: it may be published only
    while the brake is applied, and the state of its brake says what is missing.
    """

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Count anew from the next call of `due`."""
        self._heard: int | None = None  # total of messages
        self._since = self._next = 0

    def due(self, counts: Mapping[str, int], steady: int) -> tuple[str, ...]:
        """
        Return the topics to log now, mostly none.

        Parameters
        ----------
        counts : mapping
            Messages received of each topic.
        steady : int
            Steady time [ns].

        """
        total = sum(counts.values())
        if self._heard is None:
            self._heard, self._since, self._next = total, steady, steady + FIRST
        if total != self._heard:
            self._heard, self._since = total, steady
        if steady < self._next:
            return ()
        silent = tuple(counts) if steady - self._since >= FIRST else tuple(
            topic for topic, count in counts.items() if count == 0)
        if silent:
            self._next = steady + AGAIN
        return silent

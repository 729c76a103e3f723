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

"""Shared state of a batch's processes: the request to stop, the progress of each recording."""

from collections.abc import Sequence
import multiprocessing


class BatchProgress:
    """
    Progress of a batch of recordings, in memory that its worker processes share.

    Parameters
    ----------
    sizes : sequence of int
        Of the recordings [bytes], by which their parts weigh.

    """

    def __init__(self, sizes: Sequence[int]) -> None:
        context = multiprocessing.get_context('spawn')
        self.sizes = tuple(sizes)
        # no locks: a signal handler that waits for one would wait for ever
        self._stop = context.RawValue('b', 0)
        self._parts = context.RawArray('d', len(self.sizes))

    def stop(self) -> None:
        """Make every process end its present recording, and begin no other."""
        self._stop.value = 1

    @property
    def stopping(self) -> bool:
        """Return whether a stop was requested."""
        return bool(self._stop.value)

    def set_part(self, place: int, part: float) -> None:
        """Set the fraction of a recording that is done, 0 to 1."""
        self._parts[place] = min(part, 1.0)

    @property
    def done(self) -> float:
        """Return the size of the finished recordings and parts [bytes]."""
        return float(sum(part * size for part, size in zip(
            self._parts, self.sizes, strict=True)))

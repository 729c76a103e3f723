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

"""Brake applications of a replay, grouped where measured squeal cannot distinguish them."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any, Protocol

from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.history_columns import HistoryBlock
from squeal_core.monitor.results.squeal_events import SquealEvent


class Predictions(Protocol):
    """Predictions of a replay for one recording; `ReplayResult` is one."""

    @property
    def name(self) -> str: ...

    @property
    def summary(self) -> Mapping[str, Any]: ...

    @property
    def events(self) -> Sequence[SquealEvent]: ...

    @property
    def applications(self) -> Sequence[ApplicationRecord]: ...

    def blocks(self, columns: Sequence[str]) -> Iterator[HistoryBlock]: ...


@dataclass(frozen=True)
class Braking:
    """
    Brakes applied together, which measured squeal cannot distinguish; or a single one.

    Parameters
    ----------
    recording : str
    applications : tuple of ApplicationRecord
        Of different brakes, at times that overlap.

    """

    recording: str
    applications: tuple[ApplicationRecord, ...]

    @property
    def brakes(self) -> tuple[str, ...]:
        """Return the brakes that were applied."""
        return tuple(dict.fromkeys(one.brake for one in self.applications))

    @property
    def start(self) -> float:
        """Return the start of the first application [s]."""
        return min(one.start_s for one in self.applications)

    @property
    def end(self) -> float:
        """Return the end of the last application [s]."""
        return max(one.end_s for one in self.applications)

    @property
    def alarm(self) -> bool | None:
        """Return whether some brake's alarm was up; None: of none known, of some not known."""
        alarms = [one.alarm for one in self.applications]
        return True if True in alarms else None if None in alarms else False

    @property
    def worst(self) -> ApplicationRecord:
        """Return the application with the largest risk that is known."""
        return max(self.applications, key=lambda one: (
            -1.0 if math.isnan(one.peak_risk) else one.peak_risk))

    @property
    def risk(self) -> float:
        """Largest squeal risk of these brakes; NaN: not known."""
        return self.worst.peak_risk


def groups_of(brakes: Sequence[str], places: Mapping[str, Sequence[str]],
              named: Iterable[str]) -> tuple[tuple[str, ...], ...]:
    """
    Return the groups of brakes that events distinguish: those of one place are one group.

    Parameters
    ----------
    brakes : sequence of str
        Names of all.
    places : mapping
        Brakes of each place.
    named : iterable of str
        Places of the events; empty: not known, so any brake.

    """
    group = {brake: {brake} for brake in brakes}
    for place in dict.fromkeys(named):
        joined = set().union(*(group[brake] for brake in (places[place] if place else brakes)))
        for brake in joined:
            group[brake] = joined
    return tuple(dict.fromkeys(
        tuple(brake for brake in brakes if brake in group[one]) for one in brakes))


def brakings_of(result: Predictions, group: Collection[str]) -> list[Braking]:
    """Return the applications of some brakes, those at overlapping times together."""
    own = sorted((one for one in result.applications if one.brake in group),
                 key=lambda one: one.start_s)
    found: list[list[ApplicationRecord]] = []
    end = -math.inf
    for one in own:
        if one.start_s > end:
            found.append([])
            end = -math.inf
        found[-1].append(one)
        end = max(end, one.end_s)
    return [Braking(result.name, tuple(some)) for some in found]

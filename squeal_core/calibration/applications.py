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

"""Brake applications and the observations of squeal in them."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math

import numpy as np
from numpy.typing import NDArray
from squeal_core.calibration.events import AFTER, EventFileError, MeasuredEvent
from squeal_core.common.arrays import FloatArray, IndexArray, readonly, repr_with_shapes
from squeal_core.common.errors import SquealError

_LEAST_KNOWN = 0.8  # fraction of the ticks of an application that can be an observation
_SAME_PITCH = 0.05  # relative difference within which two events at once are one sound


@dataclass(frozen=True, eq=False)
class BrakeApplication:
    """
    One brake from the moment it slides under load until it is released.

    Parameters
    ----------
    brake, recording : str
    time : (T,) array
        Rising, on the recording's clock [s].
    rotor_speed, contact_pressure, friction : (T,) arrays
        [rad/s], p0 [Pa], [-]; NaN at ticks at which one of them is not known.
    temperature : (T,) array
        [K]; NaN where not known.

    """

    brake: str
    recording: str
    time: FloatArray
    rotor_speed: FloatArray
    contact_pressure: FloatArray
    friction: FloatArray
    temperature: FloatArray = field(default_factory=lambda: np.zeros(0))

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        size = np.size(self.time)
        if not np.size(self.temperature):
            object.__setattr__(self, 'temperature', np.full(size, math.nan))
        for name in ('time', 'rotor_speed', 'contact_pressure', 'friction', 'temperature'):
            values = readonly(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.shape != (size,):
                raise SquealError(f'{name}: shape {values.shape}; give one value at each of '
                                  f'{size} times')
        if not size or not np.all(np.diff(self.time) > 0.0):
            raise SquealError(f'time: {size} values; give at least one, rising')

    @property
    def known(self) -> NDArray[np.bool_]:
        """Mask (T,) of the ticks at which the brake's state is known."""
        return np.asarray(np.isfinite(
            self.rotor_speed + self.contact_pressure + self.friction))

    @property
    def is_observation(self) -> bool:
        """Return whether enough ticks are known for silence to be an observation."""
        return bool(self.known.sum() >= max(2.0, _LEAST_KNOWN * self.time.size))

    def knots(self, step: float) -> tuple[IndexArray, FloatArray]:
        """
        Return ticks at which growth is evaluated, and the time from the one before to each [s].

        Ends of unbroken runs of known ticks, and ticks about `step` [s] apart in between; over
        a gap nothing builds up, so its time is zero. Sliding begins and ends half a tick before
        the first and after the last, as online.
        """
        ticks = np.flatnonzero(self.known)
        runs = np.split(ticks, np.flatnonzero(np.diff(ticks) > 1) + 1)
        chosen, times = [], []
        for run in runs:
            span = self.time[run[-1]] - self.time[run[0]] if run.size else 0.0
            count = min(run.size, max(5, math.ceil(span / step) + 1))
            kept = run[np.unique(np.linspace(0, run.size - 1, count).round().astype(int))]
            chosen.append(kept)
            times.append(np.diff(self.time[kept], prepend=self.time[kept[:1]]))
        ticks, duration = np.concatenate(chosen), np.concatenate(times)
        half = 0.5 * float(np.diff(self.time).min(initial=step))
        if ticks[0] == 0:
            duration[0] = half
        if ticks[-1] == self.time.size - 1:
            ticks, duration = np.append(ticks, ticks[-1]), np.append(duration, half)
        return ticks, duration


def inputs_of(applications: Sequence[BrakeApplication]) -> FloatArray:
    """
    Return the inputs of a regression or a table for applications, (A, 5).

    ln of mean pressure and speed, temperature (friction where there is none in any), friction,
    ln duration.
    """
    known = [(one, one.known) for one in applications]
    temperature = np.array([_mean(one.temperature) for one in applications])
    friction = np.array([one.friction[mask].mean() for one, mask in known])
    if np.isnan(temperature).any():
        temperature = friction
    return np.column_stack([
        [np.log(one.contact_pressure[mask].mean()) for one, mask in known],
        [np.log(np.abs(one.rotor_speed[mask]).mean()) for one, mask in known],
        temperature, friction,
        [np.log(np.ptp(one.time) + 0.1) for one in applications]])


def _mean(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else math.nan


@dataclass(frozen=True)
class Observation:
    """
    Observation of a brake application: squeal or silence.

    Parameters
    ----------
    applications : tuple of int
        Those of which one at least squealed; a single one where the brake is known, or silent.
    heard : bool
    frequency_hz : float
        Of the first event; NaN where not known.

    """

    applications: tuple[int, ...]
    heard: bool
    frequency_hz: float = math.nan


@dataclass(frozen=True)
class MatchedEvents:
    """
    Observations of all applications, and the events and applications left out.

    Parameters
    ----------
    observations : tuple of Observation
    unmatched : tuple of MeasuredEvent
        In no application of their brake.
    incomplete : int
        Applications of which too little is known.

    """

    observations: tuple[Observation, ...]
    unmatched: tuple[MeasuredEvent, ...]
    incomplete: int

    @property
    def heard(self) -> int:
        """Return the number of observations with squeal."""
        return sum(one.heard for one in self.observations)


def match_events(applications: Sequence[BrakeApplication], events: Sequence[MeasuredEvent],
                 places: Mapping[str, Sequence[str]], *,
                 zero: Mapping[str, float] | None = None) -> MatchedEvents:
    """
    Return the observations of all applications; one without an event was silent.

    Parameters
    ----------
    applications : sequence of BrakeApplication
        Those that somebody listened to.
    events : sequence of MeasuredEvent
        Of these applications.
    places : mapping
        Brakes of each name that an event may have.
    zero : mapping, optional
        Of each recording: where times of the events count from [s]; zero where None.

    Raises
    ------
    EventFileError
        For an event that may be of several recordings, or of none of that name.

    """
    by_brake: defaultdict[str, list[int]] = defaultdict(list)
    for i, one in enumerate(applications):
        by_brake[one.brake].append(i)
    recordings = {one.recording for one in applications}
    own: dict[int, MeasuredEvent] = {}
    shared: dict[tuple[int, ...], MeasuredEvent] = {}
    unmatched = []
    for event in sorted(events, key=lambda event: event.time):
        if event.recording and event.recording not in recordings:
            raise EventFileError(f'events, line {event.line}', f'recording is {event.recording!r}',
                                 f'give one of {", ".join(sorted(recordings))}')
        result = tuple(i for brake in (places[event.place] if event.place else by_brake)
                       for i in _of_brake(event, applications, by_brake[brake], zero or {}))
        if len({applications[i].recording for i in result}) > 1:
            raise EventFileError(
                f'events, line {event.line}', f'time_s {event.time:g} is of '
                f'{" and ".join(sorted({applications[i].recording for i in result}))}',
                'name the recording in a column `recording`')
        if not result:
            unmatched.append(event)
        elif len(result) == 1:
            own.setdefault(result[0], event)
        else:
            shared.setdefault(result, event)
    return _observed(applications, own, shared, tuple(unmatched))


def _of_brake(event: MeasuredEvent, applications: Sequence[BrakeApplication],
              places: Sequence[int], zero: Mapping[str, float]) -> list[int]:
    """Return the application of a brake, of each recording, that an event is in."""
    result: dict[str, int] = {}
    for i in places:
        one = applications[i]
        time = event.time + zero.get(one.recording, 0.0)
        if event.recording in ('', one.recording) \
                and one.time[0] <= time <= one.time[-1] + AFTER:
            result[one.recording] = i  # the later one, where the one before has just ended
    return list(result.values())


def _observed(applications: Sequence[BrakeApplication], own: Mapping[int, MeasuredEvent],
              shared: Mapping[tuple[int, ...], MeasuredEvent],
              unmatched: tuple[MeasuredEvent, ...]) -> MatchedEvents:
    usable = [one.is_observation for one in applications]
    result = [Observation((i,), True, event.frequency_hz) for i, event in own.items() if usable[i]]
    open_to_doubt: set[int] = set()
    for places, event in shared.items():
        if any(i in own and _alike(own[i], event) for i in places):
            continue  # the same sound, heard once more
        rest = tuple(i for i in places if i not in own and usable[i])
        if rest:
            result.append(Observation(rest, True, event.frequency_hz))
            open_to_doubt.update(rest)
    result += [Observation((i,), False) for i in range(len(applications))
               if usable[i] and i not in own and i not in open_to_doubt]
    return MatchedEvents(tuple(sorted(result, key=lambda one: one.applications)), unmatched,
                         usable.count(False))


def _alike(one: MeasuredEvent, other: MeasuredEvent) -> bool:
    return not abs(one.frequency_hz / other.frequency_hz - 1.0) > _SAME_PITCH  # or NaN

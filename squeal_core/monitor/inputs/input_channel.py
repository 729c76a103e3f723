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

"""One input of one brake: its samples, and the reading of the newest of them at a tick."""

import bisect
from collections import Counter
import math
from typing import NamedTuple

from squeal_core.monitor.brake_settings import InputSettings
from squeal_core.monitor.inputs.plausibility import unit_guards
from squeal_core.monitor.inputs.publishers import PublisherGuard
from squeal_core.monitor.inputs.reading import (
    MissingValue,
    Reading,
    Sample,
    Status,
    ValidatedRange,
)
from squeal_core.monitor.inputs.stuck_signal import StuckCheck
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings

_GOOD: tuple[Status, str] = 'good', ''
# samples kept of an input: between two ticks, and stamped ahead of them
_KEPT = 4096
# settings of which the guards are made, besides those of the input
_OF_GUARDS = ('bar_suspected_below', 'reference_check', 'publisher_tolerance',
              'wheel_acceleration_peak', 'wheel_acceleration_mean', 'stuck_changes')


class _CheckedSample(NamedTuple):
    """A sample, and its status by the history of its input."""

    stamp: int
    value: float
    status: Status
    detail: str


class InputChannel:
    """
    Keeps the samples of one input that ticks to come may need.

    Parameters
    ----------
    signal : str
    limits : InputSettings
    settings : MonitorSettings
    validated : ValidatedRange

    Attributes
    ----------
    changes : int
        How often the value has changed.

    """

    def __init__(self, signal: Signal, limits: InputSettings, settings: MonitorSettings,
                 validated: ValidatedRange) -> None:
        self.signal = signal
        self.refused: Counter[str] = Counter()
        self._tick: int | None = None
        self._guarded: object = None
        self.update_settings(limits, settings, validated)
        self.forget()

    def update_settings(self, limits: InputSettings, settings: MonitorSettings,
                        validated: ValidatedRange) -> None:
        """Apply other settings; samples stay, and guards whose settings change begin anew."""
        self._limits, self._settings, self._validated = limits, settings, validated
        self._max_age = round(limits.max_age * 1e9)
        self._ahead = settings.period + round(settings.stamp_tolerance * 1e9)
        guarded = limits, tuple(getattr(settings, name) for name in _OF_GUARDS)
        if guarded != self._guarded:
            self._guarded = guarded
            self._begin()

    def _begin(self) -> None:
        """Reset the plausibility checks."""
        limits, settings = self._limits, self._settings
        self._guards = unit_guards(self.signal, limits, settings)
        self._publishers = PublisherGuard(self.signal, settings.publisher_tolerance,
                                          limits.max_age)
        self.changes = 0
        self._stuck = StuckCheck(limits.stuck_after, round(settings.stuck_changes),
                                 limits.max_age, limits.movement)

    def forget(self) -> None:
        """Discard all samples, as if they had never come."""
        self._samples: list[_CheckedSample] = []
        self._went_back = False
        self._refusal: tuple[int, Reading] | None = None
        self._unstamped: Sample | None = None  # the last sample, if it had no stamp
        self._unreadable = ''  # why the last message held no sample
        self._begin()

    def receive(self, sample: Sample, *, sliding: bool, others: int) -> None:
        """
        Take a sample; a late one finds its place by its stamp, one without is refused.

        Parameters
        ----------
        sample : Sample
            The newest one.
        sliding : bool
            Whether the disc slides under load by what was received last.
        others : int
            Changes of the brake's other inputs.

        """
        self._unreadable = ''
        if sample.stamp <= 0:
            self.refused['without a stamp'] += 1
            self._unstamped = sample
            return
        self._unstamped = None
        samples = self._samples
        status, detail = self._history(sample, sliding, others)
        checked = _CheckedSample(sample.stamp, sample.value, status, detail)
        if not samples or sample.stamp >= samples[-1].stamp:
            samples.append(checked)
        else:
            samples.insert(bisect.bisect_right(samples, sample.stamp, key=_stamp), checked)
        if len(samples) > _KEPT:
            self._drop_one()

    def record_missing(self, instead: MissingValue) -> None:
        """Record a message that held no sample."""
        if not instead.is_other:
            self.refused['unreadable'] += 1
        self._unreadable = instead.reason

    def _history(self, sample: Sample, sliding: bool, others: int) -> tuple[Status, str]:
        """Check a sample against the history of its input."""
        stamp, value, number, connection = sample
        contradiction = self._publishers.check(
            stamp, value, number=number, connection=connection) if number or connection else ''
        if not math.isfinite(value):
            # the reading reports the value itself
            return ('contradicted', contradiction) if contradiction else _GOOD
        detail = ''
        for guard in self._guards:  # each sees every sample
            said = guard.check(stamp, value)
            detail = detail or said
        if contradiction:
            return 'contradicted', contradiction
        if detail:
            return 'invalid', detail
        if not self._limits.minimum <= value <= self._limits.maximum:
            return _GOOD
        detail = self._stuck.check(stamp, value, sliding=sliding, others=others)
        self.changes = self._stuck.changes
        return ('stuck', detail) if detail else _GOOD

    def _drop_one(self) -> None:
        """Discard one sample: one that the next tick will refuse, else the oldest."""
        if self._tick is not None and self._samples[-1].stamp > self._tick + self._ahead:
            self._refuse_last(self._tick)
        else:
            del self._samples[0]

    def go_back(self, time: int) -> None:
        """Discard samples stamped after a time [ns] to which the clock was set back."""
        del self._samples[bisect.bisect_right(self._samples, time, key=_stamp):]
        self._went_back, self._refusal, self._tick = True, None, time
        self._begin()

    def read(self, time: int) -> Reading:
        """Return the reading at a tick [ns]; later ticks need no older samples."""
        self._tick, samples = time, self._samples
        while samples and samples[-1].stamp > time + self._ahead:
            self._refuse_last(time)
        past = len(samples) if samples and samples[-1].stamp <= time else bisect.bisect_right(
            samples, time, key=_stamp)
        if past > 1:
            del samples[:past - 1]  # the newest of the past stays, and what is ahead
        newest = samples[0] if past else None
        if newest is None or time - newest.stamp > self._max_age:
            return self._missing(newest, time)
        self._went_back, self._refusal = False, None
        return self._reading(newest, (time - newest.stamp) * 1e-9)

    def _refuse_last(self, time: int) -> None:
        sample = self._samples.pop()
        self.refused['stamped ahead'] += 1
        ahead = (sample.stamp - time) * 1e-9
        self._refusal = time, Reading('invalid', sample.value, -ahead,
                                      f'stamped ahead of time by {ahead:.2f} s')

    def _missing(self, newest: _CheckedSample | None, time: int) -> Reading:
        """Return the reading where there is no fresh sample, with the reason."""
        if self._refusal is not None and 0 <= time - self._refusal[0] <= self._max_age:
            return self._refusal[1]
        if self._unstamped is not None:
            return Reading('invalid', self._unstamped.value, detail=_no_stamp(self._unstamped))
        if newest is None and self._went_back:
            return Reading('time went backwards', detail='not received since time went backwards')
        without = self._unreadable and f'messages come without it ({self._unreadable})'
        if newest is None:
            return Reading('never received',
                           detail=without and f'never received, {without}')
        age = (time - newest.stamp) * 1e-9
        if self._went_back:
            return Reading('time went backwards', newest.value, age, 'and time went backwards')
        return Reading('stale', newest.value, age, without)

    def _reading(self, sample: _CheckedSample, age: float) -> Reading:
        """Return the reading of a fresh sample: checks of its value, then of its history."""
        value, limits = sample.value, self._limits
        if sample.status == 'contradicted':
            return Reading('contradicted', value, age, sample.detail)
        if not limits.minimum <= value <= limits.maximum:
            detail = f'outside its range {limits.minimum:.6g} to {limits.maximum:.6g}'
            hint = f': {sample.detail}' if sample.detail else ''
            return Reading('invalid', value, age, detail + hint)
        if sample.status != 'good':
            return Reading(sample.status, value, age, sample.detail)
        if not self._validated.admits(value):
            return Reading('outside validated range', value, age, str(self._validated))
        return Reading('good', value, age)


def _no_stamp(sample: Sample) -> str:
    return 'without a stamp (zero)' if not sample.stamp else (
        f'with a stamp before all time ({sample.stamp * 1e-9:.2f} s)')


def _stamp(sample: _CheckedSample) -> int:
    return sample.stamp

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

"""
Checks across the inputs and brakes of a vehicle: plausible readings that others contradict.

Only the quiet side is doubted: a brake that reads released, or less than its axle partner, while
the vehicle brakes; a wheel that reads at rest, or turns unlike the others; a friction below the
others'. An axle whose brakes agree is believed, and so is a brake that alone reads pressure.

Evidence is gathered in steps of 50 ms of the stamps, not in ticks, so it hardly depends on the
rate of assessments. A doubt ends when the input is seen to agree again, not when others rest.
"""

from collections.abc import Mapping, Sequence
import math

from squeal_core.monitor.axles import axle_partners, axle_shares, in_words
from squeal_core.monitor.inputs.cross_evidence import Contradiction, Wheel
from squeal_core.monitor.inputs.cross_friction import against_friction
from squeal_core.monitor.inputs.cross_motion import Motion, motion_of
from squeal_core.monitor.inputs.cross_pressure import (
    against_all_pressures,
    against_pressure,
    against_slew,
    learn_share,
    pressure_agrees,
)
from squeal_core.monitor.inputs.cross_speed import against_speed
from squeal_core.monitor.inputs.reading import Reading, Sample
from squeal_core.monitor.inputs.signal_windows import STEP
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings

_LONGEST_GAP = 5_000_000_000  # ns between ticks; what was gathered before counts no longer

__all__ = ['CrossChecks']


class CrossChecks:
    """
    Compares all brakes of a vehicle and marks readings that others contradict.

    Parameters
    ----------
    settings : MonitorSettings

    """

    def __init__(self, settings: MonitorSettings) -> None:
        self._wheels = {brake.name: Wheel(brake) for brake in settings.brakes}
        self._all = tuple(self._wheels.values())
        self.update_settings(settings)
        self.reset()

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings of the same brakes; what was gathered stays."""
        self._settings = settings
        self.partners = axle_partners(tuple(self._wheels), settings.axles)
        order = list(self._wheels)
        shares = axle_shares(order, self.partners, settings.rear_pressure_share)
        for brake in settings.brakes:
            wheel = self._wheels[brake.name]
            other = self.partners.get(brake.name, brake.name)
            wheel.is_first = order.index(brake.name) <= order.index(other)
            wheel.update_settings(brake)
            wheel.partner = self._wheels.get(self.partners.get(brake.name, ''))
            wheel.others = [other for other in self._wheels.values()
                            if other is not wheel and other is not wheel.partner]
            wheel.given_share = shares.get(brake.name, 0.0)
            wheel.share = wheel.given_share or wheel.share
            _drop_what_is_off(wheel, settings)

    def reset(self) -> None:
        """Discard all samples and doubts."""
        for wheel in self._wheels.values():
            wheel.forget()
        self._end: int | None = None  # of the last step [ns]
        self._tick: int | None = None

    @property
    def summary(self) -> str:
        """Return the axles, or why nothing can be compared."""
        if len(self._wheels) == 1:
            return 'one brake: it cannot be checked against others'
        return f'axles: {in_words(self.partners)}'

    def receive(self, brake: str, signal: Signal, sample: Sample) -> None:
        """Take a sample as its input does."""
        window = self._wheels[brake].windows.get(signal)
        if window is not None:
            window.receive(sample.stamp, sample.value)

    def check(self, time: int, readings: Sequence[Mapping[Signal, Reading]]
              ) -> list[Mapping[Signal, Reading]]:
        """Return the readings of all brakes at a tick [ns]; those in doubt are 'implausible'."""
        if self._tick is not None and time < self._tick:
            for wheel in self._wheels.values():
                wheel.forget(after=time)
            self._end = None
        self._tick, last = time, time // STEP * STEP
        if last != self._end:
            for wheel, inputs in zip(self._all, readings, strict=True):
                wheel.use(inputs)
            self._advance(last)
        return [_marked(wheel, inputs) if wheel.has_doubts else inputs
                for wheel, inputs in zip(self._all, readings, strict=True)]

    def _advance(self, last: int) -> None:
        """Process all steps after those of the last tick, up to the end of one [ns]."""
        if self._end is None or last - self._end > _LONGEST_GAP:
            for wheel in self._wheels.values():
                wheel.begin_anew()
            self._end = last - STEP
        for end in range(self._end + STEP, last + 1, STEP):
            self._step(end)
        self._end = last

    def _step(self, end: int) -> None:
        wheels, settings = self._all, self._settings
        for wheel in wheels:
            wheel.advance(end)
            leaps, steady = against_slew(wheel, end, settings)
            wheel.alternation.weigh(leaps, agrees=steady)
        motion = motion_of(wheels, end)
        if motion.fastest >= settings.minimum_rotor_speed:
            unexplained = [*against_all_pressures(wheels, motion, settings)]
            for wheel in wheels:
                self._compare(wheel, unexplained, motion, end)
        else:
            for wheel in wheels:
                _pause(wheel, agrees=pressure_agrees(wheel, wheels, settings))

    def _compare(self, wheel: Wheel, unexplained: Sequence[Contradiction], motion: Motion,
                 end: int) -> None:
        settings = self._settings
        learn_share(wheel, motion)
        result = against_pressure(wheel, motion, end, settings)
        if not math.isnan(wheel.own['pressure'].mean):
            result += unexplained
        wheel.doubts['pressure'].weigh(
            result, agrees=pressure_agrees(wheel, self._all, settings))
        slow_or_fast, agrees = against_speed(wheel, motion, settings)
        wheel.doubts['rotor_speed'].weigh(slow_or_fast, agrees=agrees)
        if (friction := wheel.doubts.get('friction')) is not None:
            result, compared = against_friction(wheel, settings)
            if compared:
                friction.weigh(result, agrees=True)
            else:
                friction.pause()


def _pause(wheel: Wheel, *, agrees: bool) -> None:
    """Take a step at rest: a brake that is held there as the others are ends a doubt."""
    for signal, doubt in wheel.doubts.items():
        if signal == 'pressure' and agrees:
            doubt.weigh([], agrees=True)
        else:
            doubt.pause()


def _drop_what_is_off(wheel: Wheel, settings: MonitorSettings) -> None:
    """End reports of a check that is turned off: it would never see the input agree."""
    pressures = (settings.unbraked_deceleration if wheel.doubts['pressure'].kind == 'deceleration'
                 else settings.contradicting_pressure)
    for signal, on in (('pressure', pressures), ('rotor_speed', settings.wheel_speed_tolerance),
                       ('friction', settings.friction_ratio)):
        if not on and signal in wheel.doubts:
            wheel.doubts[signal].end()


def _marked(wheel: Wheel, inputs: Mapping[Signal, Reading]) -> Mapping[Signal, Reading]:
    """Return the readings of one brake, those in doubt marked."""
    doubted = {signal: inputs[signal]._replace(status='implausible', detail=wheel.doubted(signal))
               for signal in wheel.doubts
               if wheel.is_doubted(signal) and inputs[signal].status == 'good'}
    return {**inputs, **doubted} if doubted else inputs

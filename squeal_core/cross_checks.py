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
Checks across the inputs and brakes of a vehicle: a quiet reading that others contradict.

Only the quiet side is doubted: a brake that reads released, or less than its axle partner, while
the vehicle brakes; a wheel that reads at rest, or turns unlike the others; a friction below the
others'. An axle whose brakes agree is believed, and so is a brake that alone reads pressure.

Evidence is gathered in steps of 50 ms of the stamps, not in ticks, so it hardly depends on the
rate of assessments. A doubt ends when the input is seen to agree again, not when others rest.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from squeal_core.axles import axle_partners, in_words
from squeal_core.cross_evidence import Wheel
from squeal_core.cross_rules import against_friction, against_speed, motion_of
from squeal_core.inputs import Reading, Sample
from squeal_core.pressure_rules import against_pressure, learn_share, pressure_agrees
from squeal_core.settings import MonitorSettings, Signal
from squeal_core.signal_windows import STEP

_LONGEST_GAP = 5_000_000_000  # ns between ticks; what was gathered before counts no longer

__all__ = ['CrossChecks']


class CrossChecks:
    """
    Watches all brakes of a vehicle and marks readings that others contradict.

    Parameters
    ----------
    settings : MonitorSettings

    """

    def __init__(self, settings: MonitorSettings) -> None:
        self._wheels = {brake.name: Wheel(brake) for brake in settings.brakes}
        self.update_settings(settings)
        self.reset()

    def update_settings(self, settings: MonitorSettings) -> None:
        """Take other settings of the same brakes; what was gathered stays."""
        self._settings = settings
        self.partners = axle_partners(tuple(self._wheels), settings.axles)
        order = list(self._wheels)
        for brake in settings.brakes:
            wheel = self._wheels[brake.name]
            other = self.partners.get(brake.name, brake.name)
            wheel.is_first = order.index(brake.name) <= order.index(other)
            wheel.update_settings(brake)
            wheel.partner = self._wheels.get(self.partners.get(brake.name, ''))
            wheel.others = [other for other in self._wheels.values()
                            if other is not wheel and other is not wheel.partner]

    def reset(self) -> None:
        """Forget everything received and every doubt."""
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
        self._tick = time
        each = list(zip(self._wheels.values(), readings, strict=True))
        for wheel, inputs in each:
            for signal in wheel.usable:
                wheel.usable[signal] = inputs[signal].is_believed
        self._advance(time)
        return [_marked(wheel, inputs) for wheel, inputs in each]

    def _advance(self, time: int) -> None:
        """Look at all steps that ended since the last tick."""
        last = time // STEP * STEP
        if self._end is None or last - self._end > _LONGEST_GAP:
            for wheel in self._wheels.values():
                wheel.begin_anew()
            self._end = last - STEP
        for end in range(self._end + STEP, last + 1, STEP):
            self._step(end)
        self._end = last

    def _step(self, end: int) -> None:
        wheels, settings = tuple(self._wheels.values()), self._settings
        for wheel in wheels:
            wheel.advance(end)
        motion = motion_of(wheels, end)
        if not motion.fastest >= settings.minimum_rotor_speed:
            for wheel in wheels:
                for doubt in wheel.doubts.values():
                    doubt.pause()
            return
        for wheel in wheels:
            learn_share(wheel, motion)
            pressure, speed = wheel.doubts['pressure'], wheel.doubts['rotor_speed']
            pressure.weigh([*against_pressure(wheel, wheels, motion, end, settings)],
                           agrees=pressure_agrees(wheel, pressure.kind, settings))
            slow_or_fast, agrees = against_speed(wheel, motion, settings)
            speed.weigh(slow_or_fast, agrees=agrees)
            if (friction := wheel.doubts.get('friction')) is not None:
                found, compared = against_friction(wheel, settings)
                if compared:
                    friction.weigh(found, agrees=True)
                else:
                    friction.pause()


def _marked(wheel: Wheel, inputs: Mapping[Signal, Reading]) -> Mapping[Signal, Reading]:
    """Return the readings of one brake, those in doubt marked."""
    doubted = {signal: replace(inputs[signal], status='implausible', detail=doubt.said)
               for signal, doubt in wheel.doubts.items()
               if doubt.text and inputs[signal].status == 'good'}
    return {**inputs, **doubted} if doubted else inputs

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
The monitor of one brake: samples in, assessments out. No ROS in here, no clock, no threads.

An assessment depends on the samples received before a tick and on the ticks' times, nothing else:
the node and the replay of a bag run this same code and get the same numbers from the same ticks.
What earlier ticks left in the tables changes a number by less than its error.

The monitor is advisory. It is no safety function.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
import math

import numpy as np
from squeal_core.common.errors import ConfigurationError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.assessment import (
    Assessment,
    AssessmentContext,
    explained,
    from_stability,
    State,
)
from squeal_core.monitor.brake_stability import BrakeEvaluator, BrakeStability, evaluate_brakes
from squeal_core.monitor.cross_checks import CrossChecks
from squeal_core.monitor.input_channel import (
    InputChannel,
    MissingValue,
    Reading,
    Sample,
    Status,
    validated_ranges,
)
from squeal_core.monitor.settings import BrakeSettings, MonitorSettings, Signal
from squeal_core.monitor.vehicle_stability import VehicleStability

__all__ = ['Assessment', 'BrakeMonitor', 'Reading', 'Sample', 'State', 'Status',
           'MissingValue', 'VehicleMonitor']

# what an input's status makes of the brake's state, the gravest first
_STATES: dict[Status, State] = {
    'invalid': 'invalid', 'contradicted': 'invalid', 'stuck': 'invalid', 'implausible': 'invalid',
    'never received': 'stale', 'stale': 'stale',
    'time went backwards': 'stale', 'outside validated range': 'outside validated range'}


class BrakeMonitor:
    """Keeps the newest samples of one brake's inputs and assesses them on request."""

    def __init__(self, brake: BrakeSettings, settings: MonitorSettings, model: BrakeModel,
                 engines: VehicleStability | None = None) -> None:
        _check_model_serves(brake, model)
        self._model = model
        self._engines = engines or VehicleStability(model, settings)
        self._sliding = BrakeEvaluator(self._engines, settings, brake.name)
        self._adopt(brake, settings)
        self._inputs = {signal: InputChannel(signal, limits, settings, self._validated[signal])
                        for signal, limits in brake.inputs.items()}
        self._latest: dict[Signal, float] = {}  # by receipt, whatever their stamps
        self._time: int | None = None

    def _adopt(self, brake: BrakeSettings, settings: MonitorSettings) -> None:
        self.brake = brake
        self._settings = settings
        self._validated = validated_ranges(self._model, settings)

    def update_settings(self, brake: BrakeSettings, settings: MonitorSettings) -> None:
        """Take other settings of the same brake and inputs; samples stay."""
        self._adopt(brake, settings)
        self._sliding.update_settings(settings)
        for signal, limits in brake.inputs.items():
            self._inputs[signal].update_settings(limits, settings, self._validated[signal])

    def reset(self) -> None:
        """Forget all samples."""
        self._latest.clear()
        for one in self._inputs.values():
            one.forget()

    @property
    def refused(self) -> Counter[str]:
        """How many samples of each input were refused, and why."""
        return Counter({f'{signal} {why}': count for signal, one in self._inputs.items()
                        for why, count in one.refused.items()})

    def receive(self, signal: Signal, sample: Sample | MissingValue) -> None:
        """Take a sample of an input this brake has; late ones find their place by stamp."""
        if isinstance(sample, MissingValue):
            self._inputs[signal].record_missing(sample)
            return
        self._latest[signal] = sample.value
        sliding = (self._latest.get('pressure', 0.0) >= self._settings.release_pressure
                   and abs(self._latest.get('rotor_speed', 0.0))
                   >= self._settings.minimum_rotor_speed)
        others = sum(one.changes for name, one in self._inputs.items() if name != signal)
        self._inputs[signal].receive(sample, sliding=sliding, others=others)

    def assess(self, time: int) -> Assessment:
        """Assess the brake at a time [ns], from samples stamped up to it."""
        return assess_together([self], time, [self.read(time)])[0]

    def _begin(self, time: int,
               inputs: Mapping[Signal, Reading]) -> Assessment | AssessmentContext:
        """Return the assessment at a time [ns], or what it begins with where the brake slides."""
        friction, source, coefficient = self._friction(inputs)
        begun = AssessmentContext(self.brake.name, time, inputs)
        if all(reading.status == 'good' for reading in friction.values()):
            begun = begun._replace(friction=coefficient, friction_source=source)
        needed = {'rotor_speed': inputs['rotor_speed'], 'pressure': inputs['pressure']}
        if not self._friction_is_idle(inputs):
            needed |= friction
        bad = {name: reading for name, reading in needed.items() if reading.status != 'good'}
        if bad:
            ways = {_STATES[reading.status] for reading in bad.values()}
            return begun._replace(friction=math.nan, friction_source='').result(
                next(s for s in _STATES.values() if s in ways),
                '; '.join(r.described(name) for name, r in bad.items()))
        return self._without_sliding(begun) or begun

    def _friction_is_idle(self, inputs: Mapping[Signal, Reading]) -> bool:
        """Whether the brake is released or at rest, so that no friction is needed."""
        speed, pressure = inputs['rotor_speed'], inputs['pressure']
        return (pressure.status == 'good' and pressure.value < self._settings.release_pressure
                or speed.status == 'good'
                and abs(speed.value) < self._settings.minimum_rotor_speed)

    def read(self, time: int) -> dict[Signal, Reading]:
        """Return what is known of each input at a time [ns]."""
        if self._time is not None and time < self._time:
            for one in self._inputs.values():
                one.go_back(time)
        self._time = time
        return {signal: one.read(time) for signal, one in self._inputs.items()}

    def _friction(self, inputs: Mapping[Signal, Reading]) -> tuple[dict[str, Reading], str, float]:
        """
        Choose where friction comes from: measured, or the temperature while that fails.

        Returns the readings that are needed for it, the name of the source, and mu.
        """
        measured, temperature = inputs.get('friction'), inputs.get('temperature')
        table = self._model.friction_table
        if temperature is None or table is None or (measured and measured.status == 'good'):
            assert measured is not None  # the settings see to it
            return {'friction': measured}, 'measured', measured.value
        needed = {} if measured is None else {'friction': measured}
        if temperature.status != 'good':
            return {**needed, 'temperature': temperature}, '', math.nan
        coefficient = float(table(temperature.value))
        validated = self._validated['friction']
        if validated.admits(coefficient):
            return {'temperature': temperature}, 'temperature', coefficient
        outside = replace(temperature, status='outside validated range',
                          detail=f'which gives friction {coefficient:.4g}, {validated}')
        return {**needed, 'temperature': outside}, '', math.nan

    def _turns(self, found: Assessment) -> bool:
        """Whether the disc turns fast enough to slide, and as the model was validated for."""
        speed = abs(found.inputs['rotor_speed'].value)
        validated = self._validated['rotor_speed']
        return max(self._settings.minimum_rotor_speed, validated.low) <= speed <= validated.high

    def _without_sliding(self, begun: AssessmentContext) -> Assessment | None:
        """Assess from inputs that are all good a brake that is released or at rest."""
        speed, pressure = begun.inputs['rotor_speed'], begun.inputs['pressure']
        if pressure.value < self._settings.release_pressure:
            return begun.result('released', risk=0.0, reason=(
                f'pressure {pressure.value / 1e5:.2f} bar: brake released'))
        if abs(speed.value) < self._settings.minimum_rotor_speed:
            return begun.result(
                'not sliding', f'rotor speed {speed.value:.2f} rad/s: not sliding')
        for name, reading in (('rotor_speed', speed), ('pressure', pressure)):
            if abs(reading.value) < self._validated[name].low:
                low = replace(reading, detail=str(self._validated[name]))
                return begun.result('outside validated range', low.described(name))
        return None


def assess_together(monitors: Sequence[BrakeMonitor], time: int,
                    readings: Sequence[Mapping[Signal, Reading]]) -> tuple[Assessment, ...]:
    """Assess brakes of the same engines from readings of a time [ns]: those that slide in one."""
    every = [monitor._begin(time, inputs)
             for monitor, inputs in zip(monitors, readings, strict=True)]
    if not any(isinstance(one, AssessmentContext) for one in every):
        _await_application(monitors, every)
    known = iter(_judged([(monitor._sliding, begun) for monitor, begun in zip(
        monitors, every, strict=True) if isinstance(begun, AssessmentContext)], time))
    return tuple(explained(from_stability(one, next(known))) if isinstance(one, AssessmentContext)
                 else one for one in every)


def _await_application(monitors: Sequence[BrakeMonitor],
                       every: Sequence[Assessment | AssessmentContext]) -> None:
    """Have made ready what brakes that are released while they turn will ask for."""
    waiting = [(abs(one.inputs['rotor_speed'].value), one.friction)
               for monitor, one in zip(monitors, every, strict=True)
               if isinstance(one, Assessment) and one.state == 'released'
               and not math.isnan(one.friction) and monitor._turns(one)]
    if waiting:
        monitors[0]._engines.onset.look(waiting, monitors[0]._settings.release_pressure)


def _judged(brakes: Sequence[tuple[BrakeEvaluator, AssessmentContext]], time: int
            ) -> list[BrakeStability | np.linalg.LinAlgError]:
    """Return what is known of brakes that slide, or why it is not."""
    if not brakes:
        return []
    try:
        return [*evaluate_brakes([(brake, begun.operation) for brake, begun in brakes], time)]
    except np.linalg.LinAlgError as error:
        if len(brakes) == 1:
            return [error]
        return [known for one in brakes for known in _judged([one], time)]


def _check_model_serves(brake: BrakeSettings, model: BrakeModel) -> None:
    """Refuse at the start a model that can never answer for this brake."""
    if model.caliper is None:
        raise ConfigurationError('model', 'has no caliper, so a pressure says nothing to it',
                                 'give it one (BrakeModel(caliper=...) or a brake description)')
    if 'friction' not in brake.inputs and model.friction_table is None:
        raise ConfigurationError(
            f'{brake.name}.temperature', 'is all there is, and the model has no friction table',
            'name a friction topic, or build the model with friction.temperature_table')


class VehicleMonitor:
    """The monitors of all brakes of a vehicle, assessed together from the same tables."""

    def __init__(self, settings: MonitorSettings, model: BrakeModel) -> None:
        self.settings = settings
        self.engines = VehicleStability(model, settings)
        self.brakes = {brake.name: BrakeMonitor(brake, settings, model, self.engines)
                       for brake in settings.brakes}
        self.cross_checks = CrossChecks(settings)

    def close(self) -> None:
        """End the engines' workers."""
        self.engines.close()

    def update_settings(self, settings: MonitorSettings) -> None:
        """Take other settings of the same brakes from the next assessment on; samples stay."""
        self.settings = settings
        self.engines.update_settings(settings)
        self.cross_checks.update_settings(settings)
        for brake in settings.brakes:
            self.brakes[brake.name].update_settings(brake, settings)

    def receive(self, brake: str, signal: Signal, sample: Sample | MissingValue) -> None:
        self.brakes[brake].receive(signal, sample)
        if isinstance(sample, Sample):
            self.cross_checks.receive(brake, signal, sample)

    def assess(self, time: int) -> tuple[Assessment, ...]:
        """Assess all brakes at a time [ns]; what other brakes contradict is invalid."""
        monitors = tuple(self.brakes.values())
        readings = [monitor.read(time) for monitor in monitors]
        return assess_together(monitors, time, self.cross_checks.check(time, readings))

    def reset(self) -> None:
        self.cross_checks.reset()
        for monitor in self.brakes.values():
            monitor.reset()

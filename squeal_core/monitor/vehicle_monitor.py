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
The monitor of a vehicle's brakes: samples in, assessments out. No ROS, no clock, no threads.

An assessment is a function of model, tables, settings, the samples received before the tick and
the ticks before it in the same brake application, nothing else: the node and the replay of a bag
run this same code and get the same numbers.

The monitor is advisory. It is no safety function.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
import math

from squeal_core.common.errors import ConfigurationError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.assessment import Assessment, AssessmentContext, PreparedTick, State
from squeal_core.monitor.brake_settings import BrakeSettings
from squeal_core.monitor.inputs.cross_checks import CrossChecks
from squeal_core.monitor.inputs.input_channel import InputChannel
from squeal_core.monitor.inputs.reading import (
    MissingValue,
    Reading,
    Sample,
    Status,
    validated_ranges,
)
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.tick_turns import is_due
from squeal_core.monitor.vehicle_evaluator import VehicleEvaluator

__all__ = ['Assessment', 'BrakeMonitor', 'Reading', 'Sample', 'State', 'Status',
           'MissingValue', 'VehicleMonitor']

# state of the brake by the status of an input, the gravest first
_STATES: dict[Status, State] = {
    'invalid': 'invalid', 'contradicted': 'invalid', 'stuck': 'invalid', 'implausible': 'invalid',
    'never received': 'stale', 'stale': 'stale',
    'time went backwards': 'stale', 'outside validated range': 'outside validated range'}


class BrakeMonitor:
    """Keeps the newest samples of one brake's inputs and assesses them on request."""

    def __init__(self, brake: BrakeSettings, settings: MonitorSettings, model: BrakeModel,
                 evaluator: VehicleEvaluator | None = None) -> None:
        _check_model_serves(brake, model)
        self._model = model
        self._evaluator = evaluator
        self._latest: dict[Signal, float] = {}  # by receipt, whatever their stamps
        self._adopt(brake, settings)
        self._inputs = {signal: InputChannel(signal, limits, settings, self._validated[signal])
                        for signal, limits in brake.inputs.items()}
        self._time: int | None = None

    def _adopt(self, brake: BrakeSettings, settings: MonitorSettings) -> None:
        self.brake = brake
        self._settings = settings
        # interval of confirmed margins [ns], and this brake's turn of so many
        self._confirm_at = (round(1e9 * settings.margin_confirm_interval),
                            [one.name for one in settings.brakes].index(brake.name),
                            len(settings.brakes))
        self._validated = validated_ranges(self._model, settings)
        self._take_latest()

    def update_settings(self, brake: BrakeSettings, settings: MonitorSettings) -> None:
        """Apply other settings of the same brake and inputs; samples stay."""
        self._adopt(brake, settings)
        for signal, limits in brake.inputs.items():
            self._inputs[signal].update_settings(limits, settings, self._validated[signal])

    def reset(self) -> None:
        """Forget all samples."""
        self._latest.clear()
        self._take_latest()
        for one in self._inputs.values():
            one.forget()

    @property
    def refused(self) -> Counter[str]:
        """Return the number of refused samples, by input and reason."""
        return Counter({f'{signal} {why}': count for signal, one in self._inputs.items()
                        for why, count in one.refused.items()})

    def receive(self, signal: Signal, sample: Sample | MissingValue) -> None:
        """Take a sample of an input this brake has; late ones find their place by stamp."""
        if isinstance(sample, MissingValue):
            self._inputs[signal].record_missing(sample)
            return
        if signal == 'pressure':
            self._latest[signal] = sample.value
            self._pressed = sample.value >= self._settings.release_pressure
        elif signal == 'rotor_speed':
            self._latest[signal] = sample.value
            self._turning = abs(sample.value) >= self._settings.minimum_rotor_speed
        own = self._inputs[signal]
        others = -own.changes
        for one in self._inputs.values():
            others += one.changes
        own.receive(sample, sliding=self._pressed and self._turning, others=others)

    def _take_latest(self) -> None:
        """Take whether the disc is pressed and turns by what was received last."""
        latest, settings = self._latest, self._settings
        self._pressed = latest.get('pressure', 0.0) >= settings.release_pressure
        self._turning = abs(latest.get('rotor_speed', 0.0)) >= settings.minimum_rotor_speed

    def assess(self, time: int) -> Assessment:
        """Assess the brake at a time [ns], from samples stamped up to it."""
        self._evaluator = self._evaluator or VehicleEvaluator(self._model, self._settings)
        return self._evaluator.complete([(self.prepare(time, self.read(time)),)])[0][0]

    def prepare(self, time: int,
                inputs: Mapping[Signal, Reading]) -> Assessment | AssessmentContext:
        """Return the assessment at a time [ns], or its context where the brake slides."""
        friction, source, coefficient = self._friction(inputs)
        for reading in friction.values():
            if reading.status != 'good':
                coefficient, source = math.nan, ''
        context = AssessmentContext(self.brake.name, time, inputs, coefficient, source)
        if not source or not (
                inputs['rotor_speed'].status == inputs['pressure'].status == 'good'):
            needed = {'rotor_speed': inputs['rotor_speed'], 'pressure': inputs['pressure']}
            if not self._friction_is_idle(inputs):
                needed |= friction
            bad = {name: reading for name, reading in needed.items() if reading.status != 'good'}
            if bad:
                states = {_STATES[reading.status] for reading in bad.values()}
                return context._replace(friction=math.nan, friction_source='').result(
                    next(s for s in _STATES.values() if s in states),
                    '; '.join(r.described(name) for name, r in bad.items()))
        result = self._without_sliding(context)
        period = self._settings.period
        if result is None and is_due(time - period, period, *self._confirm_at):
            return context._replace(confirm=True)  # a tick after one that evaluates risks
        return result or context

    def _friction_is_idle(self, inputs: Mapping[Signal, Reading]) -> bool:
        """Return whether the brake is released or at rest, so that no friction is needed."""
        speed, pressure = inputs['rotor_speed'], inputs['pressure']
        return (pressure.status == 'good' and pressure.value < self._settings.release_pressure
                or speed.status == 'good'
                and abs(speed.value) < self._settings.minimum_rotor_speed)

    def read(self, time: int) -> dict[Signal, Reading]:
        """Return the readings of all inputs at a time [ns]."""
        if self._time is not None and time < self._time:
            for one in self._inputs.values():
                one.go_back(time)
        self._time = time
        return {signal: one.read(time) for signal, one in self._inputs.items()}

    def _friction(self, inputs: Mapping[Signal, Reading]) -> tuple[dict[str, Reading], str, float]:
        """
        Choose where friction comes from: measured, the temperature while that fails, or constant.

        Returns the readings that are needed for it, the name of the source, and mu.
        """
        measured, temperature = inputs.get('friction'), inputs.get('temperature')
        table = self._model.friction_table
        if measured is None and temperature is None:
            return {}, 'constant', self.brake.constant_friction
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
        outside = temperature._replace(
            status='outside validated range',
            detail=f'which gives friction {coefficient:.4g}, {validated}')
        return {**needed, 'temperature': outside}, '', math.nan

    def _without_sliding(self, context: AssessmentContext) -> Assessment | None:
        """Assess from inputs that are all good a brake that is released or at rest."""
        speed, pressure = context.inputs['rotor_speed'], context.inputs['pressure']
        if pressure.value < self._settings.release_pressure:
            return context.result(
                'released', f'pressure {pressure.value:.0f} Pa: brake released', risk=0.0,
                instability_probability=0.0, build_up=0.0, time_to_squeal=math.inf)
        if abs(speed.value) < self._settings.minimum_rotor_speed:
            return context.result(
                'not sliding', f'rotor speed {speed.value:.2f} rad/s: not sliding')
        for name, reading in (('rotor_speed', speed), ('pressure', pressure)):
            if abs(reading.value) < self._validated[name].low:
                low = reading._replace(detail=str(self._validated[name]))
                return context.result('outside validated range', low.described(name))
        return None


def _check_model_serves(brake: BrakeSettings, model: BrakeModel) -> None:
    """Refuse at the start a model that can never answer for this brake."""
    if model.caliper is None:
        raise ConfigurationError('model', 'has no caliper, so a pressure says nothing to it',
                                 'give it one (BrakeModel(caliper=...) or a brake description)')
    by_temperature = 'temperature' in brake.inputs and 'friction' not in brake.inputs
    if by_temperature and model.friction_table is None:
        raise ConfigurationError(
            f'{brake.name}.temperature', 'is all there is, and the model has no friction table',
            'name a friction topic, or build the model with friction.temperature_table')


class VehicleInputs:
    """The inputs of all brakes of a vehicle: samples in, prepared ticks out."""

    def __init__(self, settings: MonitorSettings, model: BrakeModel,
                 evaluator: VehicleEvaluator | None = None) -> None:
        self.settings = settings
        self.brakes = {brake.name: BrakeMonitor(brake, settings, model, evaluator)
                       for brake in settings.brakes}
        self.cross_checks = CrossChecks(settings)

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings of the same brakes from the next assessment on; samples stay."""
        self.settings = settings
        self.cross_checks.update_settings(settings)
        for brake in settings.brakes:
            self.brakes[brake.name].update_settings(brake, settings)

    def receive(self, brake: str, signal: Signal, sample: Sample | MissingValue) -> None:
        """Take a sample of a brake's input, or a missing value."""
        self.brakes[brake].receive(signal, sample)
        if not isinstance(sample, MissingValue):
            self.cross_checks.receive(brake, signal, sample)

    def prepare(self, time: int) -> PreparedTick:
        """Read the inputs of a tick [ns]; what needs no stability is assessed already."""
        monitors = tuple(self.brakes.values())
        readings = self.cross_checks.check(time, [monitor.read(time) for monitor in monitors])
        return tuple(monitor.prepare(time, inputs)
                     for monitor, inputs in zip(monitors, readings, strict=True))

    def reset(self) -> None:
        """Forget all samples."""
        self.cross_checks.reset()
        for monitor in self.brakes.values():
            monitor.reset()


class VehicleMonitor(VehicleInputs):
    """
    The monitors of all brakes of a vehicle, assessed together.

    Examples
    --------
    >>> from squeal_core import BrakeModel, VehicleMonitor
    >>> from squeal_core.monitor.settings import read_settings
    >>> from squeal_core.monitor.vehicle_monitor import Sample
    >>> monitor = VehicleMonitor(read_settings({'brakes': ['front']}), BrakeModel.load('kang2009'))
    >>> for signal, value in (('rotor_speed', 20.0), ('pressure', 2e6), ('friction', 0.5)):
    ...     monitor.receive('front', signal, Sample(10**9, value))
    >>> [front] = monitor.assess(10**9)
    >>> front.state, round(front.instability_probability, 4)
    ('steady', 1.0)

    """

    def __init__(self, settings: MonitorSettings, model: BrakeModel) -> None:
        for brake in settings.brakes:
            _check_model_serves(brake, model)
        self.evaluator = VehicleEvaluator(model, settings)
        super().__init__(settings, model, self.evaluator)

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings of the same brakes from the next assessment on; samples stay."""
        super().update_settings(settings)
        self.evaluator.update_settings(settings)

    def reset(self) -> None:
        """Forget all samples and brake applications."""
        super().reset()
        self.evaluator.reset()

    def assess(self, time: int) -> tuple[Assessment, ...]:
        """Assess all brakes at a time [ns]; what other brakes contradict is invalid."""
        return self.complete([self.prepare(time)])[0]

    def complete(self, ticks: Sequence[PreparedTick]) -> list[tuple[Assessment, ...]]:
        """Return the assessments of the ticks that follow; many at once cost less than each."""
        return self.evaluator.complete(ticks)

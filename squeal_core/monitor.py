"""The monitor of one brake: samples in, assessments out. No ROS in here, no clock, no threads.

An assessment depends on the samples received before a tick and on the ticks' times, nothing else:
the node and the replay of a bag run this same code and get the same numbers from the same ticks.
What earlier ticks left in the tables changes a number by less than its error.

The monitor is advisory. It is no safety function.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
import math
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from squeal_core.brake_model import BrakeModel
from squeal_core.engines import Engines
from squeal_core.errors import ConfigurationError
from squeal_core.inputs import Input, Reading, Sample, Status, Unreadable, validated_ranges
from squeal_core.operating_point import OperatingPoint
from squeal_core.settings import BrakeSettings, MonitorSettings, Signal
from squeal_core.sliding import Sliding, SlidingBrake
from squeal_core.stability import Mode

__all__ = ['Assessment', 'BrakeMonitor', 'Reading', 'Sample', 'State', 'Status',
           'Unreadable', 'VehicleMonitor']

State: TypeAlias = Literal['steady', 'released', 'not sliding', 'stale', 'invalid',
                           'outside validated range']

# what an input's status makes of the brake's state, the gravest first
_STATES: dict[Status, State] = {
    'invalid': 'invalid', 'stuck': 'invalid', 'never received': 'stale', 'stale': 'stale',
    'time went backwards': 'stale', 'outside validated range': 'outside validated range'}


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """What is known of one brake at one tick.

    Parameters
    ----------
    brake : str
    time : int
        The tick [ns].
    state : str
        'steady': sliding under load, the numbers hold; 'released': no load, risk 0;
        'not sliding', 'stale', 'invalid', 'outside validated range': not known, numbers NaN.
    reason : str
        The state in words; inputs named with their value and age.
    inputs : mapping
        `Reading` of each input.
    friction : float
        mu [-], measured or by the temperature table.
    friction_source : str
        'measured' or 'temperature'; empty where friction is not known.
    point : OperatingPoint or None
    modes : tuple of Mode
        All unstable modes, worst first: flutter in and below the squeal band, divergence.
    risk : float
        Probability that a mode in the squeal band grows [-].
    growth_rate : float
        Largest Re(lambda) of the oscillating modes in the squeal band [1/s].
    worst_frequency_hz : float
        Frequency of that mode.
    friction_margin : float
        Critical minus present friction [-], bracketed and confirmed by full solves; NaN where
        there is none, or none was found yet that holds at this speed and pressure.
    sliding : Sliding or None
        All that is known of the sliding brake: errors of modes, risk by mode, margins with stamps.
    """

    brake: str
    time: int
    state: State
    reason: str
    inputs: Mapping[Signal, Reading] = field(default_factory=dict)
    friction: float = math.nan
    friction_source: str = ''
    point: OperatingPoint | None = None
    modes: tuple[Mode, ...] = ()
    risk: float = math.nan
    growth_rate: float = math.nan
    worst_frequency_hz: float = math.nan
    friction_margin: float = math.nan
    sliding: Sliding | None = field(default=None, repr=False, compare=False)

    @property
    def known(self) -> bool:
        """Whether the risk is a number."""
        return self.state in ('steady', 'released')

    @property
    def flutter(self) -> tuple[Mode, ...]:
        """Oscillating unstable modes, worst first."""
        return tuple(m for m in self.modes if m.kind == 'flutter')


class _Found(NamedTuple):
    """What an assessment begins with."""

    brake: str
    time: int
    inputs: Mapping[Signal, Reading]
    friction: float = math.nan
    friction_source: str = ''

    def said(self, state: State, reason: str, **known: Any) -> Assessment:
        return Assessment(**self._asdict(), state=state, reason=reason, **known)


class BrakeMonitor:
    """Keeps the newest samples of one brake's inputs and assesses them on request."""

    def __init__(self, brake: BrakeSettings, settings: MonitorSettings, model: BrakeModel,
                 engines: Engines | None = None) -> None:
        _check_model_serves(brake, model)
        self._model = model
        self._sliding = SlidingBrake(
            engines or Engines(model, settings), settings, brake.name)
        self._adopt(brake, settings)
        self._inputs = {signal: Input(signal, limits, settings, self._validated[signal])
                        for signal, limits in brake.inputs.items()}
        self._latest: dict[Signal, float] = {}  # by receipt, whatever their stamps
        self._time: int | None = None

    def _adopt(self, brake: BrakeSettings, settings: MonitorSettings) -> None:
        self.brake = brake
        self._settings = settings
        self._validated = validated_ranges(self._model, settings)

    def retune(self, brake: BrakeSettings, settings: MonitorSettings) -> None:
        """Take other settings of the same brake and inputs; samples stay."""
        self._adopt(brake, settings)
        self._sliding.retune(settings)
        for signal, limits in brake.inputs.items():
            self._inputs[signal].retune(limits, settings, self._validated[signal])

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

    def receive(self, signal: Signal, sample: Sample | Unreadable) -> None:
        """Take a sample of an input this brake has; late ones find their place by stamp."""
        if isinstance(sample, Unreadable):
            self._inputs[signal].miss(sample.reason)
            return
        self._latest[signal] = sample.value
        sliding = (self._latest.get('pressure', 0.0) >= self._settings.release_pressure
                   and abs(self._latest.get('rotor_speed', 0.0))
                   >= self._settings.minimum_rotor_speed)
        others = sum(one.changes for name, one in self._inputs.items() if name != signal)
        self._inputs[signal].receive(sample, sliding=sliding, others=others)

    def assess(self, time: int) -> Assessment:
        """Assess the brake at a time [ns], from samples stamped up to it."""
        inputs = self._read(time)
        friction, source, coefficient = self._friction(inputs)
        needed = {'rotor_speed': inputs['rotor_speed'], 'pressure': inputs['pressure'], **friction}
        bad = {name: reading for name, reading in needed.items() if reading.status != 'good'}
        if bad:
            ways = {_STATES[reading.status] for reading in bad.values()}
            return _Found(self.brake.name, time, inputs).said(
                next(s for s in _STATES.values() if s in ways),
                '; '.join(r.described(name) for name, r in bad.items()))
        found = self._assess_known(
            _Found(self.brake.name, time, inputs, coefficient, source))
        if source == 'temperature' and 'friction' in inputs:
            instead = inputs['friction'].described('friction')
            return replace(found, reason=f'{found.reason}; friction by temperature, as {instead}')
        return found

    def _read(self, time: int) -> dict[Signal, Reading]:
        if self._time is not None and time < self._time:
            for one in self._inputs.values():
                one.go_back(time)
        self._time = time
        return {signal: one.read(time) for signal, one in self._inputs.items()}

    def _friction(self, inputs: Mapping[Signal, Reading]) -> tuple[dict[str, Reading], str, float]:
        """Choose where friction comes from: measured, or the temperature while that fails.

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

    def _assess_known(self, found: _Found) -> Assessment:
        """Assess from inputs that are all good: released, at rest or sliding."""
        speed, pressure = found.inputs['rotor_speed'], found.inputs['pressure']
        if pressure.value < self._settings.release_pressure:
            return found.said('released', risk=0.0, reason=(
                f'pressure {pressure.value / 1e5:.2f} bar: brake released'))
        if abs(speed.value) < self._settings.minimum_rotor_speed:
            return found.said(
                'not sliding', f'rotor speed {speed.value:.2f} rad/s: not sliding')
        for name, reading in (('rotor_speed', speed), ('pressure', pressure)):
            if abs(reading.value) < self._validated[name].low:
                low = replace(reading, detail=str(self._validated[name]))
                return found.said('outside validated range', low.described(name))
        return self._assess_sliding(found)

    def _assess_sliding(self, found: _Found) -> Assessment:
        try:
            known = self._sliding.judge(
                found.inputs['rotor_speed'].value, found.inputs['pressure'].value,
                found.friction, found.time)
        except np.linalg.LinAlgError as error:
            return found.said('invalid', f'no eigensolution ({error})')
        if math.isnan(known.risk.probability):
            return found.said('invalid', 'no risk: modes are not separable here')
        worst = known.worst
        return found.said(
            'steady', _in_words(worst, known.risk.probability), point=known.point,
            modes=known.modes.unstable, risk=known.risk.probability,
            growth_rate=worst.growth_rate if worst else math.nan,
            worst_frequency_hz=worst.frequency_hz if worst else math.nan,
            friction_margin=known.friction_margin, sliding=known)


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
        self.engines = Engines(model, settings)
        self.brakes = {brake.name: BrakeMonitor(brake, settings, model, self.engines)
                       for brake in settings.brakes}

    def close(self) -> None:
        """End the engines' workers."""
        self.engines.close()

    def retune(self, settings: MonitorSettings) -> None:
        """Take other settings of the same brakes from the next assessment on; samples stay."""
        self.settings = settings
        self.engines.retune(settings)
        for brake in settings.brakes:
            self.brakes[brake.name].retune(brake, settings)

    def receive(self, brake: str, signal: Signal, sample: Sample | Unreadable) -> None:
        self.brakes[brake].receive(signal, sample)

    def assess(self, time: int) -> tuple[Assessment, ...]:
        return tuple(monitor.assess(time) for monitor in self.brakes.values())

    def reset(self) -> None:
        for monitor in self.brakes.values():
            monitor.reset()


def _in_words(worst: Mode | None, risk: float) -> str:
    if worst is None:
        return 'no mode in the squeal band'
    verdict = 'grows' if worst.growth_rate > 0.0 else 'decays'
    return (f'squeal risk {risk:.2f}: mode at {worst.frequency_hz:.0f} Hz {verdict} with '
            f'{worst.growth_rate:+.1f} 1/s')

"""The monitor of one brake: samples in, assessments out. No ROS in here, no clock, no threads.

An assessment depends on the samples received before a tick and on the tick's time, nothing else:
the node and the replay of a bag run this same code and get the same numbers.

The monitor is advisory. It is no safety function.
"""

import bisect
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
import math
from typing import Literal, TypeAlias

import numpy as np

from squeal_core.brake_model import BrakeModel
from squeal_core.errors import ConfigurationError
from squeal_core.operating_point import OperatingPoint
from squeal_core.risk import Deviations, first_order_risk, Inputs
from squeal_core.settings import BrakeSettings, InputSettings, MonitorSettings, Signal
from squeal_core.stability import complex_modes, ComplexModes, Mode

State: TypeAlias = Literal['steady', 'released', 'not sliding', 'stale', 'invalid']
Status: TypeAlias = Literal['good', 'never received', 'stale', 'invalid']

# samples kept of an input: between two ticks, and stamped ahead of them
_KEPT = 4096
# modes whose probability of growing is looked at: the least stable few
_CANDIDATES = 3


@dataclass(frozen=True)
class Sample:
    """A value in SI units and the time it holds for [ns]."""

    stamp: int
    value: float


@dataclass(frozen=True)
class Reading:
    """An input as an assessment found it: the newest sample up to the tick."""

    status: Status
    value: float = math.nan
    age: float = math.nan  # s


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
        'not sliding', 'stale', 'invalid': not known, numbers NaN.
    reason : str
        The state in words, inputs named.
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
        Critical minus present friction [-], first order; NaN where more friction brings none.
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

    @property
    def known(self) -> bool:
        """Whether the risk is a number."""
        return self.state in ('steady', 'released')

    @property
    def flutter(self) -> tuple[Mode, ...]:
        """Oscillating unstable modes, worst first."""
        return tuple(m for m in self.modes if m.kind == 'flutter')


class BrakeMonitor:
    """Keeps the newest samples of one brake's inputs and assesses them on request."""

    def __init__(self, brake: BrakeSettings, settings: MonitorSettings, model: BrakeModel) -> None:
        _check_model_serves(brake, model)
        self.brake = brake
        self._settings = settings
        self._model = model
        self._deviations = Deviations(
            friction=settings.friction_deviation, pressure=settings.pressure_deviation,
            rotor_speed=settings.rotor_speed_deviation,
            contact_stiffness=settings.contact_stiffness_deviation)
        self._samples: dict[Signal, list[Sample]] = {}
        self.reset()

    def reset(self) -> None:
        """Forget all samples, as after a jump back of the clock."""
        self._samples = {signal: [] for signal in self.brake.inputs}

    def receive(self, signal: Signal, sample: Sample) -> None:
        """Take a sample of an input this brake has; late ones find their place by stamp."""
        samples = self._samples[signal]
        bisect.insort(samples, sample, key=_stamp)
        if len(samples) > _KEPT:
            del samples[0]

    def assess(self, time: int) -> Assessment:
        """Assess the brake at a time [ns], from samples stamped up to it."""
        inputs = {signal: self._read(signal, time) for signal in self.brake.inputs}
        found = Assessment(brake=self.brake.name, time=time, state='steady', reason='',
                           inputs=inputs)
        friction, source = self._friction(inputs)
        needed = {'rotor_speed': inputs['rotor_speed'], 'pressure': inputs['pressure'], **friction}
        for status, state in (('invalid', 'invalid'), ('never received', 'stale'),
                              ('stale', 'stale')):
            bad = [name for name, reading in needed.items() if reading.status == status]
            if bad:
                reasons = '; '.join(_describe(name, needed[name]) for name in bad)
                return replace(found, state=state, reason=reasons)  # type: ignore[arg-type]
        found = replace(found, friction=self._coefficient(friction), friction_source=source)
        if inputs['pressure'].value < self._settings.release_pressure:
            return replace(found, state='released', risk=0.0, reason=(
                f'pressure {inputs["pressure"].value / 1e5:.2f} bar: brake released'))
        if abs(inputs['rotor_speed'].value) < self._settings.minimum_rotor_speed:
            return replace(found, state='not sliding', reason=(
                f'rotor speed {inputs["rotor_speed"].value:.2f} rad/s: not sliding'))
        return self._assess_sliding(found)

    def _read(self, signal: Signal, time: int) -> Reading:
        samples = self._samples[signal]
        past = bisect.bisect_right(samples, time, key=_stamp)
        if past == 0:
            return Reading('never received')
        del samples[:past - 1]  # the newest of the past stays, and what is ahead of the tick
        age, value = (time - samples[0].stamp) * 1e-9, samples[0].value
        limits = self.brake.inputs[signal]
        if age > limits.max_age:
            return Reading('stale', value, age)
        return Reading('good' if _believable(value, limits) else 'invalid', value, age)

    def _friction(self, inputs: Mapping[Signal, Reading]) -> tuple[dict[str, Reading], str]:
        """Choose where friction comes from: measured, or the temperature while that fails."""
        measured, temperature = inputs.get('friction'), inputs.get('temperature')
        if temperature is None or self._model.friction_table is None:
            assert measured is not None  # the settings see to it
            return {'friction': measured}, 'measured'
        if measured is None or (measured.status != 'good' and temperature.status == 'good'):
            return {'temperature': temperature}, 'temperature'
        return {'friction': measured}, 'measured'

    def _coefficient(self, friction: Mapping[str, Reading]) -> float:
        if 'friction' in friction:
            return friction['friction'].value
        assert self._model.friction_table is not None
        return float(self._model.friction_table(friction['temperature'].value))

    def _point(self, inputs: Inputs) -> OperatingPoint:
        return self._model.operating_point(
            rotor_speed=inputs.rotor_speed, pressure=inputs.pressure, friction=inputs.friction,
            contact_stiffness=inputs.contact_stiffness)

    def _assess_sliding(self, found: Assessment) -> Assessment:
        at = Inputs(rotor_speed=found.inputs['rotor_speed'].value,
                    pressure=found.inputs['pressure'].value, friction=found.friction,
                    contact_stiffness=self._model.nominal_contact_stiffness)
        point = self._point(at)
        try:
            solved = complex_modes(self._model, point)
            candidates = self._candidates(solved)
            risk = first_order_risk(self._model, self._point, at, candidates, self._deviations)
        except np.linalg.LinAlgError as error:
            return replace(found, state='invalid', reason=f'no eigensolution ({error})')
        if math.isnan(risk.probability):
            return replace(found, state='invalid', reason='no risk: modes are not separable here')
        worst = candidates[0] if candidates else None
        return replace(
            found, point=point, modes=solved.unstable, risk=risk.probability,
            growth_rate=worst.growth_rate if worst else math.nan,
            worst_frequency_hz=worst.frequency_hz if worst else math.nan,
            friction_margin=risk.friction_margin, reason=_in_words(worst, risk.probability))

    def _candidates(self, solved: ComplexModes) -> list[Mode]:
        """Least stable oscillating modes of the squeal band, worst first."""
        low, high = self._settings.squeal_band_low_hz, self._settings.squeal_band_high_hz
        in_band = [m for m in solved.modes if m.kind in ('flutter', 'stable')
                   and low <= m.frequency_hz <= high]
        return sorted(in_band, key=lambda m: -m.growth_rate)[:_CANDIDATES]


def _check_model_serves(brake: BrakeSettings, model: BrakeModel) -> None:
    """Refuse at the start a model that can never answer for this brake."""
    if model.caliper is None:
        raise ConfigurationError('model', 'has no caliper, so a pressure says nothing to it',
                                 'give it one (BrakeModel(caliper=...) or a brake description)')
    if 'friction' not in brake.inputs and model.friction_table is None:
        raise ConfigurationError(
            f'{brake.name}.temperature', 'is all there is, and the model has no friction table',
            'name a friction topic, or build the model with friction.temperature_table')


def _stamp(sample: Sample) -> int:
    return sample.stamp


class VehicleMonitor:
    """The monitors of all brakes of a vehicle, assessed together."""

    def __init__(self, settings: MonitorSettings, model: BrakeModel) -> None:
        self.settings = settings
        self.brakes = {brake.name: BrakeMonitor(brake, settings, model)
                       for brake in settings.brakes}

    def receive(self, brake: str, signal: Signal, sample: Sample) -> None:
        self.brakes[brake].receive(signal, sample)

    def assess(self, time: int) -> tuple[Assessment, ...]:
        return tuple(monitor.assess(time) for monitor in self.brakes.values())

    def reset(self) -> None:
        for monitor in self.brakes.values():
            monitor.reset()


def _believable(value: float, limits: InputSettings) -> bool:
    return math.isfinite(value) and limits.minimum <= value <= limits.maximum


def _describe(name: str, reading: Reading) -> str:
    if reading.status == 'never received':
        return f'{name} never received'
    if reading.status == 'stale':
        return f'{name} is {reading.age:.2f} s old'
    return f'{name} is {reading.value:g}, outside its range'


def _in_words(worst: Mode | None, risk: float) -> str:
    if worst is None:
        return 'no mode in the squeal band'
    verdict = 'grows' if worst.growth_rate > 0.0 else 'decays'
    return (f'squeal risk {risk:.2f}: mode at {worst.frequency_hz:.0f} Hz {verdict} with '
            f'{worst.growth_rate:+.1f} 1/s')

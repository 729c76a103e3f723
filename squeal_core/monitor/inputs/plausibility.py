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
Plausibility checks of a signal's history: its unit and its reference.

Each check is given samples in order of receipt and returns at once, so that its result belongs to
the sample and depends on no tick: '' for a plausible sample.
"""

import math
from typing import NamedTuple, Protocol

from squeal_core.monitor.brake_settings import InputSettings
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings

RPM = math.tau / 60.0  # rad/s
_SECOND = 1_000_000_000

# Bar given as Pa: a released brake reads less in either unit; no brake is held so long in between.
_LEAST_BAR = 0.5
_LEAST_GAUGE_BAR = -1.1
_BAR_TIME = _SECOND // 2
_BAR_SAMPLES = 10

# A released brake rests near zero gauge pressure, or near the pressure of the air: 0.65 bar are
# 3.5 km of altitude, and a sensor may err and flicker.
_RELEASED = 0.4e5
_AIR = (_RELEASED, 1.25e5)
_BRAKED = 3e5
_REST_TIME, _VACUUM_TIME = 5 * _SECOND, 3 * _SECOND
_REST_SAMPLES = 10
_RETURNS = 3  # from braking to such a rest; a brake is rarely held at 1 bar between brakings
_VACUUM, _NO_VACUUM = -0.8e5, -0.5e5  # no brake fluid is at less than 0.2 bar absolute for long
_NO_VACUUM_TIME = 60 * _SECOND

_FLICKER, _SHARE = 2.0, 0.02  # rad/s and relative; less is the noise of a sensor and no leap
_ALIKE = 0.01  # by which the same speed may differ in rpm and in rad/s
_BRAKING = 3.0  # rad/s^2, by which a wheel changes meanwhile: 1 m/s^2
_RAMP_TIME, _PIECE = _SECOND, _SECOND // 5
_PIECES = 3
_BEYOND_TIME = _SECOND // 5  # for which a speed beyond the maximum is no spike
_DOUBT = 60 * _SECOND  # for which a speed that no vehicle has is remembered
_TO_RPM = 'looks like rpm given as rad/s'


class PlausibilityCheck(Protocol):
    """Checks the samples of one input."""

    def check(self, stamp: int, value: float) -> str:
        """Return the fault of a sample, in words that follow its value; '' for no fault."""


class _Rest:
    """Time and number of samples for which a value has stayed in a range."""

    def __init__(self, time: int, samples: int) -> None:
        self._time, self._least = time, samples
        self._since = self._samples = 0

    def lasts(self, stamp: int, inside: bool) -> bool:
        """Take a sample, and return whether the rest has lasted for the time and the samples."""
        if not inside:
            self._samples = 0
            return False
        if not self._samples:
            self._since = stamp
        self._samples += 1
        return self._samples >= self._least and stamp - self._since >= self._time


class BarGuard:
    """
    Detects a pressure in bar that is given as Pa: it stays between 0.5 and some hundred.

    Once told, it is remembered until a value is no pressure in bar.
    """

    def __init__(self, below: float) -> None:
        self._below = below
        self._rest = _Rest(_BAR_TIME, _BAR_SAMPLES)
        self._told = False

    def check(self, stamp: int, value: float) -> str:
        """Return why a sample is implausible; empty if it is plausible."""
        inside = _LEAST_BAR <= value < self._below
        if not _LEAST_GAUGE_BAR <= value < self._below:
            self._told = False
        self._told |= self._rest.lasts(stamp, inside)
        return (f'looks like bar given as Pa, until it exceeds {self._below:g} Pa'
                if inside and self._told else '')


class GaugeGuard:
    """
    Detects an absolute pressure that is taken for a gauge pressure.

    It then rests near the pressure of the air, and never comes near zero. A brake that was seen
    released may be held at 1 bar, so it has to come back there from braking a few times.
    """

    def __init__(self) -> None:
        self._rest = _Rest(_REST_TIME, _REST_SAMPLES)
        self._released = self._braked = self._told = False
        self._returns = 0

    def check(self, stamp: int, value: float) -> str:
        """Return why a sample is implausible; empty if it is plausible."""
        low, high = _AIR
        rests = self._rest.lasts(stamp, low <= value <= high)
        if value < _RELEASED:
            self._released, self._braked, self._told, self._returns = True, False, False, 0
        elif value >= _BRAKED:
            self._braked = True
        elif rests and (self._braked or not self._released):
            self._returns, self._braked = self._returns + 1, False
            self._told = not self._released or self._returns >= _RETURNS
        return ('looks like an absolute pressure given as gauge (set its reference to absolute), '
                f'until it falls below {_RELEASED:g} Pa'
                if self._told else '')


class AbsoluteGuard:
    """Detects a gauge pressure that is taken for an absolute one: it rests at a vacuum."""

    def __init__(self) -> None:
        self._vacuum = _Rest(_VACUUM_TIME, _REST_SAMPLES)
        self._pressure = _Rest(_NO_VACUUM_TIME, _REST_SAMPLES)
        self._told = False

    def check(self, stamp: int, value: float) -> str:
        """Return why a sample is implausible; empty if it is plausible."""
        if self._pressure.lasts(stamp, value > _NO_VACUUM):
            self._told = False
        self._told |= self._vacuum.lasts(stamp, value < _VACUUM)
        return ('looks like a gauge pressure given as absolute (set its reference to gauge), '
                f'until it stays above {_NO_VACUUM:g} Pa for {_NO_VACUUM_TIME // _SECOND} '
                's' if self._told else '')


class _Speed(NamedTuple):
    stamp: int
    value: float  # rad/s


class _LongRamp:
    """
    Detects a speed that changes for a second as no vehicle's does.

    It has to do so in each fifth of the second and in one direction: a wheel that locks, a value
    that was silent or a changed sign leap and are then over.
    """

    def __init__(self, ramp: float, longest_gap: int) -> None:
        self._ramp, self._longest_gap = ramp, longest_gap
        self.forget()

    def forget(self) -> None:
        self._begin: int | None = None
        self._last = _Speed(0, 0.0)  # at the end of the last piece
        self._direction = self._pieces = 0

    def check(self, stamp: int, value: float) -> bool:
        """Take a sample, and return whether the change has lasted for a second."""
        passed = stamp - self._last.stamp
        if self._begin is None or not 0 <= passed <= max(self._longest_gap, _PIECE):
            self._start(stamp, value)
        elif passed >= _PIECE:
            change = value - self._last.value
            direction = round(math.copysign(1.0, change))
            if abs(change) * _SECOND <= self._ramp * passed:
                self._start(stamp, value)
            elif direction != self._direction:
                self._start(self._last.stamp, self._last.value)
                self._direction, self._pieces = direction, 1
            else:
                self._pieces += 1
            self._last = _Speed(stamp, value)
        assert self._begin is not None
        return self._pieces >= _PIECES and self._last.stamp - self._begin >= _RAMP_TIME

    def _start(self, stamp: int, value: float) -> None:
        self._begin, self._last = stamp, _Speed(stamp, value)
        self._direction = self._pieces = 0


class RpmGuard:
    """
    Detects a speed in rpm that is given as rad/s, and one that no wheel can have reached.

    A speed that leaps is held against the last one that was believed: where it is that speed in
    rpm, it goes on as rpm until it leaps back; any other leap is not believed for as long as a
    wheel would take, or until `memory` has passed. A speed that stays beyond the maximum, or that
    changes for a whole second as no vehicle does, is taken for rpm for a minute.

    Parameters
    ----------
    maximum : float
        Largest speed that can be believed [rad/s].
    leap : float
        Largest |d omega / d t| of a wheel, locking tyre included [rad/s^2].
    ramp : float
        The same over a second [rad/s^2].
    memory : float
        For how long the last speed counts [s].

    """

    def __init__(self, maximum: float, leap: float, ramp: float, memory: float) -> None:
        self._maximum, self._leap = maximum, leap
        self._memory = round(memory * _SECOND)
        self._last: _Speed | None = None
        self._ramp = _LongRamp(ramp, self._memory)
        self._beyond = _Rest(_BEYOND_TIME, 2)
        self._rpm = self._leaping = False
        self._low = False  # it leapt down by the same factor, so that it may leap back
        self._rpm_until: int | None = None  # None: until it leaps back

    def check(self, stamp: int, value: float) -> str:
        """Return why a sample is implausible; empty if it is plausible."""
        if abs(value) * RPM > self._maximum:
            return ''
        beyond = abs(value) > self._maximum
        spike = beyond > self._beyond.lasts(stamp, beyond)
        last, passed = self._last, 0 if self._last is None else abs(stamp - self._last.stamp)
        if last is None or passed > self._memory or self._forgiven(stamp):
            self._ramp.forget()
            return _TO_RPM if spike else self._believe(stamp, value, rpm=beyond, doubt=beyond)
        speed, seconds = abs(last.value), passed / _SECOND
        allowed = max(self._leap * seconds, _FLICKER + _SHARE * speed)
        change, as_rpm = abs(value - last.value), abs(value * RPM - last.value)
        nearer = as_rpm < change or as_rpm == change and speed <= _FLICKER  # both at rest
        if self._rpm and nearer and as_rpm <= allowed:
            doubt = self._ramp.check(stamp, value) or (beyond and not spike)
            return self._believe(stamp, value, rpm=True,
                                 doubt=doubt and self._rpm_until is not None)
        if change <= allowed:
            if self._rpm:  # it leaps back
                self._ramp.forget()
            doubt = self._ramp.check(stamp, value) or beyond
            return _TO_RPM if spike else self._believe(stamp, value, rpm=doubt, doubt=doubt)
        self._ramp.forget()
        near = _ALIKE * speed + _BRAKING * seconds
        returns = self._low and as_rpm <= near
        if not self._leaping and as_rpm <= near and not returns:
            self._rpm_until = None
            return self._believe(stamp, value, rpm=True)
        if not self._leaping:
            self._low = abs(value - last.value * RPM) <= near * RPM
        self._leaping = True
        return (f'leaps there from {last.value:.4g} rad/s within {seconds:.3g} s, until a wheel '
                'could be there')

    def _believe(self, stamp: int, value: float, *, rpm: bool, doubt: bool = False) -> str:
        if rpm != self._rpm:
            self._rpm_until = None
        if doubt:
            self._rpm_until = stamp + _DOUBT
        self._rpm, self._leaping = rpm, False
        self._last = _Speed(stamp, value * RPM if rpm else value)
        end = ('it leaps back' if self._rpm_until is None else
               f'{_DOUBT // _SECOND} s without another sign of it or a leap back')
        return f'{_TO_RPM}, until {end}' if rpm else ''

    def _forgiven(self, stamp: int) -> bool:
        """Return whether a temporary report is long past."""
        return self._rpm and self._rpm_until is not None and stamp > self._rpm_until


def unit_guards(signal: Signal, limits: InputSettings,
                settings: MonitorSettings) -> tuple[PlausibilityCheck, ...]:
    """Return the checks of an input's unit, by the settings."""
    guards: list[PlausibilityCheck] = []
    if signal == 'pressure' and settings.bar_suspected_below > 0.0:
        guards.append(BarGuard(settings.bar_suspected_below))
    if signal == 'pressure' and settings.reference_check:
        guards.append(GaugeGuard() if limits.reference == 'gauge' else AbsoluteGuard())
    if signal == 'rotor_speed' and settings.wheel_acceleration_peak > 0.0:
        guards.append(RpmGuard(limits.maximum, settings.wheel_acceleration_peak,
                               settings.wheel_acceleration_mean, limits.max_age))
    return tuple(guards)

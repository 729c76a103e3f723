"""What a signal's own history says against it: a wrong unit, or a value that no longer moves.

Each guard is handed samples in order of receipt and answers at once, so that its verdict belongs
to the sample and depends on no tick. A guard says '' for a sample it has nothing against.
"""

from dataclasses import dataclass
import math
from typing import NamedTuple, Protocol

from squeal_core.settings import MonitorSettings, Signal

RPM = math.tau / 60.0  # rad/s
_SECOND = 1_000_000_000

# Bar given as Pa: a released brake reads less in either unit; no brake is held so long in between.
_LEAST_BAR = 0.5
_BAR_TIME = _SECOND // 2
_BAR_SAMPLES = 10

_FLICKER, _SHARE = 2.0, 0.02  # rad/s and relative; less is the noise of a sensor and no leap
_ALIKE = 0.01  # by which the same speed may differ in rpm and in rad/s
_BRAKING = 3.0  # rad/s^2, by which a wheel changes meanwhile: 1 m/s^2
_RAMP_TIME = _SECOND
_DOUBT = 60 * _SECOND  # for which a speed that no vehicle has is remembered


class Guard(Protocol):
    """Judges the samples of one input."""

    def judge(self, stamp: int, value: float) -> str:
        """Return what is wrong with a sample, in words that follow its value; '' for nothing."""


class BarGuard:
    """Tells a pressure in bar that is given as Pa: it stays between 0.5 and some hundred.

    Once told, it is remembered until a value is too large for bar.
    """

    def __init__(self, below: float) -> None:
        self._below = below
        self._since = self._samples = 0
        self._told = False

    def judge(self, stamp: int, value: float) -> str:
        if abs(value) >= self._below:
            self._told = False
        if not _LEAST_BAR <= value < self._below:
            self._samples = 0
            return ''
        if not self._samples:
            self._since = stamp
        self._samples += 1
        if self._samples >= _BAR_SAMPLES and stamp - self._since >= _BAR_TIME:
            self._told = True
        return 'looks like bar given as Pa' if self._told else ''


class _Speed(NamedTuple):
    stamp: int
    value: float  # rad/s


class RpmGuard:
    """Tells a speed in rpm that is given as rad/s, and one that no wheel can have reached.

    A speed that leaps is held against the last one that was believed: where it is that speed in
    rpm, it goes on as rpm until it leaps back; any other leap is not believed for as long as a
    wheel would take, or until `memory` has passed. A speed beyond the maximum, or one that changes
    for a whole second as no vehicle does, is taken for rpm for a minute.

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
        self._maximum, self._leap, self._ramp = maximum, leap, ramp
        self._memory = round(memory * _SECOND)
        self._last: _Speed | None = None
        self._start: _Speed | None = None  # of the present second
        self._rpm = self._leaping = False
        self._rpm_until: int | None = None  # None: until it leaps back

    def judge(self, stamp: int, value: float) -> str:
        if abs(value) * RPM > self._maximum:
            return ''
        beyond = abs(value) > self._maximum
        last, passed = self._last, 0 if self._last is None else abs(stamp - self._last.stamp)
        if last is None or passed > self._memory or self._forgiven(stamp):
            return self._believe(stamp, value, rpm=beyond, doubt=beyond)
        speed, seconds = abs(last.value), passed / _SECOND
        allowed = max(self._leap * seconds, _FLICKER + _SHARE * speed)
        change, as_rpm = abs(value - last.value), abs(value * RPM - last.value)
        doubt = self._ramps(stamp, value) or beyond
        if self._rpm and as_rpm <= min(allowed, change):
            return self._believe(stamp, value, rpm=True,
                                 doubt=doubt and self._rpm_until is not None)
        if change <= allowed:
            return self._believe(stamp, value, rpm=doubt, doubt=doubt)
        if not self._leaping and as_rpm <= _ALIKE * speed + _BRAKING * seconds:
            self._rpm_until = None
            return self._believe(stamp, value, rpm=True)
        self._leaping, self._start = True, None
        return f'leaps there from {last.value:.4g} rad/s within {seconds:.3g} s'

    def _believe(self, stamp: int, value: float, *, rpm: bool, doubt: bool = False) -> str:
        if rpm != self._rpm:
            self._start = self._rpm_until = None
        if doubt:
            self._rpm_until = stamp + _DOUBT
        self._rpm, self._leaping = rpm, False
        self._last = _Speed(stamp, value * RPM if rpm else value)
        return 'looks like rpm given as rad/s' if rpm else ''

    def _ramps(self, stamp: int, value: float) -> bool:
        """Tell whether the speed changed over the last second as no vehicle's does."""
        start = self._start
        if start is not None and 0 <= stamp - start.stamp < _RAMP_TIME:
            return False
        self._start = _Speed(stamp, value)
        passed = _RAMP_TIME if start is None else stamp - start.stamp
        return start is not None and 0 < passed < 2 * _RAMP_TIME and (
            abs(value - start.value) * _SECOND > self._ramp * passed)

    def _forgiven(self, stamp: int) -> bool:
        """Tell whether what was told for a while is long past."""
        return self._rpm and self._rpm_until is not None and stamp > self._rpm_until


class StuckGuard:
    """Tells a value that stays exactly the same while the disc slides under load.

    A real sensor flickers in its last digit. A constant is no evidence by itself (a test bench,
    a mu that nobody estimates), so it counts only for an input that was seen to change, and while
    the other inputs of the brake go on changing.

    Parameters
    ----------
    after : float
        For how long, in sum over stretches of sliding [s]; 0: never.
    changes : int
        Changes that make an input a lively one.
    longest_gap : float
        Between samples that count as one stretch [s].
    """

    def __init__(self, after: float, changes: int, longest_gap: float) -> None:
        self._after, self._least_changes = round(after * _SECOND), changes
        self._longest_gap = round(longest_gap * _SECOND)
        self.changes = 0
        self._value = math.nan
        self._stamp = 0
        self._held = 0
        self._others_before = 0

    def judge(self, stamp: int, value: float, *, sliding: bool, others: int) -> str:
        """Judge a sample; `others` counts the changes of the brake's other inputs up to now."""
        if value != self._value:
            self.changes += 1
            self._value, self._held, self._others_before = value, 0, others
        elif sliding and 0 < stamp - self._stamp <= self._longest_gap:
            self._held += stamp - self._stamp
        self._stamp = stamp
        lively = min(self.changes - 1, others - self._others_before) >= self._least_changes
        if not self._after or self._held <= self._after or not lively:
            return ''
        return f'has been stuck there for {self._held / _SECOND:.1f} s of sliding'


@dataclass(frozen=True)
class _NoGuard:
    def judge(self, stamp: int, value: float) -> str:
        return ''


def unit_guard(signal: Signal, settings: MonitorSettings, maximum: float, max_age: float) -> Guard:
    """Return what looks after the unit of an input, as the settings want it."""
    if signal == 'pressure' and settings.bar_suspected_below > 0.0:
        return BarGuard(settings.bar_suspected_below)
    if signal == 'rotor_speed' and settings.wheel_acceleration_peak > 0.0:
        return RpmGuard(maximum, settings.wheel_acceleration_peak,
                        settings.wheel_acceleration_mean, max_age)
    return _NoGuard()

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

"""Evidence about the inputs of one brake, for comparison with the other brakes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math
from typing import NamedTuple, Self

from squeal_core.monitor.brake_settings import BrakeSettings
from squeal_core.monitor.inputs.reading import Reading
from squeal_core.monitor.inputs.signal_windows import SignalWindow, STEP
from squeal_core.monitor.setting_specs import Signal, UNITS

_SECOND = 1_000_000_000
_AGREEMENT = 3 * _SECOND // 10  # ns for which an input must agree again
COMPARED: tuple[Signal, ...] = ('rotor_speed', 'pressure', 'friction')
_UNTIL: dict[Signal, str] = {
    'pressure': 'until it brakes with 100000 Pa or more as the others do',
    'rotor_speed': 'until it turns as the others do, at 5 rad/s or more',
    'friction': 'until it is like the others while they brake'}
_PAST = (' is ', ' was '), (' falls ', ' fell '), ('alternates', 'alternated')
_OTHER_UNITS: dict[Signal, tuple[tuple[str, float], ...]] = {
    'pressure': (('kPa', 1e-3), ('hPa', 1e-2), ('MPa', 1e-6), ('psi', 1.0 / 6894.757),
                 ('bar', 1e-5)),
    'rotor_speed': (('rev/s', 1.0 / math.tau), ('rpm', 60.0 / math.tau),
                    ('deg/s', 360.0 / math.tau)),
    'friction': (('%', 100.0),)}


class Contradiction(NamedTuple):
    """Evidence against an input in one step, and how long it must last to be reported."""

    kind: str
    after: float  # s
    text: str
    adds_up: bool = False  # over brakings, until the input agrees
    until: str = ''  # if other than usual of the input


@dataclass
class Doubt:
    """
    Evidence against one input, and its report until the input agrees again.

    Parameters
    ----------
    until : str
        The end of what is told, in words; a contradiction may have its own.
    agreement : int
        For how long the input must agree then [ns].

    """

    until: str
    agreement: int = _AGREEMENT
    text: str = ''
    kind: str = ''
    _end: str = ''
    _present: bool = False
    _elapsed: dict[str, int] = field(default_factory=dict)  # ns by kind
    _adding: set[str] = field(default_factory=set)
    _agreed: int = 0

    def weigh(self, result: Sequence[Contradiction], *, agrees: bool) -> None:
        """Add the evidence of one step."""
        if agrees and not result:  # nearly always
            self._elapsed, self._present = {}, False
            self._agreed += STEP
            if self.text and self._agreed >= self.agreement:
                self.end()
            return
        kept = {kind: elapsed for kind, elapsed in self._elapsed.items() if kind in self._adding}
        self._elapsed = kept | {
            one.kind: self._elapsed.get(one.kind, 0) + STEP for one in result}
        self._adding |= {one.kind for one in result if one.adds_up}
        self._agreed = 0
        self._present = bool(result)
        told = [one for one in result if self._elapsed[one.kind] >= one.after * _SECOND]
        if told or (self.text and result):
            first = (told or result)[0]
            self.kind, self.text = first.kind, first.text
            self._end = first.until or self.until

    def end(self) -> None:
        """Withdraw the report."""
        self.text = self.kind = ''

    def pause(self) -> None:
        """Add a step without evidence."""
        self._agreed, self._present = 0, False

    def begin_anew(self) -> None:
        """Discard evidence that is not yet enough; what was reported stays."""
        self._elapsed.clear()
        self.pause()

    @property
    def said(self) -> str:
        """Return the fault in words, and until when it counts; '' for no fault."""
        text = self.text
        if text and not self._present:
            for now, then in _PAST:
                text = text.replace(now, then)
        return text and f'{text}, {self._end}'


class Wheel:
    """
    One brake: windows of its inputs, and the doubts about them.

    `pressure`, `smooth` (pressure over 0.5 s), `speed` and `friction` are those of the last step
    as far as they may be evidence against other brakes, else NaN.

    Parameters
    ----------
    brake : BrakeSettings

    """

    def __init__(self, brake: BrakeSettings) -> None:
        self.name = brake.name
        self.partner: Self | None = None
        self.others: list[Self] = []  # without the partner
        self.is_first = True  # of its axle, in the order of the settings: a side
        self.given_share = 0.0  # of its pressure in the mean of other axles; 0: learned
        self.windows = {signal: SignalWindow(one.max_age, one.minimum, one.maximum)
                        for signal, one in brake.inputs.items() if signal in COMPARED}
        self.forget()

    def update_settings(self, brake: BrakeSettings) -> None:
        """Apply other settings of the same inputs."""
        for signal, window in self.windows.items():
            one = brake.inputs[signal]
            window.update_settings(one.max_age, one.minimum, one.maximum)

    def forget(self, after: int | None = None) -> None:
        """Discard all samples; those up to a time [ns] stay where one is given."""
        for window in self.windows.values():
            window.forget(after)
        self.doubts = {signal: Doubt(_UNTIL[signal]) for signal in self.windows}
        self.alternation = Doubt('until it has been steady for 0.5 s', STEP)  # of the pressure
        # of each input to be checked; one without values if it is not there or not usable
        self.own: dict[Signal, SignalWindow] = {
            signal: self.windows.get(signal, _NOTHING) for signal in COMPARED}
        self.pressure = self.smooth = self.speed = self.friction = math.nan
        self.share = self.given_share  # given or learned; 0: not yet

    def use(self, inputs: Mapping[Signal, Reading]) -> None:
        """Use from now on the inputs whose own readings are believed."""
        for signal, window in self.windows.items():
            self.own[signal] = window if inputs[signal].is_believed else _NOTHING

    def begin_anew(self) -> None:
        """Discard evidence that is not yet enough."""
        for signal, window in self.windows.items():
            window.begin_anew()
            self.doubts[signal].begin_anew()
        self.alternation.begin_anew()

    def advance(self, end: int) -> None:
        """Process the samples up to the end of a step [ns]."""
        for signal, window in self.windows.items():
            window.advance(end, swings=signal == 'pressure')
        own, doubts = self.own, self.doubts
        pressure = _NOTHING if doubts['pressure'].text or self.alternation.text else (
            own['pressure'])
        self.pressure, self.smooth = pressure.mean, pressure.smooth
        self.speed = math.nan if doubts['rotor_speed'].text else abs(own['rotor_speed'].mean)
        self.friction = math.nan if self.is_doubted('friction') else own['friction'].mean

    @property
    def has_doubts(self) -> bool:
        """Return whether any input is doubted."""
        for doubt in self.doubts.values():  # each tick of each brake
            if doubt.text:
                return True
        return bool(self.alternation.text)

    def is_doubted(self, signal: Signal) -> bool:
        """Return whether an input is doubted."""
        doubt = self.doubts.get(signal)
        return bool(doubt is not None and doubt.text
                    or signal == 'pressure' and self.alternation.text)

    def doubted(self, signal: Signal) -> str:
        """Return the fault of an input by other brakes or its slew; '' for no fault."""
        told = self.doubts[signal].said if signal in self.doubts else ''
        return (signal == 'pressure' and self.alternation.said) or told


_NOTHING = SignalWindow(0.0, 0.0, 0.0)


def though(wheel: Wheel, other: Wheel, signal: Signal) -> str:
    """Return the contradicting input and value in words, and the unit that would explain it."""
    own, value = wheel.own[signal].mean, other.windows[signal].mean
    shown = f'{value:.6g} {UNITS[signal]}'.removesuffix(' -')
    hint = next((f', as {unit} given as {UNITS[signal]} would be'
                 for unit, scale in _OTHER_UNITS[signal]
                 if value and abs(own / value / scale - 1.0) < 0.06), '')
    return f'though {other.name} {signal} is {shown}{hint}'

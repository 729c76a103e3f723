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
How far the brake is from squeal: critical friction, speed and pressure, a solve at a time.

A search walks away from the point in steps until growth begins (or ends, where the brake squeals
now), narrows the step it happened in, and confirms both ends of the bracket in the full problem,
by full solutions where the modes next to the verdict were not solved for in it. It does one solve
at each call; what it found is stamped with the time and the inputs it began with, and stands for a
while where these rest.

I. F. D. Oliveira, R. H. C. Takahashi, ACM Trans. Math. Softw. 47 (2021) 5, is where the narrowing
is from: hardly ever more solves than by halves, and a third of them where growth is smooth.
"""

from collections.abc import Callable, Generator
from dataclasses import dataclass, field, replace
import math
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.margin import (
    Kind,
    Margin,
    Margins,
    MarginSettings,
    Parameter,
    SlidingConditions,
)
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Mode, Tolerances
from squeal_core.surrogate.steps import Call, completed, in_a_step, Steps

Solve: TypeAlias = Callable[[OperatingPoint], 'Steps[ComplexModes]']
_TURNS: tuple[Parameter, ...] = ('friction', 'rotor_speed', 'friction', 'pressure')

_NONE = Mode(0, complex(-math.inf, math.nan), 'stable')
_ASIDE = 0.2  # part of the first bracket by which a solve is off the straight line
_THROUGH = 0.1  # part of the first step's change of growth that is left in a bracket through zero

_End: TypeAlias = tuple[float, Mode]
# a call that is to be made, or None where a solve is done
_Solving: TypeAlias = Generator[Call | None, Any, Mode]
_Searching: TypeAlias = Generator[Call | None, Any, Margin]
_Round: TypeAlias = Generator[Call | None, Any, None]


@dataclass
class _Line:
    """What was solved along one parameter through given inputs."""

    parameter: Parameter
    inputs: SlidingConditions
    time: int
    solves: int = 0
    known: dict[tuple[float, bool], ComplexModes] = field(default_factory=dict)


class MarginSearch:
    """
    Margins of one brake, one solve at each call. The same calls give the same margins.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    solve : callable
        Complex modes at a point, in steps, as `TabulatedSolver.solving` of a table of its own.
    band_hz : (2,) floats
        The squeal band.
    settings : MarginSettings, optional
    tolerances : Tolerances, optional
        What counts as oscillation and growth.
    confirm : callable, optional
        As `solve`, with the modes next to the verdict as the full problem has them; by a full
        solution where it is None.

    """

    def __init__(self, model: BrakeModel, solve: Solve, band_hz: tuple[float, float], *,
                 settings: MarginSettings | None = None,
                 tolerances: Tolerances | None = None, confirm: Solve | None = None) -> None:
        self.model, self.band_hz = model, band_hz
        self.settings = settings or MarginSettings()
        self.margins = Margins()
        self._solve = solve
        self._limits = tolerances or Tolerances.of(model)
        self._confirm = confirm or in_a_step(self._in_full)
        self._work: _Round | None = None
        self._inputs: SlidingConditions | None = None
        self._line: _Line | None = None
        self._time = 0

    def reset(self) -> None:
        """Forget what was found and what is being looked for."""
        self._work, self.margins = None, Margins()

    def advance(self, inputs: SlidingConditions, time: int) -> Margins:
        """
        Do one solve of the search that is on, or of the next one, from these inputs.

        Parameters
        ----------
        inputs : SlidingConditions
            Where the brake operates.
        time : int
            [ns].

        Returns
        -------
        Margins
            The last ones found; each says when and for which inputs.

        Raises
        ------
        numpy.linalg.LinAlgError
            Where a solve fails; the next call begins a search anew.

        """
        return completed(self.advancing(inputs, time))

    def advancing(self, inputs: SlidingConditions, time: int) -> 'Steps[Margins]':
        """Return the same as `advance`, in steps; if they are left off a search begins anew."""
        self._inputs = replace(inputs, rotor_speed=abs(inputs.rotor_speed))
        self._time = time
        work, self._work = self._work, None  # it is lost if it is left in the middle of a solve
        if work is None or self._line is None or not self._inputs.near(
                self._line.inputs, self.settings.change):
            work = self._round()
        call = next(work)
        while call is not None:
            try:
                found = yield call
            except np.linalg.LinAlgError as error:
                call = work.throw(error)
            else:
                call = work.send(found)
        self._work = work
        return self.margins

    def _round(self) -> _Round:
        """Search over and over, friction every other time, each from the inputs then."""
        while True:
            if all(self._rests(parameter) for parameter in _TURNS):
                yield None
            for parameter in _TURNS:
                if self._rests(parameter):
                    continue
                assert self._inputs is not None
                line = self._line = _Line(parameter, self._inputs, self._time)
                found = yield from self._search(line, 'squeal')
                self.margins = replace(self.margins, **{parameter: found})
                if parameter == 'friction':
                    groan = yield from self._search(line, 'groan')
                    divergence = yield from self._search(line, 'divergence')
                    self.margins = replace(self.margins, groan=groan, divergence=divergence)

    def _rests(self, parameter: Parameter) -> bool:
        """Whether the last margin along a parameter is of late, and from inputs as they are."""
        last: Margin | None = getattr(self.margins, parameter)
        if last is None or self._inputs is None:
            return False
        near, far = (rate > self._limits.growth for rate in last.growth_rates)
        if near == far and math.isfinite(last.critical):  # was not confirmed
            return False
        return (abs(self._time - last.time) < 1e9 * self.settings.rest
                and self._inputs.rests(last.inputs, self.settings))

    def _search(self, line: _Line, kind: Kind) -> _Searching:
        """Walk away from the inputs until the verdict changes, then halve the bracket."""
        start: float = getattr(line.inputs, line.parameter)
        first = yield from self._mode(line, start, kind)
        grows = first.growth_rate > self._limits.growth
        # more friction makes it grow, less of it ends it; of speed and pressure the nearer one
        ways = ((-1.0 if grows else 1.0,) if line.parameter == 'friction' else (1.0, -1.0))
        ends: dict[float, _End] = dict.fromkeys(ways, (start, first))
        while ends:
            for way in tuple(ends):
                near = ends[way]
                value = self.settings.moved(line.parameter, near[0], way)
                if value == near[0]:
                    del ends[way]
                    continue
                far = (value, (yield from self._mode(line, value, kind)))
                if (far[1].growth_rate > self._limits.growth) != grows:
                    return (yield from self._narrowed(line, kind, grows, (near, far)))
                ends[way] = far
        return _without(line, kind, grows, self.settings.bounds(line.parameter), first)

    def _narrowed(self, line: _Line, kind: Kind, grows: bool,
                  ends: tuple[_End, _End]) -> _Searching:
        near, far = ends
        wide = _gap(near, far)
        first = width = self.settings.width(line.parameter, (near[0], far[0]))
        tried = 0
        while width > 1.0:
            value = _between(near, far, self._limits.growth, first, width, tried)
            middle = (value, (yield from self._mode(line, value, kind)))
            if (middle[1].growth_rate > self._limits.growth) == grows:
                near = middle
            else:
                far = middle
            wide = wide if math.isfinite(wide) else _gap(near, far)
            width, tried = self.settings.width(line.parameter, (near[0], far[0])), tried + 1
        full = []
        for value, _ in (near, far):
            full.append((value, (yield from self._mode(line, value, kind, full=True))))
        near, far = full
        signs = [mode.growth_rate > self._limits.growth for _, mode in full]
        confirmed = signs == [grows, not grows]
        gap = _gap(near, far)
        through = math.isfinite(gap) and gap <= max(_THROUGH * wide, self._limits.growth)
        mode = max(near[1], far[1], key=lambda m: m.growth_rate)
        verb = 'ends' if grows else 'begins'
        reason = f'{kind} {verb} at {line.parameter} {0.5 * (near[0] + far[0]):.6g}'
        if not confirmed:
            reason += ', not confirmed in the full problem'
        elif not through:
            reason += ' by a jump: a mode leaves or enters the band'
        return Margin(
            parameter=line.parameter, kind=kind, time=line.time, inputs=line.inputs, grows=grows,
            critical=0.5 * (near[0] + far[0]), bracket=(near[0], far[0]),
            growth_rates=(near[1].growth_rate, far[1].growth_rate), index=mode.index,
            frequency_hz=mode.frequency_hz, converged=confirmed and through, reason=reason,
            solves=line.solves)

    def _mode(self, line: _Line, value: float, kind: Kind, *, full: bool = False) -> _Solving:
        """Return the least stable mode of a kind; a solve, unless it is known, ends the call."""
        modes = line.known.get((value, full))
        if modes is None:
            inputs = line.inputs.moved(line.parameter, value)
            point = self.model.operating_point(
                rotor_speed=inputs.rotor_speed, pressure=inputs.pressure,
                friction=inputs.friction)
            modes = yield from (self._confirm if full else self._solve)(point)
            modes = replace(modes, series=None)  # what the table drops is not kept alive here
            line.known[value, full] = line.known[value, modes.source != 'table'] = modes
            line.solves += 1
            yield None
        low, high = self.band_hz
        if kind == 'squeal':
            found = modes.least_stable(low, high)
        elif kind == 'groan':
            found = modes.least_stable(0.0, math.nextafter(low, 0.0))
        else:
            found = tuple(m for m in modes.unstable if m.kind == 'divergence')
        return found[0] if found else _NONE

    def _in_full(self, point: OperatingPoint) -> ComplexModes:
        return complex_modes(self.model, point, tolerances=self._limits)


def _without(line: _Line, kind: Kind, grows: bool, bounds: tuple[float, float],
             first: Mode) -> Margin:
    start: float = getattr(line.inputs, line.parameter)
    if line.parameter == 'friction':
        bounds = (start, bounds[0] if grows else bounds[1])
    verb = 'goes on' if grows else 'does not begin'
    return Margin(
        parameter=line.parameter, kind=kind, time=line.time, inputs=line.inputs, grows=grows,
        bracket=bounds, growth_rates=(first.growth_rate, first.growth_rate), solves=line.solves,
        reason=f'{kind} {verb} from {line.parameter} {bounds[0]:.6g} to {bounds[1]:.6g}')


def _between(near: _End, far: _End, level: float, first: float, width: float,
             tried: int) -> float:
    """
    Return where to solve next: about where a straight line through both ends has no growth.

    Off it by a little towards the middle, so that the other end comes near, too, and never so far
    from the middle that more solves would be needed than by halves, but for one.

    Parameters
    ----------
    near, far : (value, Mode)
        One end.
    level : float
        What counts as growth [1/s].
    first, width : float
        Of the bracket at first and now, over what it may be.
    tried : int
        Solves since then.

    """
    middle, span = 0.5 * (near[0] + far[0]), far[0] - near[0]
    below, above = (end[1].growth_rate - level for end in (near, far))
    if not math.isfinite(above - below):  # there is no mode on one side
        return middle
    line = near[0] + span * below / (below - above)
    towards = math.copysign(1.0, middle - line)
    aside = _ASIDE * abs(span) * width / first
    there = line + towards * aside if aside <= abs(middle - line) else middle
    most = 0.5 * abs(span) * max(2.0 ** (math.ceil(math.log2(first)) + 1 - tried) / width - 1.0,
                                 0.0)
    return there if abs(there - middle) <= most else middle - towards * most


def _gap(near: _End, far: _End) -> float:
    """Difference of growth rates [1/s]; infinite where there is no mode on one side."""
    gap = abs(far[1].growth_rate - near[1].growth_rate)
    return math.inf if math.isnan(gap) else gap

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

"""What is known of a brake that slides under load: its modes, its risk and its margins."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_stability import band_of, margin_settings, VehicleStability
from squeal_core.risk.margin import Margins, SlidingConditions
from squeal_core.risk.margin_search import MarginSearch
from squeal_core.risk.probability import Inputs, InputUncertainty, Risk
from squeal_core.stability.eigensolution import ComplexModes, Mode
from squeal_core.surrogate.steps import Steps
from squeal_core.surrogate.workers import Work

# of the search for margins at a time: the first one after a pause costs as much as the next three
_FEWEST_SOLVES, _MOST_SOLVES = 4, 8.0
_ANCHOR = 4.0  # full solves that an anchor costs as much as
_PATIENCE = 3.0  # times what an anchor may take: as the worker is that of all brakes


@dataclass(frozen=True, kw_only=True)
class BrakeStability:
    """
    What was found at one operating point.

    Parameters
    ----------
    point : OperatingPoint
    modes : ComplexModes
    worst : Mode or None
        The least stable mode that oscillates within the squeal band.
    risk : Risk
    margins : Margins
        The last ones found, each stamped.
    friction_margin : float
        Critical minus present friction [-]; NaN where nothing confirmed holds here.

    """

    point: OperatingPoint
    modes: ComplexModes
    worst: Mode | None
    risk: Risk
    margins: Margins
    friction_margin: float


class BrakeEvaluator:
    """
    One brake's way through operating points; the engines are those of all brakes.

    Parameters
    ----------
    engines : VehicleStability
    settings : MonitorSettings
    brake : str
        Which of the settings' brakes it is; empty: the first.

    """

    def __init__(self, engines: VehicleStability, settings: MonitorSettings,
                 brake: str = '') -> None:
        self._engines = engines
        names = [one.name for one in settings.brakes]
        self._place = names.index(brake) if brake else 0
        self.update_settings(settings)

    def update_settings(self, settings: MonitorSettings) -> None:
        """Take other settings; the search for margins begins anew."""
        self._settings = settings
        self._deviations = InputUncertainty(
            friction=settings.friction_deviation, pressure=settings.pressure_deviation,
            rotor_speed=settings.rotor_speed_deviation,
            contact_stiffness=settings.contact_stiffness_deviation)
        self._pace = MarginPace(self._engines, settings, self._place)

    def evaluate(self, rotor_speed: float, pressure: float, friction: float,
                 time: int) -> BrakeStability:
        """
        Return what is known at a speed [rad/s], pressure [Pa] and friction at a time [ns].

        Raises
        ------
        numpy.linalg.LinAlgError
            Where there is no eigensolution.

        """
        at = SlidingConditions(rotor_speed=rotor_speed, pressure=pressure, friction=friction)
        return evaluate_brakes([(self, at)], time)[0]

    def _inputs(self, at: SlidingConditions) -> Inputs:
        model = self._engines.model
        return Inputs(rotor_speed=at.rotor_speed, pressure=at.pressure, friction=at.friction,
                      contact_stiffness=model.contact_stiffness_at(
                          model.contact_pressure(at.pressure)))

    def _concluded(self, at: SlidingConditions, point: OperatingPoint, modes: ComplexModes,
                   risk: Risk, time: int) -> BrakeStability:
        margins, settings = self._pace.advance(at, time), self._settings
        return BrakeStability(
            point=point, modes=modes, risk=risk, margins=margins,
            worst=modes.worst_in(*band_of(settings)),
            friction_margin=friction_margin(margins, at, time, change=settings.margin_change,
                                            age=settings.margin_age))


def evaluate_brakes(brakes: Sequence[tuple[BrakeEvaluator, SlidingConditions]], time: int
                    ) -> list[BrakeStability]:
    """
    Return what is known of brakes of the same engines and settings at a time [ns].

    Raises
    ------
    numpy.linalg.LinAlgError
        Where there is no eigensolution for one of them.

    """
    first, engines = brakes[0][0], brakes[0][0]._engines
    inputs = [brake._inputs(at) for brake, at in brakes]
    points = [engines.model.operating_point(**vars(at)) for at in inputs]
    modes = engines.modes.complex_modes_of(points)
    risks = engines.risks.assess_together(list(zip(inputs, modes, strict=True)),
                                          first._deviations)
    return [brake._concluded(at, point, found, risk, time) for (brake, at), point, found, risk
            in zip(brakes, points, modes, risks, strict=True)]


class MarginPace:
    """
    Advances the margins of one brake at their own rate, slowly where the table is made.

    Brakes take turns: at each tick one of them hands a part of its search to a worker, and some
    turns later takes what came of it, once ticks have granted it its steps. So no tick waits for
    more than a step of a search, and the same ticks give the same margins.

    Parameters
    ----------
    engines : VehicleStability
    settings : MonitorSettings
    place : int
        Of the brake among the settings'.

    """

    def __init__(self, engines: VehicleStability, settings: MonitorSettings, place: int) -> None:
        self._engines, self._settings, self._place = engines, settings, place
        self._search = MarginSearch(engines.model, self._solve, band_of(settings),
                                    settings=margin_settings(engines.model, settings),
                                    tolerances=engines.tolerances,
                                    confirm=self._confirm)
        self._found = Margins()
        self._work: Work[Margins] | None = None
        self._credit, self._slow = 0.0, 0.0
        self._turns = len(settings.brakes)  # ticks from one turn of a brake to its next
        self._patience = max(1, math.ceil(
            _PATIENCE * settings.anchor_delay * settings.rate / self._turns))
        self._wait = 0  # turns

    def advance(self, inputs: SlidingConditions, time: int) -> Margins:
        """Go on with the search by what an assessment's share of it is; return what is known."""
        turn = time // self._settings.period % self._turns == self._place
        if turn:
            share = self._settings.margin_rate / self._settings.rate * self._turns
            self._credit = min(self._credit + share, _MOST_SOLVES)
            self._wait = max(self._wait - 1, 0)
        if self._wait == 0 and self._work is not None and self._engines.granted(self._work):
            self._take(self._work)
        solves = math.floor(self._credit)
        if turn and self._work is None and self._wait == 0 and solves >= _FEWEST_SOLVES:
            self._credit -= solves
            self._wait = self._patience
            self._work = self._engines.beside(self._advance(inputs, time, solves))
        return self._found

    def _take(self, work: Work[Margins]) -> None:
        """Take what the worker found; after a full solve or an anchor it has a pause."""
        self._work = None
        if not work.finished:  # and never will be: the engines' workers were ended
            return
        self._found = work.result()
        if self._slow:
            turns = self._slow * self._settings.rate / (
                self._settings.margin_full_rate * self._turns)
            self._credit, self._wait = 0.0, max(0, math.ceil(turns) - self._patience)

    def _advance(self, inputs: SlidingConditions, time: int, solves: int) -> 'Steps[Margins]':
        """Do so many solves of the search, or the first slow one."""
        self._slow = 0.0
        for _ in range(solves):
            try:
                yield from self._search.advancing(inputs, time)
            except np.linalg.LinAlgError:
                self._slow = 1.0  # begins anew, later
            if self._slow:
                break
        return self._search.margins

    def _solve(self, point: OperatingPoint) -> 'Steps[ComplexModes]':
        return self._timed(self._engines.margins.solving(point))

    def _confirm(self, point: OperatingPoint) -> 'Steps[ComplexModes]':
        return self._timed(self._engines.confirming(point))

    def _timed(self, solving: 'Steps[ComplexModes]') -> 'Steps[ComplexModes]':
        """Solve; note what it costs, in full solves, if it is one or an anchor was made for it."""
        made = self._engines.margins.statistics.made
        found = yield from solving
        self._slow += float(found.source == 'full')
        self._slow += _ANCHOR * (self._engines.margins.statistics.made - made)
        return found


def friction_margin(margins: Margins, inputs: SlidingConditions, time: int, *,
                    change: float, age: float) -> float:
    """
    Return critical minus present friction; NaN where what is known holds no more.

    Parameters
    ----------
    margins : Margins
        Settings and inputs of the search.
    inputs : SlidingConditions
        The present ones.
    time : int
        [ns].
    change : float
        Of speed and pressure since the search began, relative, that is let pass.
    age : float
        Likewise of the time [s].

    """
    found = margins.friction
    if found is None or not (found.converged and abs(time - found.time) <= 1e9 * age
                             and inputs.near(found.inputs, change)):
        return math.nan
    return found.critical - inputs.friction

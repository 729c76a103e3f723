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

"""Squeal risk of a vehicle's brakes, through their brake applications."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
import math
from typing import TypeAlias

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.calibration.calibration_file import check_domain, read_calibration
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.assessment import Assessment, AssessmentContext, PreparedTick
from squeal_core.monitor.brake_risk import BrakeRisk, unknown_risk
from squeal_core.monitor.brake_stability import BrakeStability
from squeal_core.monitor.emulator_statistics import EmulatorStatistics
from squeal_core.monitor.risk_warnings import NONE, risk_warnings, why_unknown
from squeal_core.monitor.settings import band_of, ensemble_prior, MonitorSettings
from squeal_core.monitor.tick_turns import is_due
from squeal_core.monitor.vehicle_stability import Evaluated
from squeal_core.risk.application_risk import ApplicationRisk
from squeal_core.risk.emulator_file import named_emulator
from squeal_core.risk.ensemble import Ensemble, prior_ensemble
from squeal_core.risk.first_order import first_order_instability
from squeal_core.risk.growth_emulator import GrowthEmulator
from squeal_core.risk.risk_records import (
    ApplicationState,
    MemberGrowth,
    RiskResult,
    RiskSettings,
)
from squeal_core.risk.squeal_risk import SquealRisk

OUTSIDE = 'outside the range of the growth emulator'
_AT_ONCE = 16  # operating points that are evaluated at once: some three MB
_GAP = 0.5  # s between two evaluations, or 1.5 intervals, of more than which nothing is known

_Step: TypeAlias = tuple[Assessment | AssessmentContext, BrakeStability | None, bool]
_Found: TypeAlias = BrakeRisk | ApplicationState | None


class VehicleRisk:
    """
    Evaluates the risk of brakes, tick after tick in the order of time, by their applications.

    A brake is evaluated at its first tick of sliding under load, and then `risk_rate` times a
    second of absolute time, all brakes at once, as four cost little more than two one by one; in
    between its risk is held.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    settings : MonitorSettings

    Attributes
    ----------
    unknown : str
        Why the squeal risk of no brake is known, and the remedy; empty where it is.
    warnings : tuple of str
        What of the settings does not suit the squeal risk, with remedies.

    Raises
    ------
    TableFileError
        Where the settings name an emulator or a calibration that cannot be used.

    """

    def __init__(self, model: BrakeModel, settings: MonitorSettings) -> None:
        self._model, self._prior = model, ensemble_prior(settings)
        self._loaded = ensemble_risk(model, settings)
        self._statistics = EmulatorStatistics()
        self.reset()
        self.update_settings(settings)

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings; brake applications stay, unless the band is another one."""
        self._period, self._interval = settings.period, settings.risk_interval
        self._audit_every, self._settings = round(settings.audit_interval), risk_settings(settings)
        loaded = self._loaded
        if loaded is not None and loaded.settings.band_hz != self._settings.band_hz:
            self._loaded = SquealRisk(loaded.emulator, loaded.ensemble, self._settings)
            self.reset()
        elif loaded is not None:
            loaded.settings = self._settings
        self.unknown = why_unknown(self._loaded, settings)
        self.warnings = risk_warnings(self._loaded, settings)
        self._risk = None if self.unknown else self._loaded
        self._places = {} if self._risk is None else {
            number: place for place, family in enumerate(self._risk.families.tolist())
            for number in self._risk.emulator.families[family].numbers}

    @property
    def squeal_risk(self) -> SquealRisk | None:
        """Return the ensemble and its emulator; None without one for the squeal band."""
        return self._risk

    def reset(self) -> None:
        """Forget all brake applications."""
        self._planned, self._taken = 0, 0  # times of the last ticks [ns]
        self._sliding: set[str] = set()
        self._applications: dict[str, ApplicationRisk] = {}
        self._shown: dict[str, _Found] = {}

    def warm_up(self, brakes: Sequence[str], result: Sequence[Evaluated]) -> None:
        """Evaluate brakes once, uncounted."""
        self.evaluate([tuple(AssessmentContext(name, 0, {}) for name in brakes)], result)
        self.reset()

    @property
    def note(self) -> str:
        """Return the basis of the risk, in a line for a log; empty where no risk is known."""
        if self._risk is None:
            return ''
        error = self._risk.emulator.error
        return (f'squeal risk by an ensemble of {self._risk.ensemble.weights.size}, growth rates '
                f'within {error.rms:.2g} 1/s (rms); {self._risk.basis}')

    def figures(self) -> dict[str, float]:
        """Return the counts of evaluations since the start, by name."""
        return {f'emulator_{name}': value for name, value in asdict(self._statistics).items()}

    def evaluate(self, ticks: Sequence[PreparedTick],
                 result: Sequence[Evaluated]) -> list[BrakeRisk | None]:
        """
        Return the risk of each brake at each tick: while it slides, and of the end at a release.

        None where there is none, or the stability of the brake is not known.

        Parameters
        ----------
        ticks : sequence of PreparedTick
            In order of time, none left out.
        result : sequence of BrakeStability or LinAlgError
            Of each context among them.

        """
        risks: list[BrakeRisk | None] = []
        steps, due = list[_Step](), 0
        for step in self._plan(ticks, iter(result)):
            steps.append(step)
            due += step[2]
            if due == _AT_ONCE:
                risks += self._take(steps)
                steps, due = [], 0
        return risks + self._take(steps)

    def _take(self, steps: Sequence[_Step]) -> list[BrakeRisk | None]:
        """Take what is known of brakes at ticks into their applications; return their risks."""
        growths = self._growths([at.point for _, at, due in steps if at and due])
        result = [self._step(one, at, next(growths) if at and due else None, due=due)
                  for one, at, due in steps]
        states = {id(state): state for state in result if isinstance(state, ApplicationState)}
        risks: dict[int, BrakeRisk] = {} if self._risk is None or not states else dict(zip(
            states, map(self._known, self._risk.assess([*states.values()])), strict=True))
        self._shown |= {brake: risks[id(shown)] for brake, shown in self._shown.items()
                        if isinstance(shown, ApplicationState)}
        return [risks[id(one)] if isinstance(one, ApplicationState) else one for one in result]

    def _plan(self, ticks: Sequence[PreparedTick],
              result: Iterator[Evaluated]) -> Iterator[_Step]:
        """Yield each brake at each tick, its stability, and whether its risk is evaluated."""
        for tick in ticks:
            if not 0 <= tick[0].time - self._planned <= 1e9 * self._settings.longest_interval:
                self._sliding.clear()
            self._planned = tick[0].time
            for one in tick:
                at = next(result) if isinstance(one, AssessmentContext) else None
                if not isinstance(at, BrakeStability):
                    self._sliding.discard(one.brake)
                    yield one, None, False
                    continue
                due = one.brake not in self._sliding or is_due(
                    one.time, self._period, self._interval)
                self._sliding.add(one.brake)
                yield one, at, due

    def _growths(self, points: Sequence[OperatingPoint]) -> Iterator[MemberGrowth | None]:
        """Yield the growth of the ensemble at points; None without an emulator."""
        if self._risk is None or not points:
            yield from [None] * len(points)
            return
        growth = self._risk.growth(
            [abs(at.rotor_speed) for at in points], [at.contact_pressure for at in points],
            [abs(at.friction) for at in points], [at.contact_stiffness for at in points])
        yield from map(growth.at, range(len(points)))

    def _step(self, one: Assessment | AssessmentContext, at: BrakeStability | None,
              growth: MemberGrowth | None, *, due: bool) -> _Found:
        """Take a tick of a brake into its application; return its risk, or what gives it."""
        if one.time < self._taken:  # the clock was set back
            self._applications.clear()
        self._taken = one.time
        if at is None:
            return self._pass(one)
        if due:
            self._shown[one.brake] = self._evaluated(one, at, growth)
        elif self._risk is not None:
            self._application(one.brake).hold(one.time)
        return self._shown[one.brake]

    def _pass(self, one: Assessment | AssessmentContext) -> ApplicationState | None:
        """Take a tick at which a brake does not slide under load, or nothing is known of it."""
        if self._risk is None:
            return None
        application = self._application(one.brake)
        state = one.state if isinstance(one, Assessment) else 'invalid'
        if state == 'released':
            return application.end(one.time)
        if state == 'not sliding':
            application.rest(one.time)
        else:
            application.skip(one.time)
        return None

    def _evaluated(self, one: Assessment | AssessmentContext, at: BrakeStability,
                   growth: MemberGrowth | None) -> BrakeRisk | ApplicationState:
        if growth is None:
            return unknown_risk(first_order_instability(
                self._model, at.point, at.modes, self._settings.band_hz, self._prior,
                self._settings.instability_damping_ratio), 'first order', self.unknown)
        assert self._risk is not None
        self._statistics.count(self._risk, at.point, self._audit_every)
        state = self._application(one.brake).advance(one.time, growth)
        return unknown_risk(math.nan, OUTSIDE, OUTSIDE) if state is None else state

    def _known(self, result: RiskResult) -> BrakeRisk:
        assert self._risk is not None
        families = self._risk.emulator.families
        return BrakeRisk(result=result, places=self._places, modes=(
            families[result.family].numbers if result.family >= 0 else ()))

    def _application(self, brake: str) -> ApplicationRisk:
        assert self._risk is not None
        if brake not in self._applications:
            self._applications[brake] = ApplicationRisk(self._risk)
        return self._applications[brake]


def risk_settings(settings: MonitorSettings) -> RiskSettings:
    """Return the settings of the squeal risk from those of a monitor."""
    interval = 1.0 / min(settings.rate, settings.risk_rate)
    return RiskSettings(
        band_hz=band_of(settings), noise_floor=1e-9 * settings.noise_floor_nm,
        instability_damping_ratio=settings.instability_damping_ratio,
        longest_interval=max(_GAP, 1.5 * interval))


def ensemble_risk(model: BrakeModel, settings: MonitorSettings) -> SquealRisk | None:
    """
    Return the ensemble of brakes that the settings name, with its emulator; None without one.

    Raises
    ------
    SquealError
        Where the settings name an emulator or a calibration that cannot be used.

    """
    if settings.growth_emulator == NONE:
        return None
    emulator = named_emulator(settings.growth_emulator, model)
    if emulator is None:
        return None
    return SquealRisk(emulator, _ensemble(model, settings, emulator),
                      risk_settings(settings))


def _ensemble(model: BrakeModel, settings: MonitorSettings, emulator: GrowthEmulator) -> Ensemble:
    if not settings.calibration:
        return prior_ensemble(ensemble_prior(settings))
    ensemble = read_calibration(settings.calibration, model)
    check_domain(settings.calibration, ensemble, emulator.domain)
    return ensemble

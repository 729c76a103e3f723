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
Sensitivity of growth, stability boundary and risk to each parameter of a brake, per cent.

Derivatives are of eigenvalues, by left and right vectors, with matrices that are affine in a
parameter or rebuilt at changed values. Each is checked by the eigenvalues of models at +-1 %.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
import math
from typing import Protocol

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import OperatingPointError, solver_errors, SquealError
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.ensemble import EnsemblePrior, prior_ensemble
from squeal_core.risk.steady_braking import SteadyBraking
from squeal_core.stability.eigensolution import SQUEAL_BAND, Tolerances
from squeal_core.stability.mode_tracking import identify, Tracked
from squeal_core.stability.parameter_paths import moved
from squeal_core.studies.design_effects import (
    CHECK,
    eigenvalue_slopes,
    matrix_change,
    ModeFollower,
    PER_CENT,
    Variant,
    Vary,
)
from squeal_core.studies.target_modes import target_modes, TargetMode

_AGREE, _SMALL = 0.25, 0.02  # of a growth rate's change, and of a small one [1/s]
OPERATING = ('friction', 'rotor_speed', 'contact_pressure')
"""Parameters of the operating point that are varied beside those of the brake."""


class Variants(Protocol):
    """Models at changed parameters, as `assembly.variants.BrakeVariants`."""

    model: BrakeModel

    def __call__(self, path: str, factor: float) -> BrakeModel: ...

    def affine(self, path: str) -> bool: ...


@dataclass(frozen=True)
class ModeEffect:
    """
    Effect of one per cent more of a parameter on a mode; NaN where not known.

    Parameters
    ----------
    growth_rate, frequency_hz : float
        Derivatives, per cent [1/s], [Hz].
    error : float
        Of `growth_rate`: its difference from that of eigenvalues at +-1 % [1/s].
    at_minus, at_plus : float
        Change of the growth rate at -1 % and +1 %, by eigenvalues [1/s].
    critical_friction : float
        Change of the critical friction per cent [-].
    others : tuple of float
        Changes of growth rate of the target's `others` per cent [1/s].

    """

    growth_rate: float
    frequency_hz: float
    error: float
    at_minus: float
    at_plus: float
    critical_friction: float
    others: tuple[float, ...]

    @property
    def reliable(self) -> bool:
        """Return whether derivative and differences agree, as all that rests on them requires."""
        return self.error <= _AGREE * max(abs(self.growth_rate), _SMALL)


@dataclass(frozen=True)
class ParameterEffect:
    """
    Effect of one per cent more of a parameter.

    Parameters
    ----------
    parameter : str
        Path in the description, or parameter of the operating point.
    modes : tuple of ModeEffect
        Of each target.
    risk : tuple of float
        Change of the squeal risk at each target's operating point per cent [-].
    reason : str
        Why it is not known; empty where it is.

    """

    parameter: str
    modes: tuple[ModeEffect, ...] = ()
    risk: tuple[float, ...] = ()
    reason: str = ''


@dataclass(frozen=True)
class SensitivityStudy:
    """
    Target modes, and the models and points in which parameters vary.

    Parameters
    ----------
    variants : callable
        Models by parameter and factor.
    points : tuple of callables
        Operating point of each target in a model: the same driving.
    targets : tuple of TargetMode
    tracked : tuple of Tracked
        All modes at each target's point.
    braking : tuple of SteadyBraking
        At each target's point; empty: no risk.

    """

    variants: Variants
    points: tuple[Callable[[BrakeModel], OperatingPoint], ...]
    targets: tuple[TargetMode, ...]
    tracked: tuple[Tracked, ...] = field(repr=False)
    braking: tuple[SteadyBraking, ...] = ()

    def risks(self) -> tuple[float, ...]:
        """Return the squeal risk at each target's point as the brake is."""
        return tuple(braking.risk for braking in self.braking)  # solved once, for workers too

    def effect(self, parameter: str) -> ParameterEffect:
        """Return the effect of a parameter; what keeps it from being known is in `reason`."""
        models: dict[float, BrakeModel] = {}

        def vary(place: int, factor: float) -> Variant:
            if parameter in OPERATING:
                base = self.variants.model
                point = self.points[place](base)
                return Variant(base, moved(base, point, parameter,
                                           factor * getattr(point, parameter)))
            if factor not in models:
                models[factor] = self.variants(parameter, factor)
            return Variant(models[factor], self.points[place](models[factor]))

        try:
            with solver_errors('cannot be computed'):
                effects = tuple(self._of_mode(place, parameter, partial(vary, place))
                                for place in range(len(self.targets)))
                risks = {id(braking): self._risk(place, partial(vary, place))
                         for place, braking in enumerate(self.braking)
                         if self.braking.index(braking) == place}
        except SquealError as error:
            return ParameterEffect(parameter, reason=str(error))
        return ParameterEffect(parameter, effects, tuple(
            risks[id(braking)] for braking in self.braking))

    def _of_mode(self, place: int, parameter: str, vary: Vary) -> ModeEffect:
        target, model = self.targets[place], self.variants.model
        eigenvalues = [target.eigenvalue, *(eigenvalue for _, eigenvalue in target.others)]
        slopes = PER_CENT * eigenvalue_slopes(model, target.point, eigenvalues,
                                              [matrix_change(vary)])[:, 0]
        follower = ModeFollower(model, target.point, self.tracked[place],
                                Tolerances.of(model, target.point))
        minus, plus = (follower.eigenvalues(vary(factor), [target.identity])[0]
                       - target.eigenvalue for factor in (1.0 - CHECK, 1.0 + CHECK))
        difference = PER_CENT * (plus - minus) / (2.0 * CHECK)
        return ModeEffect(
            growth_rate=float(slopes[0].real), frequency_hz=float(slopes[0].imag) / math.tau,
            error=abs(float((slopes[0] - difference).real)), at_minus=float(minus.real),
            at_plus=float(plus.real), critical_friction=self._critical(target, parameter, vary),
            others=tuple(slopes[1:].real.tolist()))

    def _critical(self, target: TargetMode, parameter: str, vary: Vary) -> float:
        """Return the change of the critical friction per cent: - (d sigma/dp) / (d sigma/d mu)."""
        critical, model = target.critical_friction, self.variants.model
        if math.isnan(critical) or parameter == 'friction':
            return math.nan

        def there(factor: float) -> Variant:
            variant = vary(factor)
            return Variant(variant.model, moved(variant.model, variant.point, 'friction',
                                                critical))

        point = there(1.0).point if parameter in OPERATING else moved(
            model, target.point, 'friction', critical)

        def along_friction(factor: float) -> Variant:
            return Variant(model, moved(model, point, 'friction', factor * critical))

        by_parameter, by_friction = eigenvalue_slopes(
            model, point, [target.critical_eigenvalue],
            [matrix_change(there), matrix_change(along_friction)])[0].real
        return float(-PER_CENT * critical * by_parameter / by_friction)

    def _risk(self, place: int, vary: Vary) -> float:
        braking, model = self.braking[place], self.variants.model

        def slopes(member: int, eigenvalues: Sequence[complex]) -> FloatArray:
            def own(factor: float) -> Variant:
                variant = vary(factor)
                return Variant(variant.model, braking.member_point(variant.point, member))
            point = braking.member_point(braking.point, member)
            return eigenvalue_slopes(model, point, eigenvalues, [matrix_change(own)])[:, 0].real

        return braking.risk_change(slopes, PER_CENT)

    def effects(self, parameters: Sequence[str], *, workers: int = 0,
                progress: Callable[[int, int], None] = lambda *_: None
                ) -> tuple[ParameterEffect, ...]:
        """
        Return the effects of parameters, in their order.

        Parameters
        ----------
        parameters : sequence of str
            Paths of the description, or of `OPERATING`.
        workers : int
            Processes; 0: this one.
        progress : callable
            Told how many are done, and of how many.

        """
        jobs: Mapping[int, tuple[str]] = {
            place: (parameter,) for place, parameter in enumerate(parameters)}
        result: dict[int, ParameterEffect] = {}
        for place, effect in run_jobs(self.effect, jobs, workers):
            result[place] = effect
            progress(len(result), len(jobs))
        return tuple(result[place] for place in range(len(jobs)))


def make_study(variants: Variants, points: Sequence[Callable[[BrakeModel], OperatingPoint]],
               numbers: Sequence[Collection[int]], *, count: int = 1, duration: float = 3.0,
               with_risk: bool = True, prior: EnsemblePrior | None = None,
               band_hz: tuple[float, float] = SQUEAL_BAND) -> SensitivityStudy:
    """
    Return the study of chosen modes, or of the least stable ones, at operating points.

    Parameters
    ----------
    variants : callable
        Models by parameter and factor, and the model as it is.
    points : sequence of callables
        Operating points by model.
    numbers : sequence of collections of int
        Modes that are meant at each point; an empty one: the `count` least stable of the band.
    count : int
        Of modes at a point where none is chosen.
    duration : float
        Of the braking whose risk is computed [s].
    with_risk : bool
        Whether the risk is computed: 64 full solutions for each value of each parameter.
    prior : EnsemblePrior, optional
        Of the ensemble of brakes.
    band_hz : (2,) floats
        Squeal band.

    """
    model, result = variants.model, []
    for point_of, chosen in zip(points, numbers, strict=True):
        point = point_of(model)
        tracked = identify(model, point)
        result += [(point_of, target, tracked) for target in target_modes(
            model, point, tracked, chosen, count, band_hz)]
    if not result:
        raise OperatingPointError(
            f'no mode oscillates in {band_hz[0]:g} to {band_hz[1]:g} Hz; choose modes')
    braking: dict[OperatingPoint, SteadyBraking] = {}
    if with_risk:
        ensemble = prior_ensemble(prior or EnsemblePrior())
        braking = {target.point: SteadyBraking(model, target.point, ensemble, duration, band_hz)
                   for _, target, _ in result}
    point_ofs, targets, tracks = zip(*result, strict=True)
    return SensitivityStudy(variants, point_ofs, targets, tracks, tuple(
        braking[target.point] for target in targets) if braking else ())

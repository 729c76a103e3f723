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
Squeal risk: the probability that some mode's build-up exceeds what is audible.

An ensemble of brakes stands for what is not known of a brake and stays (damping, contact
stiffness, bias of friction ...). Each member has the build-up of each of its mode families, at
nodes of the scatter of friction and damping from application to application.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.build_up import nepers, saturation_energy
from squeal_core.risk.ensemble import Ensemble
from squeal_core.risk.risk_records import (
    BuildUpState,
    families_in,
    GrowthSource,
    MemberGrowth,
    RiskResult,
    RiskSettings,
)
from squeal_core.risk.scatter import along_scatter, exceedance, MIDDLE, NODES, WEIGHTS

__all__ = ['GrowthSource', 'MemberGrowth', 'RiskResult', 'RiskSettings', 'SquealRisk']

LEAST_KNOWN = 0.5  # weight of members inside the emulator's domain, below which no risk is known
_NEVER = -1e9  # 1/s
_MOSTLY_PRIOR = 0.5  # power of the likelihood below which a calibration hardly moves the level
_PRIOR = 'the level of the risk is mostly the prior of damping'


class SquealRisk:
    """
    Evaluates an ensemble of brakes; keeps no state.

    Parameters
    ----------
    emulator : GrowthSource
        Growth of mode families.
    ensemble : Ensemble
        M brakes, their weights, and the scatter inside each.
    settings : RiskSettings, optional

    Attributes
    ----------
    families : (F,) array
        Indices of the emulator's families in the squeal band.
    decay : (F, M) array
        Their own decay rates [1/s].

    """

    def __init__(self, emulator: GrowthSource, ensemble: Ensemble,
                 settings: RiskSettings | None = None) -> None:
        self.emulator, self.ensemble = emulator, ensemble
        self.settings = settings or RiskSettings()
        self.families, _, decay = families_in(self.settings.band_hz, emulator.families)
        self.decay: FloatArray = np.exp(ensemble.ln_damping) * decay[:, None]
        self.basis = ensemble.calibrated or 'not calibrated'
        if not ensemble.calibrated or ensemble.likelihood_power < _MOSTLY_PRIOR:
            self.basis += f': {_PRIOR}'
        self._coordinates = np.column_stack([
            np.ones_like(ensemble.weights), ensemble.ln_damping, ensemble.ln_contact_stiffness,
            ensemble.friction_bias, ensemble.slope_scale, ensemble.audible_build_up])
        root = np.sqrt(ensemble.weights)
        self._fit = np.linalg.pinv(root[:, None] * self._coordinates) * root

    def growth(self, rotor_speed: ArrayLike, contact_pressure: ArrayLike, friction: ArrayLike,
               contact_stiffness: ArrayLike) -> MemberGrowth:
        """
        Return the growth of all members at ticks, of one brake or of several.

        Parameters
        ----------
        rotor_speed, contact_pressure, friction, contact_stiffness : (...) array_like
            [rad/s], p0 [Pa], mu [-], k_c of the model at p0 [N/m^3].

        """
        members = self.ensemble
        inputs = members.inputs(rotor_speed, contact_pressure, friction)
        # one tick at a time: their terms fit into the cache, and bits are those of single ticks
        ticks = [self.emulator.evaluate(tick) for tick in inputs.reshape(-1, *inputs.shape[-2:])]
        stiffness = np.asarray(contact_stiffness)[..., None] * np.exp(inputs[..., 3])
        cap = saturation_energy(np.exp(inputs[..., 1]), stiffness, self.settings.noise_floor)
        rate, frequency, by_friction, by_damping = (
            np.stack([getattr(tick, name)[:, self.families].T for tick in ticks]).reshape(
                *inputs.shape[:-2], self.families.size, members.count)
            for name in ('growth_rate', 'frequency_hz', 'by_friction', 'by_damping'))
        return MemberGrowth(
            rate, frequency, along_scatter(members.friction_scatter * by_friction,
                                           members.damping_scatter * by_damping), cap)

    def at_nodes(self, growth: MemberGrowth) -> FloatArray:
        """Return the growth rates of a tick at the nodes of the scatter, (7, F, M)."""
        return np.asarray(growth.rate + NODES[:, None, None] * growth.scatter)

    def exceedances(self, energy: FloatArray) -> FloatArray:
        """Return the probability in each member (M,) that energies (7, F, M) exceed N*."""
        return exceedance(self._margin(energy.max(axis=1, initial=1.0)))

    def _margin(self, energy: FloatArray) -> FloatArray:
        """Return the build-up of energies (..., M) less N*."""
        return nepers(energy) - self.ensemble.audible_build_up

    def assess(self, state: BuildUpState, growth: MemberGrowth,
               rates: FloatArray) -> RiskResult | None:
        """
        Return the risk of a state; None where the emulator knows less than half of the members.

        Parameters
        ----------
        state : BuildUpState
            Of the application up to the tick.
        growth : MemberGrowth
            At the tick.
        rates : (7, F, M) array
            `at_nodes` of it.

        """
        known = ~np.isnan(growth.rate).any(axis=0)
        weights = self.ensemble.weights * known
        total = float(weights.sum())
        if total < LEAST_KNOWN:
            return None
        weights /= total
        largest = state.energy.max(axis=1, initial=0.0)
        reached = np.maximum(largest, 1.0)
        margin = self._margin(reached)
        of_member = exceedance(np.stack([
            margin, margin + self.emulator.error.rms * state.growing,
            self._margin(state.peak[:, 0]),
            np.where(known, self._excess(growth, rates), _NEVER)], axis=1))
        risk, risk_by_error, peak, unstable = (of_member @ weights).tolist()
        time, *energies = _medians(np.vstack([
            self._time(state.energy[MIDDLE], margin[MIDDLE], growth.rate), reached[MIDDLE],
            state.energy[MIDDLE]]), weights)
        build_up, *by_family = nepers(np.array(energies)).tolist()
        family, frequency = self._leading(
            state.energy >= largest[:, None], margin > 0.0, growth, weights)
        return RiskResult(
            squeal_risk=risk, peak_risk=peak, instability_probability=unstable,
            error=math.hypot(risk_by_error - risk, self._sampling_error(of_member[0], weights))
            + 1.0 - min(total, 1.0),
            build_up=build_up, family_build_up=np.array(by_family), time_to_squeal=time,
            family=family, frequency_hz=frequency, basis=self.basis,
            calibrated=bool(self.ensemble.calibrated), incomplete=state.incomplete)

    def _excess(self, growth: MemberGrowth, rates: FloatArray) -> FloatArray:
        """Return the largest growth rate beyond that of -zeta* at the nodes, (7, M)."""
        ratio = self.settings.instability_damping_ratio
        if ratio:
            rates = rates - ratio * 2.0 * np.pi * growth.frequency_hz
        return np.asarray(rates.max(axis=1, initial=_NEVER))

    def _time(self, energy: FloatArray, margin: FloatArray, rate: FloatArray) -> FloatArray:
        """Return the time until N* of each member without scatter [s], (M,)."""
        grows = (rate > 0.0).any(axis=1)
        missing, rate = -self._margin(energy[grows]), rate[grows]
        time = np.full_like(rate, np.inf)
        np.divide(missing, rate, out=time, where=rate > 0.0)
        return np.where(margin >= 0.0, 0.0, time.min(axis=0, initial=np.inf))

    def _leading(self, leads: NDArray[np.bool_], exceeds: NDArray[np.bool_], growth: MemberGrowth,
                 weights: FloatArray) -> tuple[int, float]:
        """
        Return index and frequency of the family that leads where N* is exceeded, or at all.

        By whether a family has the largest energy (7, F, M), and whether that exceeds N*.
        """
        count = self.families.size
        if not count:
            return -1, math.nan
        share = WEIGHTS[:, None] * weights * (exceeds if exceeds.any() else 1.0)
        total = (leads.astype(float) @ share[..., None]).sum(axis=0)
        place = int((total > total.max() - 1e-12).argmax())  # the first of equals
        frequency = growth.frequency_hz[place]
        return int(self.families[place]), float(
            np.where(weights > 0.0, frequency, 0.0) @ weights)

    def _sampling_error(self, exceeding: FloatArray, weights: FloatArray) -> float:
        """
        Return the standard deviation of a risk by the number of members.

        Sobol members integrate linear functions of their coordinates nearly exactly: what counts
        is what no linear function explains.
        """
        residual = exceeding - self._coordinates @ (self._fit @ exceeding)
        return float(np.linalg.norm(weights * residual))


def _medians(values: FloatArray, weights: FloatArray) -> list[float]:
    """Return the weighted median of each row of values (rows, M) of the members."""
    if not weights.min():
        values, weights = values[:, weights > 0.0], weights[weights > 0.0]
    if weights.min() == weights.max():  # no need to sort
        middle = (weights.size - 1) // 2
        return list(np.partition(values, middle, axis=1)[:, middle].tolist())
    order = values.argsort(axis=1)
    place = (weights[order].cumsum(axis=1) >= 0.5 - 1e-9).argmax(axis=1)
    rows = np.arange(len(values))
    found: list[float] = values[rows, order[rows, place]].tolist()
    return found

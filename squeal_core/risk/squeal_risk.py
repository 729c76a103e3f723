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
Squeal risk: the probability that some mode's build-up exceeds the audible level.

An ensemble of brakes stands for what is not known of a brake and stays (damping, contact
stiffness, bias of friction ...). Each member has the build-up of each of its mode families, at
nodes of the scatter of friction and damping from application to application.
"""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from squeal_core.common.arrays import FloatArray, RealArray
from squeal_core.risk.build_up import nepers, saturation_energy
from squeal_core.risk.ensemble import Ensemble, risk_basis
from squeal_core.risk.risk_records import (
    ApplicationState,
    families_in,
    GrowthSource,
    MemberGrowth,
    RiskResult,
    RiskSettings,
)
from squeal_core.risk.scatter import along_scatter, at_nodes, exceedance, MIDDLE, WEIGHTS

__all__ = ['GrowthSource', 'MemberGrowth', 'RiskResult', 'RiskSettings', 'SquealRisk']

LEAST_KNOWN = 0.5  # weight of members inside the emulator's domain, below which no risk is known
_NEVER = -1e9  # 1/s


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
        self.decay: RealArray = (np.exp(ensemble.ln_damping) * decay[:, None]).astype(np.float32)
        self.basis = risk_basis(ensemble.calibrated, ensemble.likelihood_power)
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
        result = self.emulator.evaluate(inputs)
        stiffness = np.asarray(contact_stiffness)[..., None] * np.exp(inputs[..., 3])
        cap = saturation_energy(np.exp(inputs[..., 1]), stiffness, self.settings.noise_floor)
        rate, frequency, by_friction, by_damping = (
            values[..., self.families] for values in result)
        scatter = along_scatter(float(members.friction_scatter) * by_friction,
                                float(members.damping_scatter) * by_damping)
        parts = [values.swapaxes(-1, -2).astype(np.float32, 'C')
                 for values in (rate, frequency, scatter)]
        known = np.isfinite(rate).all(axis=-1)
        cap = np.where(known, cap, np.inf).astype(np.float32)
        return MemberGrowth(parts[0], parts[1], parts[2], cap, np.asarray(known))

    def knows(self, growth: MemberGrowth) -> bool:
        """Return whether the emulator covers half of the members or more."""
        return float(self.ensemble.weights @ growth.known) >= LEAST_KNOWN

    def exceedances(self, energy: RealArray) -> FloatArray:
        """Return the probability in each member (M,) that energies (7, F, M) exceed N*."""
        return exceedance(self._margin(energy.max(axis=1, initial=1.0)))

    def _margin(self, energy: RealArray) -> FloatArray:
        """Return the build-up of energies (..., M) less N*."""
        return nepers(energy) - self.ensemble.audible_build_up

    def assess(self, states: Sequence[ApplicationState]) -> list[RiskResult]:
        """
        Return the risk of each state of a brake application.

        Many at once, of any brakes, cost less than each alone, and have the same bits.
        """
        energy, peak, growing = (np.stack(parts, axis=1) for parts in zip(
            *(state[:3] for state in states), strict=True))  # (7, S, ...)
        rate, frequency, scatter, _, known = map(np.stack, zip(
            *(state.growth for state in states), strict=True))
        weights = self.ensemble.weights * known
        total = weights.sum(axis=1, keepdims=True)
        weights /= total
        largest = energy.max(axis=2, initial=0.0)
        reached = np.maximum(largest, 1.0)
        margin = self._margin(reached)
        of_member = exceedance(np.stack([
            margin, margin + self.emulator.error.rms * growing, self._margin(peak[:, :, 0]),
            np.where(known, self._excess(frequency, at_nodes(rate, scatter)), _NEVER)], axis=2))
        risks = (of_member @ weights[:, :, None])[..., 0]
        errors = np.hypot(risks[:, 1] - risks[:, 0], self._sampling_error(
            of_member[:, 0], weights)) + 1.0 - np.minimum(total[:, 0], 1.0)
        medians = _medians(np.concatenate([
            self._time(energy[MIDDLE], margin[MIDDLE], rate)[:, None], reached[MIDDLE][:, None],
            energy[MIDDLE]], axis=1), weights)
        places, pitches = self._leading(
            energy >= largest[:, :, None], margin > 0.0, frequency, weights)
        return [RiskResult(
            squeal_risk=risk, peak_risk=peak_risk, instability_probability=unstable, error=error,
            build_up=float(nepers(middle[1])), family_build_up=nepers(middle[2:]),
            time_to_squeal=float(middle[0]), family=place, frequency_hz=pitch, basis=self.basis,
            calibrated=bool(self.ensemble.calibrated), incomplete=state.incomplete)
            for state, (risk, _, peak_risk, unstable), error, middle, place, pitch in zip(
                states, risks.tolist(), errors.tolist(), medians, places, pitches, strict=True)]

    def _excess(self, frequency: RealArray, rates: RealArray) -> RealArray:
        """Return the largest growth rate beyond that of -zeta* at the nodes, (7, S, M)."""
        ratio = self.settings.instability_damping_ratio
        if ratio:
            rates = rates - ratio * 2.0 * np.pi * frequency
        return np.asarray(rates.max(axis=2, initial=_NEVER))

    def _time(self, energy: RealArray, margin: FloatArray, rate: RealArray) -> FloatArray:
        """Return the time until N* of each member without scatter [s], (S, M)."""
        time = np.full(rate.shape, np.inf)
        np.divide(-self._margin(energy), rate, out=time, where=rate > 0.0)
        return np.where(margin >= 0.0, 0.0, time.min(axis=1, initial=np.inf))

    def _leading(self, leads: NDArray[np.bool_], exceeds: NDArray[np.bool_], frequency: RealArray,
                 weights: FloatArray) -> tuple[list[int], list[float]]:
        """
        Return index and frequency of the family that leads where N* is exceeded, or at all.

        By whether a family has the largest energy (7, S, F, M), and whether that exceeds N*.
        """
        count = len(weights)
        if not self.families.size:
            return count * [-1], count * [math.nan]
        anywhere = exceeds.any(axis=(0, 2), keepdims=True)
        share = WEIGHTS[:, None, None] * weights * np.where(anywhere, exceeds, 1.0)
        total = (leads.astype(np.float32) @ share.astype(np.float32)[..., None]
                 )[..., 0].sum(axis=0)
        places = (total > total.max(axis=1, keepdims=True) - 1e-6).argmax(axis=1)
        own = np.where(weights > 0.0, frequency[np.arange(count), places], 0.0)
        return self.families[places].tolist(), (own * weights).sum(axis=1).tolist()

    def _sampling_error(self, exceeding: FloatArray, weights: FloatArray) -> FloatArray:
        """
        Return the standard deviations of risks by the number of members, (S,).

        Sobol members integrate linear functions of their coordinates nearly exactly: what counts
        is what no linear function explains.
        """
        linear = (self._coordinates @ (self._fit @ exceeding[..., None]))[..., 0]
        return np.asarray(np.linalg.norm(weights * (exceeding - linear), axis=1))


def _medians(values: RealArray, weights: FloatArray) -> FloatArray:
    """Return the medians (S, rows) of values (S, rows, M) by the weights (S, M) of members."""
    if weights.min() == weights.max():  # no need to sort
        middle = (weights.shape[1] - 1) // 2
        return np.asarray(np.partition(values, middle, axis=2)[..., middle], float)
    order = values.argsort(axis=2)
    place = (np.take_along_axis(weights[:, None], order, axis=2).cumsum(axis=2) >= 0.5 - 1e-9
             ).argmax(axis=2)[..., None]
    return np.asarray(np.take_along_axis(
        values, np.take_along_axis(order, place, axis=2), axis=2)[..., 0], float)

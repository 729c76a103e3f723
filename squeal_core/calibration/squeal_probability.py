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

"""Probability that brake applications squeal, in each of many candidate brakes."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from squeal_core.calibration.applications import BrakeApplication
from squeal_core.calibration.candidates import BrakeCandidates
from squeal_core.common.arrays import FloatArray, IndexArray, RealArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.build_up import grown, nepers, saturation_energy
from squeal_core.risk.risk_records import families_in, GrowthSource, RiskSettings
from squeal_core.risk.scatter import along_scatter, exceedance, NODES

STEP = 0.25  # s between ticks at which growth is evaluated
_MOST_KNOTS = 20_000  # of all applications about; of longer recordings they are further apart
_ROWS = 40_000  # points that the emulator is given at once: memory


class SquealProbabilities(NamedTuple):
    """
    Of A applications in P candidates.

    Attributes
    ----------
    squeals : (P, A) array
        Probability that the build-up of some family exceeds N*.
    by_family : (P, A, F) array
        Of each family.
    frequency_hz : (A, F) array
        Where the family grows fastest, mean of the candidates.
    known : (P,) array
        Fraction of the points that are inside the emulator's domain.

    """

    squeals: FloatArray
    by_family: FloatArray
    frequency_hz: FloatArray
    known: FloatArray


class _Growth(NamedTuple):
    """Of the families in the band at knots: (A, T, P, F) arrays, as of `GrowthSource`."""

    rate: FloatArray
    frequency_hz: FloatArray
    by_friction: FloatArray
    by_damping: FloatArray


class _Knots(NamedTuple):
    """Some applications, padded to one number of knots T; (A, T) arrays."""

    rotor_speed: FloatArray
    contact_pressure: FloatArray
    friction: FloatArray
    contact_stiffness: FloatArray
    duration: FloatArray  # s since the knot before


class SquealPredictor:
    """
    Evaluates applications in candidate brakes, by the emulator and the build-up of the risk.

    Parameters
    ----------
    model : BrakeModel
    emulator : GrowthSource
        Of this model.
    applications : sequence of BrakeApplication
    settings : RiskSettings, optional
        Squeal band and noise floor.
    step : float
        Between ticks at which growth is evaluated [s], where there are not very many.

    """

    def __init__(self, model: BrakeModel, emulator: GrowthSource,
                 applications: Sequence[BrakeApplication], *,
                 settings: RiskSettings | None = None, step: float = STEP) -> None:
        settings = settings or RiskSettings()
        self._emulator, self._floor = emulator, settings.noise_floor
        self._families, self._frequency, self._decay = families_in(settings.band_hz,
                                                                   emulator.families)
        self._count = len(applications)
        total = sum(float(np.ptp(one.time)) for one in applications)
        chosen = [one.knots(max(step, total / _MOST_KNOTS)) for one in applications]
        self._knots = [_knots_of(model, one, *result)
                       for one, result in zip(applications, chosen, strict=True)]

    def evaluate(self, candidates: BrakeCandidates) -> SquealProbabilities:
        """Return the probabilities of all applications."""
        size, families = candidates.ln_damping.size, self._families.size
        squeals = np.zeros((size, self._count))
        by_family = np.zeros((size, self._count, families))
        frequency = np.tile(self._frequency, (self._count, 1))
        known = np.zeros(size)
        for places, knots in self._chunks(size):
            result = self._growth(knots, candidates)
            frequency[places] = _fastest(result, self._frequency)
            known += np.isfinite(result.rate[..., :1]).mean(axis=(1, 3)).sum(axis=0)
            rates = result.rate, _scatter(result, candidates)
            reach = NODES[-1] * np.abs(rates[1])
            active = np.flatnonzero((np.nan_to_num(rates[0] + reach, nan=-1.0) > 0.0
                                     ).any(axis=(0, 1, 2)))
            if active.size:  # others never leave their floor
                margin = self._margins(
                    knots, [part[..., active].astype(np.float32) for part in rates],
                    self._decay[active], candidates)
                by_family[np.ix_(np.arange(size), places, active)] = exceedance(
                    margin).swapaxes(0, 1)
                squeals[:, places] = exceedance(margin.max(axis=-1)).T
        return SquealProbabilities(squeals, by_family, frequency, known / max(1, self._count))

    def _chunks(self, size: int) -> Iterator[tuple[IndexArray, _Knots]]:
        """Yield places of applications with about as many knots, and their knots."""
        lengths = np.array([one.duration.size for one in self._knots])
        order = np.argsort(lengths, kind='stable')
        start = 0
        while start < order.size:
            end = start + 1
            while end < order.size and (end + 1 - start) * lengths[order[end]] * size <= _ROWS:
                end += 1
            places = order[start:end]
            yield places, _padded([self._knots[i] for i in places])
            start = end

    def _growth(self, knots: _Knots, candidates: BrakeCandidates) -> _Growth:
        """Return growth (A, T, P, F)."""
        conditions = np.stack(knots[:3], axis=-1).reshape(-1, 3)
        # ends and padding repeat the knot before
        fresh = np.append(True, (conditions[1:] != conditions[:-1]).any(axis=1))
        place = np.cumsum(fresh) - 1
        result = self._emulator.evaluate(candidates.ensemble('').inputs(*conditions[fresh].T))
        shape = (*knots.duration.shape, candidates.ln_damping.size, self._families.size)
        return _Growth(*(
            getattr(result, name)[..., self._families][place].reshape(shape)
            for name in ('growth_rate', 'frequency_hz', 'by_friction', 'by_damping')))

    def _margins(self, knots: _Knots, parts: Sequence[NDArray[np.float32]], decay: FloatArray,
                 candidates: BrakeCandidates) -> FloatArray:
        """
        Return build-up minus N*, the largest over each application, (7, A, P, F).

        Single precision is enough, and twice as fast.
        """
        decays: Any = (np.exp(candidates.ln_damping)[:, None] * decay).astype(np.float32)
        cap: Any = saturation_energy(
            knots.contact_pressure[..., None], knots.contact_stiffness[..., None]
            * np.exp(candidates.ln_contact_stiffness), self._floor)[..., None].astype(np.float32)
        duration: Any = knots.duration[..., None, None].astype(np.float32)
        nodes = NODES[:, None, None, None].astype(np.float32)
        rates: Any = np.ones((), np.float32)
        energy = peak = rates
        with np.errstate(over='ignore'):  # the cap ends it
            for tick in range(knots.duration.shape[1]):
                rate, scatter = (part[:, tick] for part in parts)
                before, rates = rates, rate + nodes * scatter
                energy = grown(energy, 0.5 * (before + rates) if tick else rates,
                               duration[:, tick], decays, cap[:, tick])
                peak = np.maximum(peak, energy)
        return np.asarray(nepers(peak) - candidates.audible_build_up[:, None])


def _knots_of(model: BrakeModel, one: BrakeApplication, ticks: IndexArray,
              duration: FloatArray) -> _Knots:
    pressure = one.contact_pressure[ticks]
    return _Knots(one.rotor_speed[ticks], pressure, one.friction[ticks],
                  np.array([model.contact_stiffness_at(float(p)) for p in pressure]), duration)


def _padded(knots: Sequence[_Knots]) -> _Knots:
    """Return applications as arrays: the last knot is repeated, and takes no time."""
    most = max(one.duration.size for one in knots)
    columns = [np.array([np.pad(values, (0, most - values.size), 'edge') for values in column])
               for column in zip(*knots, strict=True)]
    for row, one in zip(columns[-1], knots, strict=True):
        row[one.duration.size:] = 0.0
    return _Knots(*columns)


def _scatter(result: _Growth, candidates: BrakeCandidates) -> RealArray:
    """Return the change of growth rates over one standard deviation of their scatter."""
    return along_scatter(candidates.friction_scatter[:, None] * result.by_friction,
                         candidates.damping_scatter[:, None] * result.by_damping)


def _fastest(result: _Growth, otherwise: FloatArray) -> FloatArray:
    """Return frequencies (A, F) of the families at the knots at which they grow fastest."""
    known = np.isfinite(result.rate)
    tick = np.where(known, result.rate, -np.inf).argmax(axis=1, keepdims=True)
    frequency = np.take_along_axis(result.frequency_hz, tick, axis=1)[:, 0]
    counted = np.isfinite(frequency)
    return np.where(counted.any(axis=1), np.where(counted, frequency, 0.0).sum(axis=1)
                    / np.maximum(counted.sum(axis=1), 1), otherwise)

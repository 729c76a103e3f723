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
Builds a growth emulator: full solutions at scattered points, and polynomials fitted to them.

Each solution gives the matrices that the modes of families are the eigenvalues of, and by all its
vectors their slopes along all six coefficients: seven equations for each entry. They are fitted in
pieces of contact stiffness, as modes of the pads cross those of the disc while it stiffens.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise, product
import math
from typing import Any, TypeAlias

import numpy as np
from scipy.stats import qmc
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.common.errors import ModelError
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.emulator_audit import growth_differences, MATTERS
from squeal_core.risk.emulator_records import EmulatorDomain, EmulatorError
from squeal_core.risk.group_fits import fitted_groups, FittedGroup
from squeal_core.risk.growth_emulator import affine_coefficients, GrowthEmulator, points_at
from squeal_core.risk.mode_families import clusters, coupled, mixing, ModeFamily, ReferenceModes
from squeal_core.risk.polynomial_basis import BRAKE, OPERATION, PolynomialBasis
from squeal_core.risk.small_matrices import CommonMatrix
from squeal_core.risk.training_solutions import solution_at, solve_points, TrainingSolutions
from squeal_core.stability.eigensolution import SQUEAL_BAND

Progress: TypeAlias = Callable[[int, int], None]

SOLUTIONS = 2400
HOLD_OUT = 500
_BOUNDING = 2**15  # points at which the largest growth rates are looked for
_CHUNK = 16  # solutions of a job
_PILOT = 300  # solutions that show which modes mix
_NEAR = 3.0  # times the growth rate that matters, at which the pilot's modes may matter
_PIECE = 0.1  # of ln k_c
_OF_PIECE = 200  # solutions at least
_DEGREE = 6.0
_COSTS = (2.0, 1.0, 2.0, 2.0, 1.0, 3.0)  # of a degree in each coordinate, up to _DEGREE in all
_AMID = 2.0 * math.pi * 2000.0  # rad/s, where squeal is; sets the scales of coordinates


def usual_domain(model: BrakeModel) -> EmulatorDomain:
    """
    Return the domain of a vehicle's brakes.

    0.5 to 120 rad/s, 100 to 20,000 N, friction 0.02 to 0.75, three standard deviations of contact
    stiffness (0.1 of its ln) and damping (0.3 of its ln), 0 to twice the friction slope.
    """
    area = model.contact_area
    low = [math.log(0.5), math.log(100.0 / area), 0.02, -0.3, -0.9, 0.0]
    high = [math.log(120.0), math.log(20000.0 / area), 0.75, 0.3, 0.9, 2.0]
    return EmulatorDomain(readonly(low), readonly(high), 1000.0 / area)


def build_growth_emulator(model: BrakeModel, *, domain: EmulatorDomain | None = None,
                          band_hz: tuple[float, float] = SQUEAL_BAND,
                          solutions: int = SOLUTIONS, hold_out: int = HOLD_OUT, seed: int = 0,
                          workers: int = 0,
                          progress: Progress = lambda *_: None) -> GrowthEmulator:
    """
    Return the emulator of a model.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    domain : EmulatorDomain, optional
        `usual_domain(model)` where None.
    band_hz : (2,) floats
        Squeal band [Hz]; families that do not oscillate in it are left out.
    solutions, hold_out : int
        Full solutions that are fitted, and those that the error is measured by.
    seed : int
        Of the points.
    workers : int
        Processes; 0: this one.
    progress : callable
        Called with the number of full solutions and of all of them.

    Raises
    ------
    ModelError
        Where no mode of the band comes near to growing.

    """
    domain = domain or usual_domain(model)
    inputs = scattered_inputs(domain, solutions, seed)
    everything = min(solutions, _PILOT) + solutions + hold_out
    stiffness = points_at(model, inputs).contact_stiffness
    reference = ReferenceModes(model, (float(stiffness.min()), float(stiffness.max())))
    band, done = 2.0 * np.pi * np.array(band_hz), 0

    def told(solved: int) -> None:
        nonlocal done
        done += solved
        progress(done, everything)

    [pilot] = _solved(model, reference, [inputs[:_PILOT]], [()], workers, told)
    result = _clusters(pilot, band)
    pieces = _pieces(stiffness)
    basis = _basis(model, inputs, stiffness, pieces)
    middles = [float(np.median(stiffness[own])) for own in pieces]
    training = _solved(model, reference, [inputs[own] for own in pieces],
                       [(result, middle) for middle in middles], workers, told)
    families, count = _families(pilot, training, result, band)
    fits = [_fitted(model, basis, inputs[own], solved, result, families, count, band)
            for own, solved in zip(pieces, training, strict=True)]
    emulator = GrowthEmulator(
        model, _described(model, reference, families[:count]), domain, basis,
        *_weights(fits, [len(places) for places in families[:count]]),
        EmulatorError(np.nan, np.nan))
    return _with_error(with_largest_growth(emulator, seed + 2),
                       scattered_inputs(domain, hold_out, seed + 1), workers, told)


def with_largest_growth(result: GrowthEmulator, seed: int) -> GrowthEmulator:
    """Return the emulator with families that know how fast they grow at most in its domain."""
    inputs = scattered_inputs(result.domain, _BOUNDING, seed)
    inputs = inputs[inputs[:, 3].argsort()].reshape(-1, 256, 6)
    largest = result.evaluate(inputs).growth_rate.max(axis=(0, 1)).tolist()
    return GrowthEmulator(result.model, tuple(
        replace(family, largest_growth=growth) for family, growth in zip(
            result.every, largest, strict=True)),
        result.domain, result.basis, result.weights, result.common, result.error)


def _solved(model: BrakeModel, reference: ReferenceModes, inputs: Sequence[FloatArray],
            others: Sequence[tuple[Any, ...]], workers: int,
            progress: Callable[[int], None]) -> list[TrainingSolutions]:
    """Return the solutions of each of several parts of inputs (P, 6)."""
    jobs = {(part + i * len(inputs)): (model, reference, rows, *others[part])
            for part, own in enumerate(inputs)
            for i, rows in enumerate(np.array_split(own, math.ceil(len(own) / _CHUNK)))}
    parts = {}
    for key, solved in run_jobs(solve_points, jobs, workers):
        parts[key] = solved
        progress(len(solved.eigenvalues))
    return [TrainingSolutions.joined([parts[key] for key in sorted(parts)
                                      if key % len(inputs) == part])
            for part in range(len(inputs))]


def scattered_inputs(domain: EmulatorDomain, count: int, seed: int) -> FloatArray:
    """Return inputs (count, 6) spread over a domain."""
    sampler, result = qmc.Sobol(6, seed=seed), np.empty((0, 6))
    while len(result) < count:
        block = domain.low + (domain.high - domain.low) * sampler.random(1024)
        result = np.concatenate([result, block[domain.covers(block)]])
    return result[:count]


def _matters(values: ComplexArray, band: FloatArray, growth: float) -> Any:
    """Return whether each mode (N,) exceeds a growth rate in the band anywhere, by (P, N)."""
    inside = (values.imag >= band[0]) & (values.imag <= band[1])
    return (inside & (values.real > growth)).any(axis=0)


def _clusters(pilot: TrainingSolutions, band: FloatArray) -> list[IndexArray]:
    """Return the clusters of modes of which any may come near to growing in the band."""
    mixed, values = mixing(pilot.eigenvalues, pilot.projections), pilot.eigenvalues
    near = _matters(values, band, _NEAR * MATTERS) & (np.isfinite(values).mean(axis=0) > 0.5)
    return [places for places in clusters(mixed, coupled(mixed)) if near[places].any()]


def _families(pilot: TrainingSolutions, training: Sequence[TrainingSolutions],
              result: Sequence[IndexArray], band: FloatArray) -> tuple[list[IndexArray], int]:
    """
    Return the families of clusters, and the number of those that matter.

    These are the first ones: they come near to growing in the band. Single modes are before pairs.
    """
    values = np.concatenate([part.eigenvalues for part in training])
    matters = _matters(values, band, MATTERS) & (np.isfinite(values).mean(axis=0) > 0.5)
    within = np.isin(np.arange(matters.size), np.concatenate([[-1], *result]))
    every = [places for places in coupled(mixing(pilot.eigenvalues, pilot.projections))
             if within[places].all()]
    every.sort(key=lambda places: (not matters[places].any(), len(places)))
    count = sum(bool(matters[places].any()) for places in every)
    if not count:
        raise ModelError('no mode of the squeal band comes near to growing; there is nothing to '
                         'emulate')
    return every, count


def _pieces(stiffness: FloatArray) -> list[IndexArray]:
    """Return the places of points in each piece of contact stiffness, in rising order."""
    width = float(np.log(stiffness.max() / stiffness.min()))
    count = max(1, min(math.ceil(width / _PIECE - 1e-6), stiffness.size // _OF_PIECE))
    return np.array_split(np.argsort(stiffness, kind='stable'), count)


def _fitted(model: BrakeModel, basis: PolynomialBasis, inputs: FloatArray,
            training: TrainingSolutions, result: Sequence[IndexArray],
            families: Sequence[IndexArray], count: int, band: FloatArray) -> list[FittedGroup]:
    """Return the groups of a piece."""
    coefficients = affine_coefficients(points_at(model, inputs))
    variables, by_own = basis.variables(coefficients)
    rows = basis.terms(*basis.factors(variables, np.eye(4)[..., None], np.eye(2)[..., None]))
    rows = rows[[0, *(1 + np.argsort([*OPERATION, *BRAKE]))]].swapaxes(1, 2)  # by each variable
    return fitted_groups(rows, by_own, training, result, families, count, band)


def _weights(fits: Sequence[Sequence[FittedGroup]], sizes: Sequence[int]
             ) -> tuple[FloatArray, tuple[CommonMatrix, ...]]:
    """Return the weights of families by themselves (W, T, 2 K), and common matrices."""
    terms, pairs = len(fits[0][0].weights), sum(size == 2 for size in sizes)
    single, count = len(sizes) - pairs, len(sizes)
    weights = np.zeros((len(fits), terms, count + 3 * pairs), complex)
    common = []
    for piece, groups in enumerate(fits):
        for families, fitted, _ in groups:
            place, own = families[0], weights[piece]
            if len(families) > 1:
                inside = np.array(sorted(place for place in families if place < count))
                common.append(CommonMatrix(piece, inside, readonly(
                    np.ascontiguousarray(fitted.reshape(terms, -1)).view(float))))
            elif place < count and sizes[place] == 1:
                own[:, place] = fitted[:, 0, 0]
            elif place < count:
                own[:, place] = 0.5 * (fitted[:, 0, 0] + fitted[:, 1, 1])
                own[:, count + place - single::pairs] = np.column_stack(
                    [0.5 * (fitted[:, 0, 0] - fitted[:, 1, 1]), fitted[:, 0, 1], fitted[:, 1, 0]])
    return weights.view(float), tuple(common)


def _described(model: BrakeModel, reference: ReferenceModes,
               families: Sequence[IndexArray]) -> tuple[ModeFamily, ...]:
    """Return the records of families, by the solution without friction."""
    point = OperatingPoint(rotor_speed=1e-3, friction=0.0, contact_pressure=0.0,
                           contact_stiffness=model.nominal_contact_stiffness)
    [values] = solution_at(model, reference, point).eigenvalues
    return tuple(ModeFamily(
        tuple((places + 1).tolist()), float(values[places].imag.mean() / (2.0 * np.pi)),
        float(-values[places].real.mean())) for places in families)


def _basis(model: BrakeModel, inputs: FloatArray, stiffness: FloatArray,
           pieces: Sequence[IndexArray]) -> PolynomialBasis:
    scales = [1.0 if array is None else _AMID / (float(np.linalg.norm(array, 2)) or 1.0)
              for array in (model.gyroscopic, model.radial_dissipation, model.negative_slope)]
    exponents = np.array([powers for powers in product(range(int(_DEGREE) + 1), repeat=6)
                          if np.dot(powers, _COSTS) <= _DEGREE])
    plain = PolynomialBasis(exponents, readonly(scales), readonly(-np.ones((1, 6))),
                            readonly(np.ones((1, 6))))
    places, _ = plain.variables(affine_coefficients(points_at(model, inputs)))
    low, high = (np.tile(ends, (len(pieces), 1)) for ends in (
        places.min(axis=0), places.max(axis=0)))
    inner = [0.5 * (stiffness[below[-1]] + stiffness[above[0]]) for below, above in pairwise(
        pieces)]
    low[1:, 3] = high[:-1, 3] = inner
    flat = low == high  # what the model does not have
    return PolynomialBasis(exponents, plain.scales, readonly(low - flat), readonly(high + flat))


def _with_error(result: GrowthEmulator, inputs: FloatArray, workers: int,
                progress: Callable[[int], None]) -> GrowthEmulator:
    jobs = {i: (result, row) for i, row in enumerate(inputs)}
    off = []
    for _, part in run_jobs(growth_differences, jobs, workers):
        off.append(part)
        progress(1)
    all_off = np.concatenate(off) if off else np.empty(0)
    result.error = EmulatorError(
        float(np.sqrt(np.mean(all_off**2))) if all_off.size else math.nan,
        float(np.abs(all_off).max(initial=0.0)), len(off))
    return result

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

Each solution gives the eigenvalues and, by their vectors, their slopes along all six coefficients,
so a thousand of them are seven thousand equations for each invariant of a family.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
import math
from typing import Any, TypeAlias

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.stats import qmc
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.common.errors import ModelError
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.emulator_audit import growth_differences, MATTERS
from squeal_core.risk.growth_emulator import (
    affine_coefficients,
    EmulatorDomain,
    EmulatorError,
    GrowthEmulator,
)
from squeal_core.risk.mode_families import coupled, ModeFamily, ReferenceModes
from squeal_core.risk.polynomial_basis import BRAKE, OPERATION, PolynomialBasis
from squeal_core.risk.training_solutions import solution_at, solve_points, TrainingSolutions
from squeal_core.stability.eigensolution import SQUEAL_BAND

Progress: TypeAlias = Callable[[int, int], None]

SOLUTIONS = 1200
HOLD_OUT = 200
_CHUNK = 16  # solutions of a job
_DEGREE = 6.0
_COSTS = (1.5, 1.0, 1.5, 1.0, 1.0, 2.0)  # of a degree in each coordinate, up to _DEGREE in all
_AMID = 2.0 * math.pi * 2000.0  # rad/s, where squeal is; sets the scales of coordinates
_SLOPE_WEIGHT = 0.3  # of an equation for a slope beside one for a value
_SOFT = 50.0  # 1/s beyond what matters at which an equation counts half
_RIDGE = 1e-10  # of the largest diagonal entry
_REFITS = 3


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
    chosen = _reference(model, inputs)
    jobs = {i: (model, chosen, inputs[i:i + _CHUNK]) for i in range(0, solutions, _CHUNK)}
    parts, done = {}, 0
    for key, part in run_jobs(solve_points, jobs, workers):
        parts[key], done = part, done + len(part.eigenvalues)
        progress(done, solutions + hold_out)
    training = TrainingSolutions(*(np.concatenate(arrays) for arrays in zip(
        *(parts[key] for key in sorted(parts)), strict=True)))
    found = _fitted(model, domain, inputs, training, chosen, band_hz)
    return _with_error(found, scattered_inputs(domain, hold_out, seed + 1), workers,
                       lambda count: progress(solutions + count, solutions + hold_out))


def scattered_inputs(domain: EmulatorDomain, count: int, seed: int) -> FloatArray:
    """Return inputs (count, 6) spread over a domain."""
    sampler, found = qmc.Sobol(6, seed=seed), np.empty((0, 6))
    while len(found) < count:
        block = domain.low + (domain.high - domain.low) * sampler.random(1024)
        found = np.concatenate([found, block[domain.covers(block)]])
    return found[:count]


def _reference(model: BrakeModel, inputs: FloatArray) -> ReferenceModes:
    stiffness = affine_coefficients(model, inputs)[0][:, 3]
    return ReferenceModes(model, (float(stiffness.min()), float(stiffness.max())))


def _fitted(model: BrakeModel, domain: EmulatorDomain, inputs: FloatArray,
            training: TrainingSolutions, reference: ReferenceModes,
            band_hz: tuple[float, float]) -> GrowthEmulator:
    """Return the emulator of full solutions, its error not yet known."""
    basis = _basis(model, inputs)
    coefficients, _ = affine_coefficients(model, inputs)
    variables, by_own = basis.variables(coefficients)
    rows = basis.terms(*basis.factors(variables, np.eye(4)[..., None], np.eye(2)[..., None]))
    rows = rows.swapaxes(1, 2)  # slopes by the variables
    found = []
    for places in _families(training, band_hz):
        values, by = _invariants_of(training.eigenvalues[:, places], training.slopes[:, places])
        by = np.moveaxis(by / by_own[:, None], 2, 0)[[*OPERATION, *BRAKE]]
        wanted = np.concatenate([values[None], by])
        found.append((places, _fit(rows, wanted, training, places)))
    if not found:
        raise ModelError('no mode of the squeal band comes near to growing; there is nothing to '
                         'emulate')
    weights = np.concatenate([part[:, :1] for _, part in found]
                             + [part[:, 1:] for _, part in found], axis=1)
    return GrowthEmulator(model, _described(model, reference, [item for item, _ in found]),
                          domain, basis, np.ascontiguousarray(weights).view(float),
                          EmulatorError(np.nan, np.nan))


def _families(training: TrainingSolutions, band_hz: tuple[float, float]) -> list[IndexArray]:
    """Return the families, smallest first, that come near to growing in the band."""
    low, high = band_hz
    values = training.eigenvalues
    frequency = values.imag / (2.0 * np.pi)
    matters = (frequency >= low) & (frequency <= high) & (values.real > MATTERS)
    enough = np.isfinite(values).mean(axis=0) > 0.5
    return sorted((places for places in coupled(values, training.projections)
                   if matters[:, places].any() and enough[places].all()), key=len)


def _described(model: BrakeModel, reference: ReferenceModes,
               families: Sequence[IndexArray]) -> tuple[ModeFamily, ...]:
    """Return what is said of families, by the solution without friction."""
    point = OperatingPoint(rotor_speed=1e-3, friction=0.0, contact_pressure=0.0,
                           contact_stiffness=model.nominal_contact_stiffness)
    values = solution_at(model, reference, point).eigenvalues
    return tuple(ModeFamily(
        tuple((places + 1).tolist()), float(values[places].imag.mean() / (2.0 * np.pi)),
        float(-values[places].real.mean())) for places in families)


def _basis(model: BrakeModel, inputs: FloatArray) -> PolynomialBasis:
    scales = [1.0 if array is None else _AMID / (float(np.linalg.norm(array, 2)) or 1.0)
              for array in (model.gyroscopic, model.radial_dissipation, model.negative_slope)]
    exponents = np.array([powers for powers in product(range(int(_DEGREE) + 1), repeat=6)
                          if np.dot(powers, _COSTS) <= _DEGREE])
    plain = PolynomialBasis(exponents, readonly(scales), readonly(-np.ones(6)),
                            readonly(np.ones(6)))
    places, _ = plain.variables(affine_coefficients(model, inputs)[0])
    low, high = places.min(axis=0), places.max(axis=0)
    flat = low == high  # what the model does not have
    return replace(plain, low=readonly(low - flat), high=readonly(high + flat))


def _invariants_of(values: ComplexArray, slopes: ComplexArray) -> tuple[Any, Any]:
    """Return invariants (P, n) of families (P, n), and their slopes (P, n, 6)."""
    if values.shape[1] == 1:
        return values, slopes
    half, turn = 0.5 * (values[:, 0] - values[:, 1]), 0.5 * (slopes[:, 0] - slopes[:, 1])
    return (np.column_stack([values.mean(axis=1), half**2]),
            np.stack([slopes.mean(axis=1), 2.0 * half[:, None] * turn], axis=1))


def _fit(rows: FloatArray, wanted: ComplexArray, training: TrainingSolutions,
         places: IndexArray) -> ComplexArray:
    """
    Return the weights (T, n) of terms that fit invariants and their slopes (7, P, n).

    Equations count less where the family grows or decays fast, and where they are found to be far
    off: there modes that cross were numbered the other way round.
    """
    values = training.eigenvalues[:, places]
    growth = values.real.max(axis=1)
    known = np.isfinite(values).all(axis=1)
    own = training.projections[:, places][:, :, places].sum(axis=2).min(axis=1)
    weight = np.where(known, own**2, 0.0)
    weight /= 1.0 + (np.maximum(growth, 0.0) + np.maximum(MATTERS - growth, 0.0)) / _SOFT
    wanted, rows = wanted[:, known], rows[:, known]
    weight, growth = weight[known], growth[known]
    scale = np.median(np.abs(wanted[0] - np.median(wanted[0], axis=0)), axis=0) + 1e-300
    kinds = np.array([1.0, *6 * [_SLOPE_WEIGHT]])[:, None]
    trusted, weights = np.ones_like(weight), np.empty(0, complex)
    for _ in range(_REFITS):
        weights = _least_squares(rows, wanted / scale, kinds * weight * trusted) * scale
        mean, *square = (rows[0] @ weights).T
        off = np.abs(mean.real + sum(np.sqrt(item).real for item in square) - growth)
        usual = 4.0 * np.median(off) + 0.05
        trusted = 1.0 / (1.0 + (off / usual) ** 2)
    return weights


def _least_squares(rows: FloatArray, wanted: ComplexArray,
                   weights: FloatArray) -> ComplexArray:
    """Return x (T, n) of least weighted |rows x - wanted|; rows (7, P, T), wanted (7, P, n)."""
    left = (rows * weights[..., None]).reshape(-1, rows.shape[-1])
    right = (wanted * weights[..., None]).reshape(-1, wanted.shape[-1])
    normal = left.T @ left
    normal[np.diag_indices_from(normal)] += _RIDGE * normal.diagonal().max()
    return np.asarray(cho_solve(cho_factor(normal), left.T @ right))


def _with_error(found: GrowthEmulator, inputs: FloatArray, workers: int,
                progress: Callable[[int], None]) -> GrowthEmulator:
    jobs = {i: (found, row) for i, row in enumerate(inputs)}
    off = []
    for _, part in run_jobs(growth_differences, jobs, workers):
        off.append(part)
        progress(len(off))
    all_off = np.concatenate(off) if off else np.empty(0)
    found.error = EmulatorError(
        float(np.sqrt(np.mean(all_off**2))) if all_off.size else math.nan,
        float(np.abs(all_off).max(initial=0.0)), len(off))
    return found

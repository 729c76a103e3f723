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

"""Mechanism of a mode's growth: contribution of each matrix to Re(lambda), and participation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import DAMPING, DASHPOTS, OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.matrix_names import OPERATORS, SUPPORTS
from squeal_core.stability.eigensolution import complex_modes, Mode, Tolerances
from squeal_core.stability.eigenvectors import mode_vectors, ModeVectors
from squeal_core.stability.mode_tracking import follow, numbered
from squeal_core.stability.parameter_paths import MatrixPath

Label: TypeAlias = Literal['mode coupling', 'negative slope', 'gyroscopic',
                           'radial-dissipation induced', 'follower force', 'contact damping',
                           'divergence', 'combined', 'stable']

ROTATION = ('gyroscopic', 'radial_dissipation', 'negative_slope')
"""Terms that are off in K09's loci without rotation effects (figs 11 and 12); those of D."""
TERMS = ('structural_damping', 'structural_stiffness', *SUPPORTS, *OPERATORS, 'contact_damping')

_LABELS: dict[str, Label] = {
    'negative_slope': 'negative slope', 'gyroscopic': 'gyroscopic',
    'radial_dissipation': 'radial-dissipation induced', 'follower': 'follower force',
    'contact_damping': 'contact damping'}
_VARYING = (*OPERATORS, 'contact_damping')
_CONSERVATIVE = ('structural_stiffness', 'contact_stiffness', 'gyroscopic')


@dataclass(frozen=True)
class Share:
    """Part of a mode's kinetic energy that a component mode, or doublet, has [-]."""

    name: str
    fraction: float


@dataclass(frozen=True, kw_only=True)
class Mechanism:
    """
    Mechanism by which a mode is unstable, or that it is stable.

    Parameters
    ----------
    mode : Mode
    label : str
        See `mechanisms` for the rule.
    reason : str
        What the label rests on, in words.
    contributions, powers : mapping
        Of each term to Re(lambda) [1/s]; see the functions of these names.
    without : mapping
        Growth rate [1/s] of this mode with a term taken out, and with 'rotation' terms out;
        empty for modes that do not grow.
    participation : tuple of Share
        The component modes that take the most part.

    """

    mode: Mode
    label: Label
    reason: str
    contributions: Mapping[str, float]
    powers: Mapping[str, float]
    without: Mapping[str, float]
    participation: tuple[Share, ...]


def mechanisms(model: BrakeModel, point: OperatingPoint, modes: Sequence[Mode] | None = None, *,
               top: int = 4, tolerances: Tolerances | None = None) -> tuple[Mechanism, ...]:
    """
    Return the mechanism of modes at a point; by default of the growing ones, worst first.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Operating point.
    modes : sequence of Mode, optional
        Of `complex_modes(model, point)`.
    top : int
        How many participants to name.
    tolerances : Tolerances, optional
        Of the classification of eigenvalues.

    Notes
    -----
    The rule. Each term that friction or rotation brings is taken out, one at a time, by scaling
    it down to zero while the mode is followed; terms without which the mode no longer grows are
    needed. A mode that merged on the way counts with the worst of those it merged with. Then:

    - 'divergence': it grows without oscillating;
    - 'mode coupling': the friction couple is needed, and the mode grows without rotation too,
      G, R and S all out (K09's test of mode coupling);
    - else 'negative slope', 'gyroscopic', 'radial-dissipation induced', 'follower force',
      'contact damping' (the layer's dashpot, whose force carries friction too): that term is
      needed; of several the one without which the growth rate is the lowest;
    - else 'mode coupling', if the friction couple alone is needed;
    - else 'combined': it takes more than one term out to stop it;
    - 'stable': it does not grow.

    """
    limits = tolerances or Tolerances.of(model, point)
    if modes is None:
        modes = complex_modes(model, point, tolerances=limits).unstable
    growing = [mode for mode in modes if mode.unstable]
    removed = _without(model, point, growing, limits) if growing else {}
    return tuple(_mechanism(model, point, mode, removed.get(mode.index, {}), top, limits)
                 for mode in modes)


def without_rotation(model: BrakeModel) -> BrakeModel:
    """Return a model without G, R and S: K09's disc that does not rotate."""
    return replace(model, gyroscopic=None, radial_dissipation=None, negative_slope=None)


def contributions(model: BrakeModel, point: OperatingPoint,
                  vectors: ModeVectors) -> dict[str, float]:
    """
    Return the contribution of each term to Re(lambda) [1/s], by left and right vectors.

    Notes
    -----
    The eigenvalue is homogeneous of the first degree in D and of half a degree in K: with D scaled
    by s and K by s^2 it is scaled by s. By Euler's theorem it is the sum of D_j dlambda/dD_j and
    2 K_j dlambda/dK_j over the terms of D and K, that is of

        -lambda y^H D_j x / (y^H (2 lambda + D) x)   and   -2 y^H K_j x / (y^H (2 lambda + D) x).

    So a damping or gyroscopic term counts with the change of Re(lambda) per relative change of
    that term, a stiffness term with twice that. Of one mode alone the damping adds -D/2 and the
    stiffness nothing. In a pair that coupled by friction the friction couple adds a positive
    amount, and the stiffness that keeps the two frequencies apart takes away: both grow without
    bound towards the merging, their sum does not. An eigenvalue at zero gets zeros.

    """
    eigenvalue, x, y = vectors.eigenvalue, vectors.right, vectors.left.conj()
    scale = y @ (2.0 * eigenvalue * x + model.damping(point) @ x)
    if eigenvalue == 0.0:
        return {name: 0.0 for name, _ in _terms(model, point, x)}
    return {name: float((-(eigenvalue if _damps(name) else 2.0) * (y @ force) / scale).real)
            for name, force in _terms(model, point, x)}


def powers(model: BrakeModel, point: OperatingPoint, vectors: ModeVectors) -> dict[str, float]:
    """
    Return the contribution to Re(lambda) [1/s] of each term's work on the mode's own motion.

    Notes
    -----
    The imaginary part of x^H Q(lambda) x = 0 with |x| = 1 and lambda = s + i w is
    s (2 w + Im x^H D x) = -w Re x^H D x - Im x^H K x: symmetric damping and unsymmetric stiffness
    do work, stiffness and gyroscopic terms none. What these do to a mode by changing its shape
    shows in `contributions` alone. Empty for an eigenvalue that does not oscillate.

    """
    eigenvalue, x = vectors.eigenvalue, vectors.right
    scale = 2.0 * eigenvalue.imag + (x.conj() @ model.damping(point) @ x).imag
    if eigenvalue.imag == 0.0 or scale == 0.0:
        return {}
    work = {name: x.conj() @ force for name, force in _terms(model, point, x)}
    return {name: 0.0 if name in _CONSERVATIVE else float(
        -(eigenvalue.imag * value.real if _damps(name) else value.imag) / scale)
        for name, value in work.items()}


def participation(model: BrakeModel, right: ComplexArray, *, top: int = 4) -> tuple[Share, ...]:
    """
    Return the component modes with the most kinetic energy, |x_n|^2 of all.

    The halves of a doublet, names alike but for a last letter c or s, count as one: how a doublet
    is turned says nothing of the brake.
    """
    energy: FloatArray = np.abs(right)**2 / np.sum(np.abs(right)**2)
    shares: dict[tuple[str, float], float] = {}
    for name, frequency, part in zip(model.names or _numbers(model), model.angular_frequencies,
                                     energy, strict=True):
        key = (name, frequency)
        twin = name[:-1] + {'c': 's', 's': 'c'}.get(name[-1:], '')
        if (twin, frequency) in shares:
            part += shares.pop((twin, frequency))
            key = (name[:-1], frequency)
        shares[key] = shares.get(key, 0.0) + part
    ranked = sorted(shares.items(), key=lambda item: -item[1])[:top]
    return tuple(Share(name, float(part)) for (name, _), part in ranked)


def _numbers(model: BrakeModel) -> tuple[str, ...]:
    return tuple(f'component {i + 1}' for i in range(model.size))


def _damps(name: str) -> bool:
    return name in ('structural_damping', 'support_damping') or name in DAMPING


def _parts(model: BrakeModel, name: str) -> list[str]:
    """Return the coefficients of a term that varies with the point; none: the model lacks it."""
    names = DASHPOTS.values() if name == 'contact_damping' else (name,)
    return [part for part in names if getattr(model, part) is not None]


def _terms(model: BrakeModel, point: OperatingPoint,
           x: ComplexArray) -> list[tuple[str, ComplexArray]]:
    """Each term of D and K times a vector, in the order of `TERMS`; what the model has."""
    factors = point.coefficients()
    result = [('structural_damping', factors.material_damping * model.structural_damping * x),
              ('structural_stiffness', model.angular_frequencies**2 * x)]
    scales = (1.0, factors.material_damping)
    result += [(name, scale * (array @ x)) for name, scale in zip(SUPPORTS, scales, strict=True)
               if (array := getattr(model, name)) is not None]
    for name in _VARYING:
        forces = [getattr(factors, part) * (getattr(model, part) @ x)
                  for part in _parts(model, name)]
        if forces:
            result.append((name, sum(forces[1:], forces[0])))
    return result


def _without(model: BrakeModel, point: OperatingPoint, modes: Sequence[Mode],
             limits: Tolerances) -> dict[int, dict[str, float]]:
    """Growth rates by index of mode and by term taken out."""
    start = numbered(model, _fading(model, point, ()), tolerances=limits)
    factors = point.coefficients()
    present = [name for name in _VARYING if name != 'contact_stiffness'
               and any(getattr(factors, part) != 0.0 for part in _parts(model, name))]
    rotation = tuple(name for name in present if name in ROTATION)
    result: dict[int, dict[str, float]] = {mode.index: {} for mode in modes}
    for term, names in [*((name, (name,)) for name in present), ('rotation', rotation)]:
        end = follow(model, _fading(model, point, names), start, tolerances=limits)
        for index, growth in result.items():
            growth[term] = end.of((index,))[0].growth_rate
    return result


def _fading(model: BrakeModel, point: OperatingPoint, names: Sequence[str]) -> MatrixPath:
    damping, stiffness = model.damping(point), model.stiffness(point)
    factors = point.coefficients()

    def family(way: float) -> tuple[FloatArray, FloatArray]:
        d, k = damping.copy(), stiffness.copy()
        for name in names:
            matrix = d if _damps(name) else k
            for part in _parts(model, name):
                matrix -= way * getattr(factors, part) * getattr(model, part)
        return d, k

    return family


def _mechanism(model: BrakeModel, point: OperatingPoint, mode: Mode,
               without: Mapping[str, float], top: int, limits: Tolerances) -> Mechanism:
    eigenvalue = 0j if mode.kind == 'rigid' else mode.eigenvalue
    vectors = mode_vectors(model, point, eigenvalue)
    label, reason = _label(mode, without, limits)
    return Mechanism(
        mode=mode, label=label, reason=reason, without=without,
        contributions=contributions(model, point, vectors), powers=powers(model, point, vectors),
        participation=participation(model, vectors.right, top=top))


def _label(mode: Mode, without: Mapping[str, float], limits: Tolerances) -> tuple[Label, str]:
    if not mode.unstable:
        return 'stable', f'growth rate {mode.growth_rate:+.2f} 1/s'
    needed = {name: growth for name, growth in without.items()
              if name != 'rotation' and growth <= limits.growth}
    words = [f'{growth:+.2f} 1/s without {name.replace("_", " ")}'
             for name, growth in without.items()]
    reason = f'growth rate {mode.growth_rate:+.2f} 1/s; ' + ', '.join(words)
    if mode.kind == 'divergence':
        return 'divergence', f'grows without oscillating: {reason}'
    if 'friction_couple' in needed and without['rotation'] > limits.growth:
        return 'mode coupling', f'friction couple needed, rotation not: {reason}'
    others = {name: growth for name, growth in needed.items() if name in _LABELS}
    if others:
        term = min(others, key=lambda name: others[name])
        return _LABELS[term], f'{term.replace("_", " ")} needed: {reason}'
    if needed:
        return 'mode coupling', f'friction couple alone needed: {reason}'
    return 'combined', f'no single term needed: {reason}'

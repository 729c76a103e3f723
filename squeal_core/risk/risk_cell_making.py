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

"""How a cell is made: anchors along the contact stiffness, which modes matter, where it holds."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.quadrature import TensorQuadrature
from squeal_core.risk.risk_cell import (
    Blocks,
    Box,
    box_around,
    Cell,
    Family,
    inside,
    Spread,
    STIFFNESS,
)
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion

_PARTS = (1.0, 0.6, 0.35, 0.2)  # of the greatest box, tried until the series hold
_TOLERANCE = 1.0  # 1/s, mean error of growth rates near zero
_NEAR = 20.0  # 1/s from zero; farther off a sign is certain
_WIDE, _CHECKED = 3.0, 1.5  # deviations: for which modes may matter, at which errors are measured
_CERTAIN = 0.3  # part of a growth rate that it may be off by
_MARGIN = 1.0  # 1/s, on what does not change sign
_CAP = 5.0  # 1/s, up to which an error counts at one contact stiffness of many
_SMALL = 1e-3  # of a scaled step, for differences
_LOST = -1e3  # 1/s, of a mode that is not there
# modes that couple more than this share a block; more where the contact stiffness is improbable
_COUPLING, _PROBABLE, _LOOSE = 0.12, 0.1, 1.0
_LARGEST = 4  # modes in a block; beyond it the coupling that counts is larger
_FRICTION = 0.2  # part of friction that the spread may be; beyond it blocks are larger


def build_cell(family: Family, inputs: Sequence[float], spread: Spread, rule: TensorQuadrature,
               band: tuple[float, float], level: float = 0.0) -> Cell:
    """
    Return a cell around (speed, pressure, friction); takes some 60 ms for each node.

    Parameters
    ----------
    family : Family
        Models of the matrices.
    inputs : (3,) floats
        Speed and pressure above zero.
    spread : Spread
        Standard deviations of the inputs.
    rule : TensorQuadrature
        Quadrature.
    band : (2,) floats
        Of the angular frequencies that count [rad/s].
    level : float
        Growth rate that counts as unstable [1/s].

    Raises
    ------
    numpy.linalg.LinAlgError
        Where an eigensolution fails or its vectors do not span the space.

    """
    masses = rule.stiffness_masses.sum(axis=1)
    anchors = _anchors(family, inputs, spread, rule, masses)
    for part in _PARTS:
        box = box_around(inputs, part)
        errors = _measured(
            anchors, family, box.widened(spread, _CHECKED), rule, band, level)
        if masses @ np.minimum(errors, _CAP) <= _TOLERANCE:
            break
    samples = _samples(family, box.widened(spread, _WIDE), rule)
    seen = []
    for anchor, factor in zip(anchors, rule.factors, strict=True):
        seen.append(_seen(anchor, factor, samples, band, level))
    labels = _labels(anchors, rule)
    return replace(_gathered(inputs, box, spread, rule, anchors, seen, labels, errors),
                   level=level)


def _gathered(inputs: Sequence[float], box: Box, spread: Spread, rule: TensorQuadrature,
              anchors: Sequence[SpectralExpansion], seen: Sequence['_Seen'],
              labels: Sequence[IndexArray], errors: FloatArray) -> Cell:
    middle = anchors[rule.nodes // 2]
    return Cell(
        inputs=readonly(inputs), box=box, spread=spread, rule=rule, rows=middle.rows,
        centre=middle.centre, scales=middle.scales, monomials=middle.monomials,
        blocks=_blocks(anchors, seen, labels), others=readonly([s.others for s in seen]),
        growth=readonly(_growth(seen, labels)), roots=readonly(_roots(middle), complex),
        slopes=readonly(_slopes(middle), complex), at_edge=any(s.at_edge for s in seen),
        errors=readonly(errors))


def _anchors(family: Family, inputs: Sequence[float], spread: Spread, rule: TensorQuadrature,
             masses: FloatArray) -> list[SpectralExpansion]:
    """Return an anchor at each of the rule's contact stiffnesses, none with a large block."""
    speed, pressure, friction = inputs
    wide = _WIDE * spread.friction
    least = _COUPLING * min(1.0, max(_FRICTION * friction / wide, 0.3) if wide else 1.0)
    found = []
    for factor, mass in zip(rule.factors.tolist(), masses.tolist(), strict=True):
        point = family.point(speed, pressure, friction, factor)
        coupling = min(least * max(1.0, _PROBABLE / mass), _LOOSE)
        while True:
            anchor = expand_spectrum(
                family.model, point, degree=rule.friction_nodes - 1, coupling=coupling,
                stiffness_step=0.5 * rule.spacing)
            if coupling >= _LOOSE or int(anchor.sizes.max(initial=0)) <= _LARGEST:
                break
            coupling *= 2.0
        found.append(anchor)
    return found


def _measured(anchors: Sequence[SpectralExpansion], family: Family, box: Box,
              rule: TensorQuadrature, band: tuple[float, float], level: float) -> FloatArray:
    """Return the error of growth rates near the level (nodes,), each at a corner of the box."""
    found, corners = [], box.corners
    for node, anchor in enumerate(anchors):
        speed, pressure, friction = corners[(3 * node) % len(corners)]
        end = rule.factors[node] * np.exp((0.5 - node % 2) * rule.spacing)
        point = family.point(speed, pressure, max(friction, 1e-3), end)
        found.append(_error(anchor, family.model, point, band, level))
    return np.array(found)


def _error(anchor: SpectralExpansion, model: BrakeModel, point: OperatingPoint,
           band: tuple[float, float], level: float) -> float:
    truth = eigenvalues(model, point)
    roots = anchor.eigenvalues(np.array(point.coefficients())[:, None])[0][:, 0]
    return max(_farthest(truth, roots, band, level), _farthest(roots, truth, band, level))


def _farthest(some: ComplexArray, others: ComplexArray, band: tuple[float, float],
              level: float) -> float:
    """Return how far a root near growth in the band is from the next of the others, at most."""
    near = some[(np.abs(some.real - level) < _NEAR) & (some.imag > band[0])
                & (some.imag < band[1])]
    return float(np.abs(near[:, None] - others).min(axis=1).max(initial=0.0))


def _samples(family: Family, box: Box, rule: TensorQuadrature) -> FloatArray:
    """Return coefficients (6, P) at the corners of the box and at both ends of a node's part."""
    found = []
    for corner, end in product(box.corners, (-0.5, 0.5)):
        coefficients = family.coefficients(*corner)
        coefficients[STIFFNESS] *= np.exp(end * rule.spacing)
        found.append(coefficients)
    return np.stack(found, axis=1)


@dataclass(frozen=True)
class _Seen:
    """What the samples say of the modes at a node, and which blocks may change sign."""

    matters: Any  # (blocks,)
    growth: FloatArray  # (n,) at the centre
    others: float
    at_edge: bool


def _seen(anchor: SpectralExpansion, factor: float, samples: FloatArray, band: tuple[float, float],
          level: float) -> _Seen:
    there = samples.copy()
    there[STIFFNESS] *= factor
    roots, errors = anchor.eigenvalues(there)
    off = _MARGIN + np.minimum(errors, _MARGIN + _CERTAIN * np.abs(roots.real - level))
    sure = (roots.imag - off > band[0]) & (roots.imag + off < band[1])
    outside = (roots.imag + off < band[0]) | (roots.imag - off > band[1])
    decays = (outside | (roots.real + off < level)).all(axis=1)
    grows = (sure & (roots.real - off > level)).all(axis=1)
    open_ = ~(decays | grows)
    owner = np.repeat(np.arange(anchor.sizes.size), anchor.sizes)
    matters = np.zeros(anchor.sizes.size, bool)
    matters[owner[open_]] = True
    growth = inside(_roots(anchor), band)
    others = float(growth[~matters[owner]].max(initial=_LOST))
    return _Seen(matters, growth, others, bool((open_ & ~sure.all(axis=1)).any()))


def _labels(anchors: Sequence[SpectralExpansion], rule: TensorQuadrature) -> list[IndexArray]:
    """
    Return which mode each root of each anchor is: its place among those of the middle one.

    Halfway between two contact stiffnesses both anchors know the roots.
    """
    middle = len(anchors) // 2
    found = {middle: np.arange(int(anchors[middle].sizes.sum()))}
    for way, end in ((1, len(anchors)), (-1, -1)):
        for node in range(middle + way, end, way):
            found[node] = _continued(
                found[node - way], anchors[node - way], anchors[node],
                np.exp(-0.5 * way * rule.spacing))
    return [readonly(found[node], np.intp) for node in range(len(anchors))]


def _continued(labels: IndexArray, known: SpectralExpansion, anchor: SpectralExpansion,
               factor: float) -> IndexArray:
    """Return the labels of an anchor's roots by those of one beside it that is known."""
    between = np.array(anchor.point.coefficients())[:, None]
    between[STIFFNESS] *= factor
    old, new = linear_sum_assignment(
        np.abs(known.eigenvalues(between)[0] - anchor.eigenvalues(between)[0].T))
    found = np.full(int(anchor.sizes.sum()), -1)
    found[new] = labels[old]
    return found


def _roots(anchor: SpectralExpansion) -> ComplexArray:
    return anchor.eigenvalues(np.array(anchor.point.coefficients())[:, None])[0][:, 0]


def _slopes(anchor: SpectralExpansion) -> ComplexArray:
    """Return the change of the roots with z (n, v), by central differences."""
    steps = _SMALL * np.concatenate([np.eye(anchor.rows.size), -np.eye(anchor.rows.size)], axis=1)
    there = np.repeat(np.array(anchor.point.coefficients())[:, None], steps.shape[1], axis=1)
    there[anchor.rows] += anchor.scales[:, None] * steps
    plus, minus = np.split(anchor.eigenvalues(there)[0], 2, axis=1)
    return np.asarray((plus - minus) / (2.0 * _SMALL))


def _growth(seen: Sequence[_Seen], labels: Sequence[IndexArray]) -> FloatArray:
    """Return the growth rate of each mode (modes, nodes) at the centre."""
    count = max(int(label.max(initial=-1)) for label in labels) + 1
    found = np.full((count, len(seen)), _LOST)
    for node, (what, label) in enumerate(zip(seen, labels, strict=True)):
        found[label[label >= 0], node] = what.growth[label >= 0]
    return found


def _blocks(anchors: Sequence[SpectralExpansion], seen: Sequence[_Seen],
            labels: Sequence[IndexArray]) -> tuple[Blocks, ...]:
    """Collect the blocks that matter, by their size."""
    parts: dict[int, list[tuple[int, IndexArray, ComplexArray]]] = {}
    for node, (anchor, what, label) in enumerate(zip(anchors, seen, labels, strict=True)):
        roots = np.concatenate([[0], np.cumsum(anchor.sizes)])
        for block in np.flatnonzero(what.matters).tolist():
            series = anchor.layout.block(anchor.series, block).T
            parts.setdefault(int(anchor.sizes[block]), []).append(
                (node, label[roots[block]:roots[block + 1]], series))
    return tuple(
        Blocks(size, readonly([p[0] for p in parts[size]], np.intp),
               readonly(np.stack([p[1] for p in parts[size]]), np.intp),
               readonly(np.concatenate([p[2] for p in parts[size]]), complex))
        for size in sorted(parts))

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

"""Models and points that tests of the engine share."""

from typing import Any

import numpy as np
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.arrays import FloatArray

STIFFNESS = 0.35e11


def random_model(size: int, seed: int = 0, **changes: Any) -> BrakeModel:
    """
    Return a model with the symmetries of a brake's arrays and their sizes in K09's model.

    Every mode has shapes at as many points of contact as there are modes; the spacing of the
    frequencies is that of K09's.
    """
    generator = np.random.default_rng(seed)

    def shapes() -> FloatArray:
        return np.asarray(generator.normal(size=(size, size)) / np.sqrt(size))

    normal, tangent, radial, turned = shapes(), shapes(), shapes(), shapes()
    return BrakeModel(**{
        'angular_frequencies': np.sort(generator.uniform(4e3, 4e3 + 700.0 * size, size)),
        'damping_ratios': 0.002, 'gyroscopic': turned - turned.T,
        'contact_stiffness': 1e-2 * normal.T @ normal,
        'friction_couple': 1e-2 * tangent.T @ normal,
        'radial_dissipation': 1e-2 * radial.T @ radial,
        'negative_slope': 1e-2 * tangent.T @ tangent, **changes})


def crossing_model() -> BrakeModel:
    """Return a brake whose pad mode passes a doublet of the disc at the nominal k_c, 2.7 kHz."""
    disc, pad = 2.0 * np.pi * np.array([2000.0, 2700.0, 2712.0]), 2.0 * np.pi * 2400.0
    nominal = 3.5e10
    carried = np.sqrt(((2.0 * np.pi * 2706.0) ** 2 - pad**2) / nominal)
    normal = carried * np.array([0.12, 1.0, 0.15, 0.1])  # the pad's mode is the second one
    radial = np.array([0.04, 0.08, -0.05, 0.06])
    turned = np.triu(np.full((4, 4), 0.8), 1)
    return BrakeModel(
        angular_frequencies=np.insert(disc, 1, pad), damping_ratios=0.002,
        gyroscopic=turned - turned.T, contact_stiffness=np.outer(normal, normal),
        friction_couple=np.outer(carried * np.array([0.3, 0.6, -0.2, 0.25]), normal),
        radial_dissipation=np.outer(radial, radial), negative_slope=np.outer(radial, radial),
        nominal_contact_stiffness=nominal, friction_law=FrictionLaw())


def dense_model(seed: int, size: int = 4) -> BrakeModel:
    """Return a model whose six arrays all count at an ordinary operating point."""
    generator = np.random.default_rng(seed)
    skew, *square = generator.standard_normal((6, size, size))
    a, r, s = (x @ x.T for x in square[:3])
    return BrakeModel(
        angular_frequencies=np.sort(generator.uniform(1e3, 1e4, size)), damping_ratios=0.01,
        gyroscopic=skew - skew.T, contact_stiffness=1e-3 * a, friction_couple=1e-3 * square[3],
        radial_dissipation=1e-4 * r, negative_slope=1e-4 * s, follower=square[4])


def point(**changes: float) -> OperatingPoint:
    """Return an operating point in the middle of the range."""
    return OperatingPoint(**{
        'rotor_speed': 20.0, 'friction': 0.42, 'friction_slope': -0.02, 'contact_pressure': 7e5,
        'contact_stiffness': STIFFNESS, **changes})


def near(start: OperatingPoint, step: float, generator: np.random.Generator) -> OperatingPoint:
    """Return a point up to a relative step away; a tenth of it in the slope [s/m]."""
    shares = generator.uniform(-1.0, 1.0, 5)
    names = ('rotor_speed', 'friction', 'contact_pressure', 'contact_stiffness')
    return OperatingPoint(
        **{name: getattr(start, name) * float(1.0 + step * share)
           for name, share in zip(names, shares, strict=False)},
        friction_slope=start.friction_slope + 0.1 * step * float(shares[4]))


def between(start: OperatingPoint, end: OperatingPoint, part: float) -> OperatingPoint:
    """Return a point on the straight way between two."""
    return OperatingPoint(**{name: value + part * (getattr(end, name) - value)
                             for name, value in start.__dict__.items()})

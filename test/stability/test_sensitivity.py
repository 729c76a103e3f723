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

"""Sensitivities against differences of the roots, and first-order risk against Monte Carlo."""

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.operating_point import Coefficients, DAMPING
from squeal_core.common.arrays import ComplexArray
from squeal_core.stability.eigensolution import complex_modes, eigenvalues
from squeal_core.stability.parameter_paths import PARAMETERS
from squeal_core.stability.sensitivity import (
    eigenvalue_sensitivity,
    parameter_sensitivity,
)
from support.eigenvalues import companion
from support.engine_models import dense_model
from support.stability_models import kang_point, POINT

OF_K09 = (*Coefficients._fields[:5], 'material_damping')


def falling(model: BrakeModel, speed: float) -> OperatingPoint:
    return replace(kang_point(model, speed), friction_slope=-0.02)


def roots_at(model: BrakeModel, coefficients: Coefficients) -> ComplexArray:
    """Roots for any coefficients, whether an operating point has them or not."""
    damping, stiffness = np.zeros((model.size,) * 2), np.diag(model.angular_frequencies**2)
    for name, factor in coefficients._asdict().items():
        array = getattr(model, name)
        if array is not None and name in DAMPING:
            damping = damping + factor * array
        elif array is not None:
            stiffness = stiffness + factor * array
    return np.linalg.eigvals(companion(stiffness, damping))


def viscous_model(seed: int) -> BrakeModel:
    """Return the dense model with a layer that damps as much as it is stiff."""
    return replace(dense_model(seed), contact_retardation_time=1e-4)


Value = Coefficients | OperatingPoint
Kind = tuple[Callable[..., Mapping[str, complex]], Callable[[OperatingPoint], Value],
             Callable[[BrakeModel, Any], ComplexArray]]
OF_COEFFICIENTS: Kind = eigenvalue_sensitivity, OperatingPoint.coefficients, roots_at
OF_PARAMETERS: Kind = parameter_sensitivity, lambda point: point, eigenvalues


def off(kind: Kind, model: BrakeModel, point: OperatingPoint, name: str, root: complex,
        part: float) -> tuple[complex, complex, float]:
    """
    Return d root / d coefficient or parameter, the same by differences, and their step.

    Fourth-order central differences that follow the root, all but `name` held.
    """
    sensitivity, value_at, roots_of = kind
    at = value_at(point)
    step = part * abs(getattr(at, name))

    def moved(times: float) -> complex:
        change: Any = {name: getattr(at, name) + times * step}
        roots = roots_of(model, at._replace(**change) if isinstance(at, Coefficients)
                         else replace(at, **change))
        return complex(roots[np.abs(roots - root).argmin()])

    expected = (8.0 * (moved(1.0) - moved(-1.0)) - (moved(2.0) - moved(-2.0))) / (12.0 * step)
    return sensitivity(model, point, root)[name], expected, step


# ---------------------------------------------------------------- sensitivities

@pytest.mark.parametrize(('kind', 'name'), [
    *((OF_COEFFICIENTS, name) for name in Coefficients._fields),
    *((OF_PARAMETERS, item.name) for item in fields(OperatingPoint))])
@pytest.mark.parametrize(('seed', 'scale'), [(0, 1.0), (1, 0.4), (2, 1.0)])
def test_against_differences(seed: int, scale: float, kind: Kind, name: str) -> None:
    """Of the operating point, the damping scale among them, and what multiplies the arrays."""
    model, point = viscous_model(seed), replace(POINT, damping_scale=scale)
    for root in map(complex, eigenvalues(model, point)):
        found, expected, step = off(kind, model, point, name, root, 1e-3)
        # (1e-3)^4 cut off; roots rounded to eps * 1e4 * 1e2, over the step
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-9 / step)
        assert abs(expected) * step > 1e-6  # so the roots do move


@pytest.mark.parametrize(('kind', 'name'), [*((OF_COEFFICIENTS, name) for name in OF_K09),
                                            *((OF_PARAMETERS, name) for name in PARAMETERS)])
@pytest.mark.parametrize('speed', [5.0, 20.0])
def test_shipped_model_against_differences(speed: float, kind: Kind, name: str,
                                           kang: BrakeModel) -> None:
    point = falling(kang, speed)
    unstable = [m for m in complex_modes(kang, point).unstable if m.kind == 'flutter']
    assert len(unstable) > 1
    for mode in unstable:
        found, expected, step = off(kind, kang, point, name, mode.eigenvalue, 1e-4)
        # roots rounded to eps * 2e5 * 1e3, over the step
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-7 / step)


def test_only_what_the_model_has(kang: BrakeModel) -> None:
    point = falling(kang, 5.0)
    root = complex_modes(kang, point).unstable[0].eigenvalue
    assert tuple(eigenvalue_sensitivity(kang, point, root)) == OF_K09
    bare = BrakeModel(angular_frequencies=[1e3, 2e3], negative_slope=[[1e-3, 1e-4], [1e-4, 1e-3]])
    found = eigenvalue_sensitivity(bare, POINT, complex_modes(bare, POINT).modes[0].eigenvalue)
    assert tuple(found) == ('negative_slope', 'material_damping')


def test_one_mode_in_closed_form() -> None:
    """lambda^2 + (c + s S) lambda + w^2 + k A = 0, differentiated by hand."""
    model = BrakeModel(angular_frequencies=[1e3], damping_ratios=0.01,
                       contact_stiffness=[[2e-4]], negative_slope=[[3e-4]])
    root = complex_modes(model, POINT).modes[0].eigenvalue
    found = eigenvalue_sensitivity(model, POINT, root)
    damping = 20.0 - 5e4 * 3e-4
    # one mode: nothing but rounding
    assert found['negative_slope'] == pytest.approx(
        -3e-4 * root / (2.0 * root + damping), rel=1e-12)
    assert found['contact_stiffness'] == pytest.approx(-2e-4 / (2.0 * root + damping), rel=1e-12)


def test_the_tangent_is_first_order() -> None:
    """All coefficients at once: what the tangent misses falls with the step's square."""
    model, at = viscous_model(2), POINT.coefficients()

    def missed(step: float, root: complex) -> tuple[float, float]:
        """Return what the tangent is off, and the change itself."""
        there = Coefficients(*(c * (1.0 + sign * step) for c, sign in zip(
            at, (1, -1, 1, 1, -1, 1, -1, 1, 1), strict=True)))
        moved = roots_at(model, there)
        change = float(moved[np.abs(moved - root).argmin()].real - root.real)
        slopes = eigenvalue_sensitivity(model, POINT, root)
        tangent = sum(slopes[name].real * (after - before) for name, before, after in zip(
            Coefficients._fields, at, there, strict=True) if name in slopes)
        return tangent - change, change

    for root in map(complex, roots_at(model, at)):
        (coarse, change), (fine, _) = missed(1e-3, root), missed(5e-4, root)
        assert abs(coarse) < 0.01 * abs(change)
        assert coarse / fine == pytest.approx(4.0, abs=0.05)  # the cubic term is 1e-2 of it

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

"""Derivatives of eigenvalues over coefficients of the affine family and over parameters."""

from squeal_core.brake.operating_point import Coefficients, DAMPING, OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigenvectors import mode_vectors, slope_between


def eigenvalue_sensitivity(model: BrakeModel, point: OperatingPoint,
                           eigenvalue: complex) -> dict[str, complex]:
    """
    Return d lambda / d c for each coefficient c of `OperatingPoint.coefficients`.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Operating point.
    eigenvalue : complex
        A simple eigenvalue of the model at the point [1/s].

    Returns
    -------
    dict
        By coefficient name; in 1/s per unit of the coefficient.

    Notes
    -----
    d lambda / d c = -y^H (lambda dD/dc + dK/dc) x / (y^H (2 lambda + D) x) with right and left
    vectors x and y (Lancaster 1964). Near a merging of two eigenvalues it grows without bound.

    """
    vectors = mode_vectors(model, point, eigenvalue)
    x, y = vectors.right, vectors.left.conj()
    scale = slope_between(eigenvalue, x, vectors.left, model.damping(point))
    result = {}
    for name in Coefficients._fields:
        array = getattr(model, name)
        if array is not None:
            factor = eigenvalue if name in DAMPING else 1.0
            result[name] = complex(-factor * (y @ (array @ x)) / scale)
    return result


def parameter_sensitivity(model: BrakeModel, point: OperatingPoint,
                          eigenvalue: complex) -> dict[str, complex]:
    """
    Return d lambda / d q for each parameter q of the operating point, the others held.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Operating point.
    eigenvalue : complex
        A simple eigenvalue of the model at the point [1/s].

    Returns
    -------
    dict
        By parameter name; in 1/s per SI unit of the parameter.

    Notes
    -----
    The chain rule over the coefficients, and `eigenvalue_sensitivity` for theirs.

    """
    sensitivity = eigenvalue_sensitivity(model, point, eigenvalue)
    return {parameter: sum((factor * sensitivity.get(name, 0.0)
                            for name, factor in slopes.items()), 0j)
            for parameter, slopes in _slopes(point).items()}


def _slopes(q: OperatingPoint) -> dict[str, dict[str, float]]:
    """Return d c / d q of each coefficient by each parameter, where not zero."""
    speed, load, scale = q.rotor_speed, q.contact_pressure, q.damping_scale
    stiffness = q.contact_stiffness
    return {
        'rotor_speed': {'gyroscopic': 1.0, 'radial_dissipation': -load * q.friction / speed**2},
        'friction': {'radial_dissipation': load / speed, 'follower': load,
                     'friction_couple': stiffness,
                     'contact_damping_couple': scale * stiffness},
        'friction_slope': {'negative_slope': load},
        'contact_pressure': {'radial_dissipation': q.friction / speed, 'follower': q.friction,
                             'negative_slope': q.friction_slope},
        'contact_stiffness': {'contact_stiffness': 1.0, 'friction_couple': q.friction,
                              'contact_damping': scale,
                              'contact_damping_couple': scale * q.friction},
        'damping_scale': {'material_damping': 1.0, 'contact_damping': stiffness,
                          'contact_damping_couple': q.friction * stiffness}}

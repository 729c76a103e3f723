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


"""The force that transients integrate: its derivatives are the model's matrices; it opens."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.assembly.build import contact_arrays
from squeal_core.brake.operating_point import OperatingPoints
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelError
from squeal_core.model import operators
from squeal_core.model.operators import ContactFace
from squeal_core.model.surface_shapes import SurfaceShapes
from squeal_core.simulation import contact_points, NonlinearContact, Transient
from squeal_core.simulation.history import OperatingHistory
from support.rows import each

Faces = tuple[ContactFace, ContactFace]
POINT = OperatingPoint(rotor_speed=5.0, friction=0.42, friction_slope=-0.08,
                       contact_pressure=4e5, contact_stiffness=0.35e11)


def calm(model: BrakeModel, faces: Faces, *points: OperatingPoint) -> Transient:
    return Transient(model, faces, OperatingHistory.ramps(points, points, 0.01), floor=0.0,
                     abutment=False)


def jacobian(function: Callable[[FloatArray], FloatArray], size: int, step: float) -> FloatArray:
    """Central differences, a column for each coordinate; `function` takes columns at once."""
    return (function(step * np.eye(size)) - function(-step * np.eye(size))) / (2.0 * step)


@pytest.mark.parametrize('point', [
    POINT, replace(POINT, rotor_speed=-20.0, friction=-0.42), replace(POINT, rotor_speed=0.6)],
    ids=['forwards', 'backwards', 'slow'])
@pytest.mark.parametrize('follower', [False, True])
def test_the_derivatives_of_the_force_are_the_matrices_of_the_model(
        kang: BrakeModel, faces: Faces, point: OperatingPoint, follower: bool) -> None:
    own = replace(kang, contact_retardation_time=3e-6, **contact_arrays(faces),  # type: ignore
                  follower=operators.follower(faces) if follower else None)
    n = kang.size
    state = OperatingPoints.stacked([point] * n)
    transient = calm(own, faces, replace(point, contact_stiffness=0.3e11))  # the springs differ
    rest = np.zeros((n, n))
    found = {
        'stiffness': -jacobian(lambda a: transient.acceleration(a, rest, state), n, 1e-9),
        'damping': -jacobian(lambda v: transient.acceleration(rest, v, state), n, 1e-5)}
    for name, matrix in found.items():
        wanted = getattr(own, name)(point)
        assert np.abs(matrix - wanted).max() < 1e-7 * np.abs(wanted).max(), name
    contact = found['stiffness'] - np.diag(own.angular_frequencies**2)
    shipped = kang.stiffness(point) - np.diag(kang.angular_frequencies**2)
    # the points integrate what the model has of twenty times as many
    assert np.abs(contact - shipped).max() < 5e-3 * np.abs(shipped).max()


def test_dashpots_of_the_contact_rub_too(kang: BrakeModel, faces: Faces) -> None:
    """Their force is normal: D gains c_c (A0 + mu B0)."""
    tau, n = 3e-6, kang.size
    state, rest = OperatingPoints.stacked([POINT] * n), np.zeros((n, n))

    def damping(retardation: float) -> FloatArray:
        contact = NonlinearContact(faces, retardation_time=retardation).at(
            state, closed_stiffness=0.0)
        return -jacobian(lambda v: sum(contact.forces(rest, v), rest), n, 1e-5)

    arrays = contact_arrays(faces)
    wanted = tau * POINT.contact_stiffness * (
        arrays['contact_stiffness'] + POINT.friction * arrays['friction_couple'])
    gained = damping(tau) - damping(0.0)
    assert np.abs(gained - wanted).max() < 1e-7 * np.abs(wanted).max()


def test_an_open_contact_bears_nothing_and_rubs_nowhere(kang: BrakeModel, faces: Faces) -> None:
    """A pad 1 mm off leaves the preload of its back alone, and no friction at its face."""
    state = OperatingPoints.stacked([POINT])
    contact = NonlinearContact(faces).at(state, closed_stiffness=0.35e11)
    first = contact_arrays(faces)['contact_stiffness'][:20, :20]
    lift = np.zeros((kang.size, 1))
    lift[:20] = np.linalg.lstsq(  # of pad 1, uniform, away from the disc
        faces[0].normal[:20].T, np.full((faces[0].weight.size, 1), -1e-3), rcond=None)[0]
    assert np.allclose(faces[0].normal.T @ lift, -1e-3, rtol=1e-6)
    stress = contact.normal_stress(lift, np.zeros_like(lift))
    count = faces[0].weight.size
    assert not stress[:count].any()
    assert np.allclose(stress[count:], POINT.contact_pressure)
    normal, friction = contact.forces(lift, np.zeros_like(lift))
    springs = normal[:20] - POINT.contact_stiffness * first @ lift[:20]
    preload = POINT.contact_pressure * faces[0].normal[:20] @ faces[0].weight
    assert np.allclose(springs[:, 0], preload, rtol=0, atol=1e-6 * np.abs(preload).max())
    steady = POINT.friction * POINT.contact_pressure * faces[0].tangential @ faces[0].weight
    assert np.allclose(friction[:, 0], steady, rtol=0, atol=1e-9 * np.abs(steady).max())


def test_friction_follows_its_law_far_from_its_slope(faces: Faces, kang: BrakeModel) -> None:
    """A pad that moves against the disc slides faster: mu falls by the law, not by its slope."""
    law = kang.friction_law
    assert law is not None
    radius, faster = 0.12, 2.0
    face = ContactFace(normal=np.zeros((1, 1)), tangential=np.ones((1, 1)),
                       radial=np.zeros((1, 1)), spin=np.zeros((1, 1)),
                       radius=np.array([radius]), weight=np.array([1.0]))
    speed = 5.0
    point = replace(POINT, friction=law.coefficient(radius * speed),
                    friction_slope=law.slope(radius * speed))
    contact = NonlinearContact([face], decay=law.decay).at(OperatingPoints.stacked([point]),
                                                           closed_stiffness=0.35e11)
    force = contact.forces(np.zeros((1, 1)), np.full((1, 1), faster)).friction.item()
    wanted = law.coefficient(radius * speed) - law.coefficient(radius * speed + faster)
    assert force == pytest.approx(point.contact_pressure * wanted, rel=1e-9)


def turned(kang: BrakeModel) -> tuple[BrakeModel, FloatArray]:
    """Return the model as another eigensolver would give it: signs, and the turn of a doublet."""
    size = kang.size
    turn = np.diag(np.where(np.arange(size) % 3 == 0, -1.0, 1.0))
    first = next(i for i in range(20, size) if kang.names[i] == 'disc (2,0)c')
    c, s = np.cos(0.7), np.sin(0.7)
    turn[first:first + 2, first:first + 2] = [[c, -s], [s, c]]
    surface = kang.surface
    assert surface is not None
    names = ('gyroscopic', 'contact_stiffness', 'friction_couple', 'radial_dissipation',
             'negative_slope')
    return replace(kang, surface=SurfaceShapes(
        surface.points, surface.shapes @ turn, surface.patches), **{
            name: turn.T @ getattr(kang, name) @ turn for name in names}), turn


def test_shapes_are_turned_to_the_model(kang: BrakeModel, faces: Faces) -> None:
    model, turn = turned(kang)
    found = contact_points(model)
    for plain, other in zip(faces, found, strict=True):
        assert np.allclose(other.normal, turn.T @ plain.normal, rtol=0, atol=1e-5)
        assert np.allclose(other.radial, turn.T @ plain.radial, rtol=0, atol=1e-5)


@each(('change', 'text'), [
    (lambda model: replace(model, provenance={}, contact_stiffness=None),
     'keeps no brake description'),
    (lambda model: replace(model, friction_couple=1.2 * model.friction_couple),
     'friction_couple: differs by 0.1')])
def test_models_without_contact_points_are_refused(
        kang: BrakeModel, faces: Faces, change: Callable[[BrakeModel], BrakeModel],
        text: str) -> None:
    with pytest.raises(ModelError, match=text):
        contact_points(change(kang))

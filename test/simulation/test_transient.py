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


"""Transients against the linear model, the balance of energy, and what noise should do."""

from dataclasses import replace
import doctest
import importlib

import numpy as np
import pytest
from squeal_core import BrakeModel, complex_modes, OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.model.operators import ContactFace
from squeal_core.simulation import OperatingHistory, Transient, TransientBlock
from support.eigenvalues import companion_at

Faces = tuple[ContactFace, ContactFace]
# rotor speed, brake pressure, friction
POINTS = ((5.0, 7.84e5, 0.42), (20.0, 7.84e5, 0.42), (10.0, 2e6, 0.5), (5.0, 7.84e5, 0.3))


def operating(kang: BrakeModel, speed: float, pressure: float, friction: float) -> OperatingPoint:
    return kang.operating_point(rotor_speed=speed, pressure=pressure, friction=friction,
                                friction_slope=0.0)


def eigenvectors(model: BrakeModel, point: OperatingPoint, least: float
                 ) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return eigenvalues, left and right vectors of the modes that grow faster than `least`."""
    from scipy.linalg import eig
    values, left, right = eig(companion_at(model, point), left=True)
    chosen = (values.imag > 100.0) & (values.real > least)
    return values[chosen], left[:, chosen], right[:, chosen]


def states(blocks: list[TransientBlock]) -> tuple[FloatArray, FloatArray]:
    """Return times of shape (F,) and states of shape (F, 2N, B)."""
    return (np.concatenate([block.time for block in blocks]), np.concatenate([
        np.concatenate([block.displacement, block.velocity], axis=1) for block in blocks]))


@pytest.mark.parametrize('steps', [1, 2])
def test_small_disturbances_grow_at_the_rate_of_the_linear_model(
        kang: BrakeModel, faces: Faces, steps: int) -> None:
    """Each unstable mode of four points, out of contact forces that know no matrix of friction."""
    points = [operating(kang, *values) for values in POINTS]
    modes = [eigenvectors(kang, point, 1.0) for point in points]
    start = np.column_stack([
        (1e-9 * right / np.abs(right[:kang.size]).max(axis=0)).sum(axis=1).real
        for _, _, right in modes])
    history = OperatingHistory.ramps(points, points, 0.03)
    time, found = states(list(Transient(kang, faces, history, floor=0.0, abutment=False,
                                        steps=steps).run(start)))
    compared = 0
    for brake, (values, left, _) in enumerate(modes):
        for value, vector in zip(values, left.T, strict=True):
            amplitude = found[:, :, brake] @ vector.conj()
            growth = np.polyfit(time, np.log(np.abs(amplitude)), 1)[0]
            pitch = np.polyfit(time, np.unwrap(np.angle(amplitude)), 1)[0]
            assert growth == pytest.approx(value.real, rel=0.01)
            assert pitch == pytest.approx(value.imag, rel=1e-5)
            compared += 1
    assert compared == 12


def test_squeal_saturates_near_the_loss_of_contact_and_energy_is_balanced(
        kang: BrakeModel, faces: Faces) -> None:
    """
    From 0.8 of p0 / k_c a mode of 48 1/s would grow by e^2.9 in 60 ms; it does not.

    Work of friction less dissipation is the change of energy, before and after contact is lost.
    """
    point = operating(kang, 20.0, 7.84e5, 0.5)
    values, _, right = eigenvectors(kang, point, 45.0)
    right = right[:, [int(np.argmin(np.abs(values.imag - 2.0 * np.pi * 7156.0)))]]
    transient = Transient(kang, faces, OperatingHistory.ramps([point], [point], 0.06), floor=0.0)
    gap = point.contact_pressure / point.contact_stiffness
    start = right.real * 0.8 * gap / np.abs(transient.contact.normal @ right[:kang.size]).max()
    blocks = list(transient.run(start))
    energy = np.array([block.balance.energy[0] for block in blocks])
    works = [(b.friction + b.abutment + b.noise - b.dissipation)[0] for b in
             (block.balance for block in blocks)]
    for before, after, work, block in zip(energy, energy[1:], works[1:], blocks[1:], strict=False):
        moved = block.balance.friction[0] + block.balance.dissipation[0]
        assert after - before == pytest.approx(work, abs=0.01 * abs(moved))
    growth = np.log(energy[1:] / energy[:-1]) / 2.0 / 0.01
    assert growth[0] > 40.0  # still nearly linear
    assert growth[-2:].max() < 20.0
    opened = -(blocks[-1].displacement[:, :, 0] @ transient.contact.normal.T).min()
    assert gap < opened < 30.0 * gap


def test_noise_holds_modes_at_their_floor(kang: BrakeModel, faces: Faces) -> None:
    """Without friction, modes above 10 kHz, which settle within a few ms."""
    point = operating(kang, 20.0, 7.84e5, 1e-9)
    history = OperatingHistory.ramps([point] * 4, [point] * 4, 0.025)
    transient = Transient(kang, faces, history, floor=2e-9)
    modes = transient.modes
    fast = modes.angular_frequencies > 2.0 * np.pi * 10e3
    _, found = states(list(transient.run()))
    q = np.einsum('fnb,nm->fmb', found[960:, :kang.size], modes.shapes[:, fast], optimize=True)
    size = np.sqrt((q**2).mean(axis=(0, 2))) * modes.contact_motion[fast]
    assert fast.sum() > 20
    assert np.sqrt((size**2).mean()) == pytest.approx(2e-9, rel=0.15)
    again = Transient(kang, faces, OperatingHistory.ramps([point] * 4, [point] * 4, 0.0005),
                      floor=2e-9)
    repeated = states(list(again.run()))[1]  # the seed alone decides
    assert np.allclose(repeated, found[:48], rtol=0, atol=1e-9 * np.abs(repeated).max())


def test_the_abutment_holds_pads_that_diverge(kang: BrakeModel, faces: Faces) -> None:
    """At 416 1/s a pad is 64 times as fast after 10 ms, unless it is held."""
    point = kang.operating_point(rotor_speed=5.0, pressure=7.84e5, friction=0.42)
    assert max(mode.growth_rate for mode in complex_modes(kang, point).modes
               if mode.kind == 'divergence') > 400.0
    free = kang.free_coordinates
    start = np.zeros((2 * kang.size, 1))
    start[kang.size:][free] = 1e-6
    history = OperatingHistory.ramps([point], [point], 0.01)
    rates = {held: states(list(Transient(kang, faces, history, floor=0.0, abutment=held).run(
        start)))[1][-1, kang.size:, 0][free] for held in (False, True)}
    assert np.abs(rates[False]).max() > 5e-5
    assert np.abs(rates[True]).max() < 1e-6


def test_a_released_brake_rests(kang: BrakeModel, faces: Faces) -> None:
    """One brake is released halfway, the other holds on; friction there is as before."""
    time = np.array([0.0, 0.0119, 0.012, 0.03])
    on = np.full(4, 8e5)
    history = OperatingHistory.of_signals(
        kang, ('released', 'held'), time=time, rotor_speed=np.full((4, 2), 20.0),
        pressure=np.column_stack([np.where(time > 0.0119, 0.0, on), on]),
        friction=np.full((4, 2), 0.4))
    blocks = list(Transient(kang, faces, history).run())
    assert [block.sliding.tolist() for block in blocks] == [
        [True, True], [False, True], [False, True]]
    assert blocks[0].velocity[:, :, 0].any()
    assert not blocks[-1].velocity[:, :, 0].any()
    assert blocks[-1].velocity[:, :, 1].any()


def test_each_brake_grows_with_its_own_damping(kang: BrakeModel, faces: Faces) -> None:
    """Two of one batch, with 20 % less and 25 % more damping than the model."""
    scales = (0.8, 1.25)
    points = [replace(operating(kang, 20.0, 7.84e5, 0.5), damping_scale=scale)
              for scale in scales]
    modes = [eigenvectors(kang, point, 20.0) for point in points]
    assert abs(modes[0][0].real.max() - modes[1][0].real.max()) > 5.0
    start = np.column_stack([
        (1e-9 * right / np.abs(right[:kang.size]).max(axis=0)).sum(axis=1).real
        for _, _, right in modes])
    transient = Transient(kang, faces, OperatingHistory.ramps(points, points, 0.03), floor=0.0,
                          abutment=False, damping_scale=scales)
    time, found = states(list(transient.run(start)))
    for brake, (values, left, _) in enumerate(modes):
        for value, vector in zip(values, left.T, strict=True):
            amplitude = np.log(np.abs(found[:, :, brake] @ vector.conj()))
            assert np.polyfit(time, amplitude, 1)[0] == pytest.approx(value.real, rel=0.01)


def test_a_brake_of_many_moves_as_it_does_alone(kang: BrakeModel, faces: Faces) -> None:
    """With noise of its own; and what has ended is integrated no further."""
    point = operating(kang, 20.0, 7.84e5, 0.5)
    alone, many = (Transient(kang, faces, OperatingHistory.ramps(
        [point] * count, [point] * count, 0.03), seed=seeds) for count, seeds in (
            (1, [7]), (3, [5, 7, 6])))
    single = list(alone.run())
    blocks = list(many.run(balance=False, ended=lambda time: np.array(
        [time > 0.005, False, time > 0.015])))
    assert [block.sliding.tolist() for block in blocks] == [
        [True, True, True], [False, True, True], [False, True, False]]
    assert not blocks[-1].velocity[:, :, 0].any()
    for one, other in zip(single, blocks, strict=True):  # rounding, by the shapes of products
        np.testing.assert_allclose(other.velocity[:, :, 1], one.velocity[:, :, 0], rtol=0.0,
                                   atol=1e-8 * np.abs(one.velocity).max())
    stopped = many.run(ended=lambda time: np.full(3, time > 0.005))
    assert len(list(stopped)) == 1


def test_steps_too_long_for_the_friction_are_refused(kang: BrakeModel, faces: Faces) -> None:
    point = operating(kang, 0.6, 5e7, 0.6)
    transient = Transient(kang, faces, OperatingHistory.ramps([point], [point], 0.01), steps=1)
    with pytest.raises(SquealError, match='give a shorter step'):
        list(transient.run())


@pytest.mark.parametrize('module', [
    'contact', 'history', 'simulated_sound', 'microphone', 'transient'])
def test_examples(module: str, faces: Faces) -> None:
    found = doctest.testmod(importlib.import_module(f'squeal_core.simulation.{module}'))
    assert found.attempted > 0
    assert found.failed == 0

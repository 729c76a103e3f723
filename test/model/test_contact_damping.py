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

"""Damping of the contact layer: closed forms, energy point by point, scales, and what stays."""

from dataclasses import replace
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.assembly.checks import truncated
from squeal_core.brake.damping import retardation_time
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelFileError, OperatingPointError, SquealError
from squeal_core.common.npz_archive import content_hash
from squeal_core.model import operators
from squeal_core.model.model_file import KIND, read_model
from squeal_core.model.operators import ContactFace
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.stability.mode_tracking import track
from squeal_core.surrogate.table_file import model_hash
from support.archives import parts
from support.eigenvalues import companion_at
from support.engine_models import random_model

POINT = OperatingPoint(rotor_speed=7.0, friction=0.45, friction_slope=-0.02, contact_pressure=5e5,
                       contact_stiffness=2e10)
TIME = 8e-6  # s
# SHA-256 of what the spectrum of the shipped model depends on, before there was contact damping
KANG = '63b16cd847a4c7d344444ced381db0b3debd582f4c13802a37bcd863356da24e'


def by_size(roots: FloatArray) -> FloatArray:
    return np.asarray(roots[np.lexsort((roots.real.round(6), roots.imag.round(3)))])


@pytest.mark.parametrize('friction', [0.0, 0.2, 0.45, 0.8])
def test_two_modes_on_a_viscous_layer_in_closed_form(friction: float) -> None:
    """
    Two modes that meet one patch of contact, without any matrix.

    The layer's force N = k (1 + tau d/dt) (n.a) acts on mode i by n_i + mu t_i, hence
    1 + k A (1 + tau l) sum_i n_i (n_i + mu t_i) / (l^2 + 2 xi_i w_i l + w_i^2) = 0: a quartic.
    """
    w, xi, area = np.array([1.98e4, 2.02e4]), np.array([0.004, 0.006]), 2.4e-3
    n, t = np.array([1.3, -0.9]), np.array([0.8, 1.1])
    model = BrakeModel(angular_frequencies=w, damping_ratios=xi, contact_retardation_time=TIME,
                       contact_stiffness=area * np.outer(n, n),
                       friction_couple=area * np.outer(t, n))
    alone = [np.array([1.0, 2.0 * x * v, v**2]) for x, v in zip(xi, w, strict=True)]
    layer = 2e10 * area * np.array([TIME, 1.0])
    weight = n * (n + friction * t)
    quartic = np.polyadd(np.polymul(*alone), np.polymul(
        layer, np.polyadd(weight[0] * alone[1], weight[1] * alone[0])))
    found = by_size(eigenvalues(model, replace(POINT, friction=friction)))
    assert found == pytest.approx(by_size(np.roots(quartic)), rel=1e-9)
    dry = by_size(eigenvalues(replace(model, contact_retardation_time=0.0),
                              replace(POINT, friction=friction)))
    assert np.abs(found - dry).max() > 1.0  # so the layer counts


def random_face(seed: int, size: int, count: int = 11) -> ContactFace:
    rng = np.random.default_rng(seed)
    normal, tangential, radial, spin = rng.standard_normal((4, size, count))
    return ContactFace(normal, tangential, radial, spin, rng.uniform(0.1, 0.14, count),
                       rng.uniform(1e-4, 3e-4, count))


@pytest.mark.parametrize('friction', [0.0, 0.45])
def test_energy_of_a_free_vibration(friction: float) -> None:
    """
    Kinetic and elastic energy change by what each point of contact takes and gives.

    No array of the model is used for it: the layer's dashpot takes c (n.v)^2, friction of its
    whole force gives -mu (k n.a + c n.v) (t.v), the components take 2 xi w v^2.
    """
    w, face, k = np.linspace(8e3, 1.4e4, 4), random_face(5, 4), POINT.contact_stiffness
    model = BrakeModel(
        angular_frequencies=w, damping_ratios=0.003, contact_retardation_time=TIME,
        contact_stiffness=operators.contact_stiffness([face]),
        friction_couple=operators.friction_couple([face]))
    point = replace(POINT, friction=friction)
    state = companion_at(model, point)
    start = np.concatenate([1e-6 * np.array([1.0, -0.4, 0.7, 0.2]), np.zeros(4)])

    def energy(a: FloatArray, v: FloatArray) -> float:
        strain = face.normal.T @ a
        return 0.5 * float(v @ v + (w * a) @ (w * a) + k * face.weight @ strain**2)

    def power(a: FloatArray, v: FloatArray) -> float:
        strain, rate = face.normal.T @ a, face.normal.T @ v
        force = k * (strain + TIME * rate)
        layer = -k * TIME * face.weight @ rate**2
        rubbing = -friction * face.weight @ (force * (face.tangential.T @ v))
        return float(layer + rubbing - 2.0 * 0.003 * w @ v**2)

    nodes, weights = np.polynomial.legendre.leggauss(40)
    end = 1e-3
    work = 0.5 * end * sum(weight * power(*np.split(expm(0.5 * end * (1.0 + node) * state) @ start,
                                                    2)) for node, weight in zip(
                                                        nodes, weights, strict=True))
    before, after = (energy(*np.split(expm(t * state) @ start, 2)) for t in (0.0, end))
    assert after - before == pytest.approx(work, rel=1e-9)
    assert abs(work) > 0.05 * before


def test_loss_factor_at_its_reference_frequency() -> None:
    """A mode on the layer alone: energy lost per radian over what the layer stores, at 2 kHz."""
    time = retardation_time(0.1, 2000.0)
    stiffness = (math.tau * 2000.0)**2 / POINT.contact_stiffness
    model = BrakeModel(angular_frequencies=[0.0], contact_stiffness=[[stiffness]],
                       contact_retardation_time=time)
    root = next(r for r in eigenvalues(model, POINT) if r.imag > 0.0)
    assert abs(root) == pytest.approx(math.tau * 2000.0, rel=1e-12)
    assert -2.0 * root.real / abs(root) == pytest.approx(0.1, rel=1e-12)


def test_it_follows_the_contact_stiffness(kang: BrakeModel) -> None:
    model = replace(kang, contact_retardation_time=TIME)
    there, here = (model.damping(replace(POINT, contact_stiffness=k)) for k in (3e10, 1e10))
    assert kang.contact_stiffness is not None
    assert kang.friction_couple is not None
    layer = TIME * 2e10 * (kang.contact_stiffness + 0.45 * kang.friction_couple)
    assert there - here == pytest.approx(layer, abs=1e-9 * np.abs(layer).max())


@pytest.mark.parametrize('scale', [0.0, 0.3, 2.5])
def test_a_damping_scale_is_a_model_of_that_damping(scale: float) -> None:
    rng = np.random.default_rng(1)
    held = rng.standard_normal((8, 8))
    model = random_model(8, 2, contact_retardation_time=TIME, support_damping=30.0 * held @ held.T)
    scaled = replace(model, damping_ratios=scale * model.damping_ratios,
                     contact_retardation_time=scale * TIME,
                     support_damping=scale * model.support_damping)
    point = replace(POINT, damping_scale=scale)
    assert model.damping(point) == pytest.approx(scaled.damping(POINT), rel=1e-12)
    assert np.array_equal(model.stiffness(point), scaled.stiffness(POINT))


def test_tracking_keeps_the_damping_scale(kang: BrakeModel) -> None:
    points = [replace(POINT, contact_stiffness=0.35e11, damping_scale=0.5, friction=mu)
              for mu in (0.1, 0.12)]
    *_, last = track(kang, points)
    roots = np.sort_complex(last.spectrum.eigenvalues)
    assert roots == pytest.approx(np.sort_complex(eigenvalues(kang, points[1])), abs=1e-6)


def test_fewer_modes_keep_the_layer() -> None:
    model = random_model(20, 3, contact_retardation_time=TIME)
    part = truncated(model, 0.5)
    keep = model.angular_frequencies <= part.angular_frequencies.max()
    expected = model.damping(POINT)[np.ix_(keep, keep)]
    assert part.damping(POINT) == pytest.approx(expected, rel=1e-12)


# ---------------------------------------------------------------- what stays, and files

def test_models_without_it_are_what_they_were(kang: BrakeModel, tmp_path: Path) -> None:
    assert model_hash(kang) == KANG
    kang.save(tmp_path / 'again.npz')
    old, new = (read_model(path, BrakeModel)[0] for path in ('kang2009', tmp_path / 'again.npz'))
    assert old == new
    assert new['schema'] == 1
    assert content_hash(*parts(tmp_path / 'again.npz')) == old['hash']


def test_a_model_with_it_is_another_one_that_earlier_versions_refuse(
        kang: BrakeModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    damped, path = replace(kang, contact_retardation_time=TIME), tmp_path / 'damped.npz'
    assert model_hash(damped) != KANG
    assert model_hash(damped) != model_hash(replace(kang, contact_retardation_time=2.0 * TIME))
    damped.save(path)
    assert model_hash(BrakeModel.load(path)) == model_hash(damped)
    header, _ = read_model(path, BrakeModel)
    assert (header['schema'], header['units']['contact_retardation_time']) == (3, 's')
    monkeypatch.setattr('squeal_core.model.model_file.KIND',
                        replace(KIND, schemas=range(1, 3)))
    with pytest.raises(ModelFileError, match='format 3.*update squeal_ros'):
        BrakeModel.load(path)


def test_the_shipped_damped_brake(kang: BrakeModel) -> None:
    """K09's arrays, a damping ratio of 0.5 %, a loss factor of 0.1 at 2 kHz; checks passed."""
    damped = BrakeModel.load('kang2009_damped')
    assert damped.damping_ratios == pytest.approx(0.005, rel=1e-15)
    assert damped.contact_retardation_time == pytest.approx(0.1 / (math.tau * 2e3), rel=1e-15)
    assert [c['name'] for c in damped.provenance['audit'] if not c['passed']] == []
    alike = replace(damped, damping_ratios=0.002, contact_retardation_time=0.0)
    ours, theirs = (np.sort_complex(eigenvalues(m, POINT)) for m in (alike, kang))
    assert np.abs(ours - theirs).max() < 1e-6 * np.abs(theirs).max()


# ---------------------------------------------------------------- bad values

@pytest.mark.parametrize(('value', 'words'), [
    (-1e-6, 'contact_retardation_time is -1e-06; give a number above 0'),
    (math.nan, 'contact_retardation_time is nan; give a finite number')])
def test_times_that_are_none(value: float, words: str) -> None:
    with pytest.raises(SquealError, match=words):
        BrakeModel(angular_frequencies=[1e3], contact_retardation_time=value)


@pytest.mark.parametrize(('value', 'words'), [
    (-0.5, 'damping_scale is -0.5; give zero or a positive number'),
    (math.inf, 'damping_scale is inf; give a finite number')])
def test_scales_that_are_none(value: float, words: str) -> None:
    with pytest.raises(OperatingPointError, match=words):
        replace(POINT, damping_scale=value)


@pytest.mark.parametrize(('arguments', 'words'), [
    ((-0.1, 2e3), 'loss_factor is -0.1'), ((0.1, 0.0), 'frequency_hz is 0; give a number above')])
def test_loss_factors_that_are_none(arguments: tuple[float, float], words: str) -> None:
    with pytest.raises(SquealError, match=words):
        retardation_time(*arguments)

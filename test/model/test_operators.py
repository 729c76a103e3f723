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

"""Properties that every operator must have, on random shapes and on the shipped model."""

from collections.abc import Callable
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.dimensions import Brake
from squeal_core.common.arrays import FloatArray
from squeal_core.model import operators
from squeal_core.model.matrix_names import OPERATORS
from squeal_core.model.operators import ContactFace
from squeal_core.modes.modal_basis import Quadrature, SampledShapes
from squeal_core.modes.planar_mesh import sector_quadrature
from squeal_core.stability.eigensolution import eigenvalues
from support.eigenvalues import companion_roots, distance

PAD1, DISC, PAD2 = slice(0, 3), slice(3, 8), slice(8, 10)
OF_FACES: dict[str, Callable[..., FloatArray]] = {
    'contact_stiffness': operators.contact_stiffness,
    'friction_couple': operators.friction_couple,
    'radial_dissipation': operators.radial_dissipation,
    'negative_slope': operators.negative_slope,
    'follower': operators.follower}
SYMMETRIC = ('contact_stiffness', 'radial_dissipation', 'negative_slope')

seeds = st.integers(0, 2**32 - 1)
# eigenvalues reach 2e5 rad/s; rounding eps * 2e5 with conditions up to 1e4 leaves 1e-7 1/s
ROUNDING = 1e-6


def random_shapes(rng: np.random.Generator, count: int, points: int = 7) -> SampledShapes:
    """Shapes of no particular physics at points of a plausible size."""
    r, t, w = rng.uniform(0.1, 0.2, points), rng.uniform(-1, 1, points), rng.uniform(0, 1, points)
    return SampledShapes(*rng.standard_normal((6, count, points)),
                         points=Quadrature(r, t, np.zeros(points), w))


def random_parts(seed: int) -> tuple[SampledShapes, SampledShapes, SampledShapes, SampledShapes]:
    """Pad 1, the disc's two faces, pad 2, all at the same (r, theta)."""
    rng = np.random.default_rng(seed)
    pad1, top, bottom, pad2 = (random_shapes(rng, n) for n in (3, 5, 5, 2))
    return pad1, top, replace(bottom, points=top.points), pad2


def random_faces(seed: int) -> tuple[ContactFace, ContactFace]:
    pad1, top, bottom, pad2 = random_parts(seed)
    return operators.top_face(pad1, top, 2), operators.bottom_face(pad2, bottom, 3)


def random_model(seed: int) -> BrakeModel:
    faces, rng = random_faces(seed), np.random.default_rng(seed + 1)
    arrays = {name: function(faces) for name, function in OF_FACES.items() if name != 'follower'}
    gyroscopic = np.zeros((10, 10))
    gyroscopic[DISC, DISC] = operators.gyroscopic([random_shapes(rng, 5)], 1.0)
    return BrakeModel(angular_frequencies=rng.uniform(0.0, 1e4, 10), damping_ratios=0.002,
                      gyroscopic=gyroscopic, **arrays)


def point(model: BrakeModel, **changes: float) -> OperatingPoint:
    """K09's point at 5 rad/s with a slope, or changes of it."""
    values = {'rotor_speed': 5.0, 'friction': 0.42, 'friction_slope': -0.05,
              'contact_pressure': 2000.0 / model.contact_area, 'contact_stiffness': 0.35e11}
    return OperatingPoint(**(values | changes))


def transformed(model: BrakeModel, t: FloatArray) -> BrakeModel:
    """Return the model in coordinates a = t b, with t orthogonal and blind to the frequencies."""
    return replace(model, **{name: t.T @ getattr(model, name) @ t for name in OPERATORS
                             if getattr(model, name) is not None})


# ---------------------------------------------------------------- random shapes

@given(seed=seeds)
def test_gyroscopic_is_skew(seed: int) -> None:
    g = operators.gyroscopic([random_shapes(np.random.default_rng(seed), 4)], 7000.0)
    assert np.array_equal(g, -g.T)
    assert np.abs(g).max() > 0.0


def test_gyroscopic_by_hand() -> None:
    """One point, two modes: P by pencil; K09 eq. (38)."""
    shapes = SampledShapes(*np.arange(1.0, 13.0).reshape(6, 2, 1),
                           points=Quadrature([0.1], [0.0], [0.0], [0.5]))
    # P[0, 1] = 1 (8 - 4) + 3 (10 + 2) + 5 * 12 and P[1, 0] = 2 (7 - 3) + 4 (9 + 1) + 6 * 11
    expected = 2.0 * 0.5 * np.array([[0.0, 100.0 - 114.0], [114.0 - 100.0, 0.0]])
    assert np.array_equal(operators.gyroscopic([shapes], 2.0), expected)


@given(seed=seeds)
@pytest.mark.parametrize('name', SYMMETRIC)
def test_symmetric_positive_semidefinite(name: str, seed: int) -> None:
    array = OF_FACES[name](random_faces(seed))
    size = np.abs(array).max()
    assert np.allclose(array, array.T, rtol=0, atol=1e-14 * size)  # one rounding a sum of 14
    assert np.linalg.eigvalsh(array).min() >= -1e-13 * size  # 10 x 10, backward stable


@given(seed=seeds)
def test_blocks_are_those_of_the_appendix(seed: int) -> None:
    """K09 eqs (A.3)-(A.6), block by block, with the minus signs that the scan lost."""
    parts = random_parts(seed)
    weight, radius = parts[1].points.weight, parts[1].points.radius
    r, t, n = ([getattr(part, name) for part in parts]
               for name in ('radial', 'tangential', 'normal'))
    expected = {'contact_stiffness': blocks(weight, n, n),
                'friction_couple': blocks(weight, t, n, bottom=-1.0),  # normals are opposite
                'radial_dissipation': blocks(weight / radius, r, r),
                'negative_slope': blocks(weight, t, t)}
    faces = random_faces(seed)
    for name, array in expected.items():
        # sums of 14 products, in another order
        atol = 1e-13 * np.abs(array).max()
        assert np.allclose(OF_FACES[name](faces), array, rtol=0, atol=atol), name


def blocks(weight: FloatArray, row: list[FloatArray], column: list[FloatArray],
           bottom: float = 1.0) -> FloatArray:
    """Shapes of pad 1, disc top, disc bottom, pad 2 against each other."""
    def over(i: int, j: int) -> FloatArray:
        return np.einsum('q,mq,nq->mn', weight, row[i], column[j])

    none = np.zeros((3, 2))
    return np.block([[over(0, 0), -over(0, 1), none],
                     [-over(1, 0), over(1, 1) + bottom * over(2, 2), -bottom * over(2, 3)],
                     [none.T, -bottom * over(3, 2), bottom * over(3, 3)]])


@given(seed=seeds)
def test_follower_is_that_of_the_appendix(seed: int) -> None:
    """K09 eq. (A.7): only the disc turns, so only its columns are there."""
    pad1, top, bottom, pad2 = random_parts(seed)
    over_r = top.points.weight / top.points.radius
    expected = np.zeros((10, 10))
    for face, pad, rows in ((top, pad1, PAD1), (bottom, pad2, PAD2)):
        turning = over_r * (face.radial_dtheta - face.tangential)
        expected[rows, DISC] = -pad.radial @ turning.T
        expected[DISC, DISC] += face.radial @ turning.T
    found = operators.follower(random_faces(seed))
    assert np.allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())  # rounding


def test_friction_needs_both_motions() -> None:
    """No row of B0 without tangential, no column without normal motion."""
    pad1, top, bottom, pad2 = random_parts(0)
    pad1.tangential[0] = pad1.normal[1] = 0.0
    b = operators.friction_couple((operators.top_face(pad1, top, 2),
                                   operators.bottom_face(pad2, bottom, 3)))
    assert not b[0].any()
    assert not b[:, 1].any()
    assert np.all(np.abs(b[1:3, DISC]) > 0)
    assert np.abs(b - b.T).max() > 0.1 * np.abs(b).max()  # unsymmetric: what flutter feeds on


@pytest.mark.parametrize('name', OF_FACES)
def test_nothing_to_integrate_is_an_error(name: str) -> None:
    with pytest.raises(ValueError, match='nothing to integrate'):
        OF_FACES[name]([])


@given(seed=seeds, speed=st.floats(-300, 300).filter(lambda x: abs(x) > 0.01),
       stiffness=st.floats(0, 1e9), pressure=st.floats(0, 1e7))
def test_random_brake_without_friction_does_not_grow(
        seed: int, speed: float, stiffness: float, pressure: float) -> None:
    model = random_model(seed)
    q = OperatingPoint(rotor_speed=speed, friction=0.0, contact_pressure=pressure,
                       contact_stiffness=stiffness)
    roots = eigenvalues(model, q)
    # energy only leaves; a double root at zero moves by sqrt(eps), the others by eps |D| + eps |K|
    assert roots.real.max() <= 1e-7 * np.abs(roots).max()


# ---------------------------------------------------------------- the shipped model

def test_shipped_arrays_have_their_symmetries(kang: BrakeModel) -> None:
    pads = np.r_[0:20, 72:92]
    assert np.array_equal(kang.gyroscopic, -kang.gyroscopic.T)
    assert not kang.gyroscopic[pads].any()
    for name in SYMMETRIC:
        array = getattr(kang, name)
        least = np.linalg.eigvalsh(array).min()
        assert least >= -1e-12 * np.abs(array).max(), name  # 92 x 92, backward stable
    for name in (*SYMMETRIC, 'friction_couple'):
        assert not getattr(kang, name)[:20, 72:].any()  # the pads meet through the disc only
        assert not getattr(kang, name)[72:, :20].any()


@settings(max_examples=25, deadline=None, derandomize=True)
@given(speed=st.floats(0.05, 200), backwards=st.booleans(), pressure=st.floats(0, 1e7),
       stiffness=st.floats(1e8, 1e12))
def test_no_friction_no_flutter(kang: BrakeModel, speed: float, backwards: bool,
                                pressure: float, stiffness: float) -> None:
    q = point(kang, rotor_speed=-speed if backwards else speed, friction=0.0, friction_slope=0.0,
              contact_pressure=pressure, contact_stiffness=stiffness)
    assert eigenvalues(kang, q).real.max() <= ROUNDING


def test_friction_does_make_flutter(kang: BrakeModel) -> None:
    assert eigenvalues(kang, point(kang, friction_slope=0.0)).real.max() > 1.0


@settings(max_examples=10, deadline=None, derandomize=True)
@given(speed=st.floats(0.5, 50), friction=st.floats(0.05, 0.8), slope=st.floats(-0.2, 0.0))
def test_brake_is_its_own_mirror_image(kang: BrakeModel, speed: float, friction: float,
                                       slope: float) -> None:
    there = point(kang, rotor_speed=speed, friction=friction, friction_slope=slope)
    back = point(kang, rotor_speed=-speed, friction=-friction, friction_slope=slope)
    # a merging of two roots may be near: sqrt(eps) of their coupling, ~1e3 1/s
    assert distance(eigenvalues(kang, there), eigenvalues(kang, back)) < 1e-4


def test_mirror_image_needs_both_signs(kang: BrakeModel) -> None:
    """Friction that pushes along the sliding is another brake."""
    there, wrong = point(kang), point(kang, friction=-0.42)
    assert distance(eigenvalues(kang, there), eigenvalues(kang, wrong)) > 1.0


def test_signs_of_vectors_do_not_matter(kang: BrakeModel) -> None:
    signs = np.diag(np.random.default_rng(1).choice([-1.0, 1.0], kang.size))
    found = eigenvalues(transformed(kang, signs), point(kang))
    assert distance(found, eigenvalues(kang, point(kang))) < ROUNDING


def test_orientation_of_doublets_does_not_matter(kang: BrakeModel) -> None:
    """Each pair of disc modes of one frequency may be any two of its plane."""
    rng, t, turned = np.random.default_rng(2), np.eye(kang.size), 0
    for i, (one, other) in enumerate(zip(kang.names, kang.names[1:], strict=False)):
        if one.endswith('c') and other == one[:-1] + 's':
            c, s = np.cos(angle := rng.uniform(0, 2 * np.pi)), np.sin(angle)
            t[i:i + 2, i:i + 2] = [[c, -s], [s, c]]
            turned += 1
    assert turned == 23
    found = eigenvalues(transformed(kang, t), point(kang))
    assert distance(found, eigenvalues(kang, point(kang))) < ROUNDING


@pytest.mark.parametrize('angle', [0.4, 2.0])
def test_place_of_pads_on_the_disc_does_not_matter(  # type: ignore[no-untyped-def]
        angle: float, kang: BrakeModel, brake: Brake, disc, pad) -> None:
    """Pads somewhere else on a disc of revolution: other arrays, same roots."""
    half, faces = 0.5 * brake.disc.rotor_thickness, []
    for face, z, bottom in ((operators.top_face, half, half),
                            (operators.bottom_face, -half, -half - brake.pad.thickness)):
        q = sector_quadrature(brake.contact, z)
        there = Quadrature(q.radius, q.angle + angle, q.height, q.weight)
        faces.append(face(replace(pad, offset=bottom).sample(q), disc.sample(there), 20))
    moved = replace(kang, **{name: OF_FACES[name](faces) for name in OF_FACES
                             if name != 'follower'})
    assert np.abs(moved.friction_couple - kang.friction_couple).max() > 1e-3
    assert distance(eigenvalues(moved, point(kang)), eigenvalues(kang, point(kang))) < ROUNDING


@pytest.mark.parametrize(('speed', 'slope'), [(5.0, 0.0), (5.0, -0.05), (20.0, 0.0)])
def test_taking_out_free_coordinates_changes_nothing(
        speed: float, slope: float, kang: BrakeModel) -> None:
    """Against all 2N rows of the state matrix, its zero roots blurred by rounding."""
    q = point(kang, rotor_speed=speed, friction_slope=slope)
    free = [kang.names[i] for i in np.flatnonzero(kang.free_coordinates)]
    assert free == [f'pad {pad} {motion}' for pad in (1, 2)
                    for motion in ('slide radial', 'slide tangential', 'spin')]
    roots, whole = eigenvalues(kang, q), companion_roots(kang, q)
    # a defective pair at zero moves by sqrt(eps |K|) of 1e10 1/s^2 at worst; others by rounding
    assert distance(roots, whole) < 1e-2
    large = lambda x: x[np.abs(x) > 1.0]  # noqa: E731
    assert distance(large(roots), large(whole)) < ROUNDING

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
CalculiX solves the hat disc of Kang (2009): modes and a brake's stability by two programs.

The mesh is one of ours, so that both programs solve the same matrices and agree to rounding; the
axisymmetric route knows nothing of it, so that it tells what the mesh is worth.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skfem
from squeal_core.assembly.build import build_model
from squeal_core.brake.dimensions import Brake, HatDisc, ModalResults
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.modes.fe.axisymmetric import HarmonicModes
from squeal_core.modes.fe.meshes import hat_disc_mesh
from squeal_core.modes.fe.solid import at_radius, solid_modes, SolidModes
from squeal_core.modes.modal_basis import Quadrature
from squeal_core.modes.nodal_modes import NodalModes
from squeal_core.modes.readers import read_modes
from squeal_core.stability.eigensolution import complex_modes
from support.calculix import deck, solved

MODES = 42  # two more than the brake keeps, so that a doublet that would be cut is seen
KEPT = 40
COARSE: dict[str, Any] = {'pad_elements': (4, 8, 1)}


@pytest.fixture(scope='module')
def ours(brake: Brake) -> NodalModes:
    """Our own modes on the mesh, graded towards the corners and the clamp."""
    mesh = hat_disc_mesh(brake.disc, around=24, element_size=0.02, corner_layers=1)
    return solid_modes(mesh, brake.disc.material, MODES, element=skfem.ElementHexS2(),
                       clamped=at_radius(brake.disc.clamp_radius)).nodal()


@pytest.fixture(scope='module')
def results(ours: NodalModes, brake: Brake, tmp_path_factory: pytest.TempPathFactory) -> Path:
    held = np.flatnonzero(at_radius(brake.disc.clamp_radius)(ours.coordinates.T))
    return solved(tmp_path_factory.mktemp('calculix'), deck(
        1e3 * ours.coordinates, ours.elements[0].nodes, brake.disc.material, MODES, held))


@pytest.fixture(scope='module')
def theirs(results: Path, brake: Brake) -> NodalModes:
    return read_modes(results, length_unit='mm', mass_unit='t',
                      density=brake.disc.material.density, mass_tolerance=1e-4)


def groups(frequencies: np.ndarray) -> Iterator[slice]:
    """Modes of the same frequency: a doublet is a plane, any two of its modes may stand for it."""
    cuts = np.flatnonzero(np.diff(frequencies) > 1e-5 * frequencies[:-1]) + 1
    ends = [0, *cuts.tolist(), frequencies.size]
    for start, stop in zip(ends, ends[1:], strict=False):
        if stop < frequencies.size:  # the last may lack its partner
            yield slice(start, stop)


def turn(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the matrix that takes the second shapes to the first, and what it cannot reach."""
    first, second = (shapes.reshape(len(shapes), -1).T for shapes in (one, other))
    matrix = np.linalg.lstsq(second, first, rcond=None)[0]
    return matrix, float(np.linalg.norm(first - second @ matrix) / np.linalg.norm(first))


def test_same_mesh_same_modes(theirs: NodalModes, ours: NodalModes) -> None:
    """
    Frequencies to the 7 digits of the file, shapes to its 6; doublets by the plane they span.

    A turn that is orthogonal says that the normalisation is the same, too.
    """
    np.testing.assert_allclose(theirs.coordinates, ours.coordinates, atol=5.1e-7)
    np.testing.assert_allclose(theirs.angular_frequencies, ours.angular_frequencies, rtol=1e-6)
    found = list(groups(ours.angular_frequencies))
    assert sum(part.stop - part.start == 2 for part in found) > 12
    for part in found:
        matrix, off = turn(theirs.shapes[part], ours.shapes[part])
        assert off < 1e-4
        np.testing.assert_allclose(matrix.T @ matrix, np.eye(len(matrix)), atol=1e-4)


def test_axisymmetric_modes(theirs: NodalModes, disc: HarmonicModes) -> None:
    """
    The lowest thirty are found, each doublet by its plane, frequencies from above.

    24 elements round the circle leave 2 % at five nodal diameters and 3 % at six.
    """
    section = np.array([*product((0.095, 0.12, 0.145), (-0.005, 0.0, 0.005)), (0.0857, 0.02),
                        (0.05, 0.031), (0.07, 0.031)])  # rotor, wall and top plate
    (radius, height), angle = np.repeat(section, 48, axis=0).T, np.arange(48) * np.pi / 24.0
    points = Quadrature(radius, np.tile(angle, len(section)), height, np.ones_like(radius))
    found, exact = (np.concatenate([s.radial, s.tangential, s.normal], axis=1) for s in (
        basis.sample(points) for basis in (SolidModes.from_nodal(theirs), disc)))
    seen = set()
    for part in groups(disc.angular_frequencies[:30]):
        own, off = min(((own, turn(found[own], exact[part])[1])
                        for own in groups(theirs.angular_frequencies)
                        if own.stop - own.start == part.stop - part.start),
                       key=lambda pair: pair[1])
        seen.add(own.start)
        above = theirs.angular_frequencies[own.start] / disc.angular_frequencies[part.start] - 1.0
        diameters = disc.section_modes[part.start].diameters
        assert off < 0.02, diameters  # MAC above 0.9996
        assert 0.0 < above < (0.02 if diameters < 5 else 0.04), diameters
    assert len(seen) == len([*groups(disc.angular_frequencies[:30])])


def unstable(model: BrakeModel) -> list[tuple[int, float, float]]:
    point = OperatingPoint(rotor_speed=5.0, friction=0.42, contact_stiffness=0.35e11,
                           contact_pressure=2000.0 / model.contact_area)
    return sorted((mode.index, mode.frequency_hz, mode.growth_rate)
                  for mode in complex_modes(model, point).unstable)


def test_same_modes_squeal(results: Path, brake: Brake) -> None:
    """The same pairs as of the axisymmetric disc; 1 % in frequency is 0.5 1/s in growth here."""
    assert isinstance(brake.disc, HatDisc)
    plain = build_model(replace(brake, disc_modes=KEPT), **COARSE)
    own = build_model(replace(brake, disc_modes=KEPT, disc=ModalResults(
        str(results), format=None, length_unit='mm', mass_unit='t', axis='z',
        origin=(0.0, 0.0, 0.0), modal_mass=None, density=brake.disc.material.density,
        thickness=brake.disc.rotor_thickness)), **COARSE)
    assert own.size == plain.size == 80
    expected = unstable(plain)
    assert [index for index, *_ in expected] == [13, 26]  # K09's 13/14 and 25/26
    assert unstable(own) == [(index, pytest.approx(f, rel=0.015), pytest.approx(g, abs=1.0))
                             for index, f, g in expected]
    assert all(check['passed'] for check in own.provenance['audit'])

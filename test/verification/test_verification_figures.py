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

"""Figures of `squeal verify`, and the parts of the brake whose shapes they show."""

from dataclasses import replace
from pathlib import Path

from matplotlib.figure import Figure
import numpy as np
from PIL import Image
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Brake
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.verification import Case, Parts, sweeps, Verification
from squeal_core.verification.parts import rebuild
from squeal_core.view.verification_figures import write_figures
from squeal_core.view.verification_shapes import ShapePlot

pytestmark = pytest.mark.timeout(900)  # for a machine that others use


@pytest.fixture(scope='module')
def parts(kang: BrakeModel, solved_once: None) -> Parts:
    return rebuild(kang)


@pytest.fixture(scope='module')
def drawn(kang: BrakeModel, parts: Parts) -> Verification:
    """Return what figures show, at every tenth point; `test_verify.py` looks at the claims."""
    return Verification(model=kang, rows=(), records=sweeps(kang, parts, 0, 10), parts=parts,
                        skipped=())


def test_parts_are_those_of_the_model(kang: BrakeModel, parts: Parts) -> None:
    point = Case(kang).at(20.0)
    old, new = (np.sort_complex(eigenvalues(m, point)) for m in (kang, parts.model))
    assert np.abs(old - new).max() < 1e-5 * np.abs(old).max()


def test_sums_over_nodes_are_too_large(parts: Parts, brake: Brake) -> None:
    """A0 by a quarter (theory.md); the area by 15/14 * 43/42 and rims counted in full."""
    exact, sums = parts.model.contact_stiffness, parts.by_sums.contact_stiffness
    assert np.linalg.norm(sums - exact) / np.linalg.norm(exact) == pytest.approx(0.26, abs=0.01)
    lift = parts.model.names.index('pad 1 lift')
    assert sums[lift, lift] / exact[lift, lift] == pytest.approx(15 / 14 * 43 / 42, abs=1e-4)


@pytest.mark.parametrize(('name', 'diameters'), [
    ('disc (0,0)c', 0), ('disc (1,1)c', 1), ('disc (2,2)c', 2), ('disc (3,1)c', 3),
    ('disc (4,1)c', 4)])
def test_drawn_shapes_have_their_diameters(name: str, diameters: int, parts: Parts) -> None:
    plot = ShapePlot.of(parts)
    vector = np.eye(parts.model.size, dtype=complex)[parts.model.names.index(name)]
    seen = plot.in_phase(1j * vector, 'normal')
    shown = [patch.motion(seen, 'normal').real for patch in (*plot.disc, *plot.pads)]
    assert max(part.max() for part in shown) == pytest.approx(1.0)
    assert np.abs(shown[2]).max() == np.abs(shown[3]).max() == 0.0
    rim = np.abs(np.fft.rfft(shown[1][-1, :-1]))
    assert rim.argmax() == diameters
    assert np.delete(rim, diameters).max() < 1e-3 * rim.max()


def test_drawn_pad_lifts_as_one(parts: Parts, brake: Brake) -> None:
    plot = ShapePlot.of(parts)
    vector = np.eye(parts.model.size, dtype=complex)[parts.model.names.index('pad 2 lift')]
    mass = brake.pad.material.density * brake.pad.thickness * brake.contact.area
    assert np.abs(plot.pads[1].motion(vector, 'normal')) == pytest.approx(mass**-0.5, rel=1e-3)
    assert np.abs(plot.pads[0].motion(vector, 'normal')).max() == 0.0


def test_torsion_stays_in_plane(parts: Parts) -> None:
    plot = ShapePlot.of(parts)
    vector = np.eye(parts.model.size, dtype=complex)[parts.model.names.index('disc (0,0)s')]
    normal, along = (np.abs(plot.disc[1].motion(vector, way)).max()
                     for way in ('normal', 'tangential'))
    assert normal < 1e-9 * along


def test_figures(drawn: Verification, tmp_path: Path) -> None:
    told: list[str] = []
    written = write_figures(drawn, tmp_path / 'new', progress=told.append)
    assert told == [path.name for path in written]
    assert {path.stem[7:] for path in written} == {
        '08', '09', '10', '11', '11_softer', '11_sums', '11a', '12', '12a', '13', '14', '15', '16'}
    for path in written:
        assert path.stat().st_size < 150_000
        with Image.open(path) as picture:
            pixels = np.asarray(picture.convert('L'), float)
        assert min(pixels.shape) > 300
        assert 0.02 < np.mean(pixels < 250.0) < 0.9  # something is drawn, not all is


def test_figures_without_shapes(drawn: Verification, tmp_path: Path,
                                monkeypatch: pytest.MonkeyPatch) -> None:
    """Each as above, so their pixels are left out."""
    monkeypatch.setattr(Figure, 'savefig', lambda self, target, **_: Image.new('P', (1, 1)).save(
        target, format='png'))
    written = write_figures(replace(drawn, parts=None), tmp_path)
    assert {path.stem[7:] for path in written} == {
        '09', '10', '11', '11_softer', '12', '13', '15'}

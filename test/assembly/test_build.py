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

"""Brakes of one's own: modal results for pads and disc, unequal pads, pad supports, the audit."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core.assembly.build import build_model
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import SquealError
from squeal_core.common.resources import config_folder
from squeal_core.model.brake_model import BrakeModel
from squeal_core.modes.fe.solid import SolidModes
from squeal_core.modes.nodal_modes import NodalModes
from squeal_core.stability.eigensolution import complex_modes
import yaml

pytestmark = pytest.mark.usefixtures('solved_once')

SHIPPED = yaml.safe_load((config_folder() / 'brakes' / 'kang2009.yaml').read_text())
COARSE: dict[str, Any] = {'disc_order': 3, 'pad_elements': (4, 8, 1), 'contact_points': 4}
PAD = SHIPPED['pads']


def write_table(path: Path, nodal: NodalModes) -> None:
    """Write the documented table, in mm as most packages have it."""
    head = ['node', 'x', 'y', 'z'] + ['ux', 'uy', 'uz'] * len(nodal.names)
    lines = [','.join(['frequency_hz', *map(repr, (nodal.angular_frequencies / 2.0
                                                   / np.pi).tolist())]), ','.join(head)]
    for i, where in enumerate(nodal.coordinates):
        values = [*(1e3 * where).tolist(), *nodal.shapes[:, i].ravel().tolist()]
        lines.append(','.join([str(i + 1), *map(repr, values)]))
    path.write_text('\n'.join(lines) + '\n')


def describe(folder: Path, **changes: Any) -> Path:
    path = folder / 'own.yaml'
    path.write_text(json.dumps({**SHIPPED, **changes}))  # JSON is YAML
    return path


def at(model: BrakeModel, speed: float) -> OperatingPoint:
    return OperatingPoint(rotor_speed=speed, friction=0.42, contact_stiffness=0.35e11,
                          contact_pressure=2000.0 / model.contact_area)


@pytest.fixture(scope='module')
def plain(tmp_path_factory: pytest.TempPathFactory) -> BrakeModel:
    """K09's brake by its dimensions, as coarse as the others here."""
    return build_model(read_brake(describe(tmp_path_factory.mktemp('plain'))), **COARSE)


def growing(model: BrakeModel, speed: float) -> list[tuple[float, float]]:
    return sorted((m.frequency_hz, m.growth_rate)
                  for m in complex_modes(model, at(model, speed)).unstable)


@pytest.mark.parametrize('with_elements', [True, False])
def test_pad_from_a_table_or_elements(with_elements: bool, kang: BrakeModel, pad: SolidModes,
                                      tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same pad, once through layers of nodes alone and once through its elements."""
    nodal = SolidModes(pad.basis, pad.angular_frequencies, pad.shapes, pad.names, pad.density,
                       offset=0.008).nodal()
    write_table(tmp_path / 'pad.csv', nodal)
    if with_elements:
        import squeal_core.modes.readers
        monkeypatch.setattr(squeal_core.modes.readers, 'read_modes', lambda *_, **__: nodal)
    top = {'modes_from': {'file': 'pad.csv', 'length_unit': 'mm', 'modal_mass': 1.0},
           'thickness_mm': 11.0, 'density_kg_m3': 7820.0}
    brake = read_brake(describe(tmp_path, pads={'top': top, 'bottom': PAD}))
    model = build_model(brake, **COARSE)
    assert model.size == 92
    # against the shipped model; the coarse bottom pad moves growth rates by a few 1/s
    assert growing(model, 20.0) == [(pytest.approx(f, rel=5e-3), pytest.approx(g, abs=4.0))
                                    for f, g in growing(kang, 20.0)]
    macs = [c for c in model.provenance['audit'] if c['name'].startswith('interpolation')]
    assert [c['name'] for c in macs] == ['interpolation of pad 1']
    assert macs[0]['value'] > 0.99


def test_unequal_pads(plain: BrakeModel, tmp_path: Path) -> None:
    thin = {**PAD, 'thickness_mm': 9.0}
    model = build_model(read_brake(describe(tmp_path, pads={'top': PAD, 'bottom': thin})),
                        **COARSE)
    first, second = (model.angular_frequencies[[n.startswith(p) for n in model.names]]
                     for p in ('pad 1', 'pad 2'))
    assert first == pytest.approx(plain.angular_frequencies[:20])
    # bending goes with thickness: the first flexible mode falls by nearly 9/11
    assert second[6] / first[6] == pytest.approx(9.0 / 11.0, rel=0.03)


def test_support_holds_the_pads(plain: BrakeModel, tmp_path: Path) -> None:
    """Sliding as a whole meets k A / m, and no coordinate is free any more."""
    stiffness = 2e9
    support = {'tangential_stiffness_n_m3': stiffness, 'radial_stiffness_n_m3': stiffness,
               'axial_stiffness_n_m3': stiffness, 'radial_damping_ns_m3': 1e3}
    model = build_model(read_brake(describe(tmp_path, pads={**PAD, 'support': support})),
                        **COARSE)
    assert not model.free_coordinates.any()
    assert np.count_nonzero(plain.free_coordinates) == 6
    assert model.support_stiffness is not None
    assert model.support_damping is not None
    mass = 7820.0 * 0.011 * model.contact_area
    rigid = [model.names.index(f'pad 1 {name}') for name in (
        'slide radial', 'slide tangential', 'lift')]
    # each point of a sliding pad moves by m^-1/2; the mesh's volume is right to 1e-5
    assert model.support_stiffness[rigid, rigid] == pytest.approx(
        [stiffness * model.contact_area / mass] * 3, rel=1e-4)
    kinds = {m.kind for m in complex_modes(model, at(model, 5.0)).modes}
    assert 'rigid' not in kinds
    model.save(tmp_path / 'held.npz')
    loaded = BrakeModel.load(tmp_path / 'held.npz')
    assert np.array_equal(loaded.support_stiffness, model.support_stiffness)


def test_a_support_is_at_the_backs_of_the_pads(tmp_path: Path) -> None:
    """Where a pad that rolls moves along the disc as much as at its lining, the other way."""
    stiffness = 2e9
    model = build_model(read_brake(describe(tmp_path, pads={**PAD, 'support': {
        'tangential_stiffness_n_m3': stiffness}})), **COARSE)
    at_lining, at_back = model.negative_slope, model.support_stiffness
    assert at_lining is not None
    assert at_back is not None
    for pad in ('pad 1', 'pad 2'):
        slide, roll = (model.names.index(f'{pad} {name}') for name in (
            'slide tangential', 'roll'))
        size = stiffness * at_lining[slide, slide]
        for here, sign in ((slide, 1.0), (roll, -1.0)):
            assert at_back[slide, here] == pytest.approx(
                sign * stiffness * at_lining[slide, here], abs=1e-4 * size)
        assert abs(at_back[slide, roll]) > 0.01 * size


def test_damping_where_it_belongs(plain: BrakeModel, tmp_path: Path) -> None:
    """By component and frequency, in the contact layer, in a shim behind each pad."""
    pads = {'frequency_hz': [4000, 10000], 'damping_ratio': [0.002, 0.008]}
    changes = {
        'damping': {'disc': 0.001, 'pads': pads},
        'contact': {**SHIPPED['contact'], 'loss_factor': 0.5, 'reference_frequency_hz': 2000},
        'pads': {**PAD, 'shim': {'axial_stiffness_n_m3': 1e12, 'loss_factor': 0.3,
                                 'reference_frequency_hz': 2000}}}
    described = {key: value for key, value in SHIPPED.items() if key != 'damping_ratio'}
    (tmp_path / 'own.yaml').write_text(json.dumps({**described, **changes}))
    model = build_model(read_brake(tmp_path / 'own.yaml'), **COARSE)
    hertz = model.angular_frequencies / (2.0 * np.pi)
    assert model.angular_frequencies == pytest.approx(plain.angular_frequencies, abs=1e-3)
    of_pads = np.array([name.startswith('pad') for name in model.names])
    expected = np.where(of_pads, np.clip(0.002 + (hertz - 4000) * 1e-6, 0.002, 0.008), 0.001)
    assert model.damping_ratios == pytest.approx(expected, rel=1e-9)
    assert plain.contact_damping is None
    assert model.contact_damping == pytest.approx(
        0.5 / (2.0 * np.pi * 2000) * plain.contact_stiffness, rel=1e-6, abs=1e-12)
    # quadrature of zeros leaves 1e-16 of the largest entry
    assert model.support_damping == pytest.approx(
        0.3 / (2.0 * np.pi * 2000) * np.asarray(model.support_stiffness), rel=1e-9, abs=1e-6)
    failed = [c for c in model.provenance['audit'] if c['name'].startswith('contact loss')]
    assert [(c['value'], c['passed']) for c in failed] == [(pytest.approx(4.0), False)]


def test_audit_is_kept_and_passes(plain: BrakeModel, kang: BrakeModel) -> None:
    for model in (plain, kang):
        checks = model.provenance['audit']
        assert {c['name'].split(' ')[0] for c in checks} == {
            'symmetry', 'definiteness', 'doublets', 'contact', 'basis', 'backward'}
        assert all(c['passed'] for c in checks), [c for c in checks if not c['passed']]


def test_audit_warns_of_a_coarse_contact(tmp_path: Path) -> None:
    model = build_model(read_brake(describe(tmp_path)), disc_order=3, pad_elements=(2, 4, 1),
                        contact_points=1)
    failed = [c['name'] for c in model.provenance['audit'] if not c['passed']]
    assert 'contact quadrature' in failed


@pytest.mark.parametrize(('change', 'words'), [
    ({'length_unit': 'm'}, 'length_unit'), ({'length_unit': 'ell'}, 'length_unit'),
    ({'file': 'nobody.csv'}, 'nobody.csv'), ({'format': 'word'}, 'format'),
    ({'origin_m': [0.0, 0.0]}, 'origin_m'), ({'colour': 'red'}, 'colour')])
def test_bad_modal_results_are_refused(change: dict[str, Any], words: str, pad: SolidModes,
                                       tmp_path: Path) -> None:
    write_table(tmp_path / 'pad.csv', pad.nodal())
    source = {'file': 'pad.csv', 'length_unit': 'mm', 'modal_mass': 1.0, **change}
    pads = {'modes_from': source, 'thickness_mm': 11.0, 'density_kg_m3': 7820.0}
    with pytest.raises(SquealError, match=words) as error:
        build_model(read_brake(describe(tmp_path, pads={'top': pads, 'bottom': PAD})), **COARSE)
    assert '\n' not in str(error.value)


def test_pad_in_the_wrong_place_is_said(pad: SolidModes, tmp_path: Path) -> None:
    """Its face at z = 0 instead of at the rotor's top face."""
    write_table(tmp_path / 'pad.csv', pad.nodal())
    pads = {'modes_from': {'file': 'pad.csv', 'length_unit': 'mm', 'modal_mass': 1.0},
            'thickness_mm': 11.0, 'density_kg_m3': 7820.0}
    brake = read_brake(describe(tmp_path, pads={'top': PAD, 'bottom': pads}))
    with pytest.raises(SquealError, match=r'z|layer|mesh'):
        build_model(brake, **COARSE)

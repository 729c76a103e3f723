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

"""Files of pads and discs that are not what a brake says they are: one line, and no model."""

from collections.abc import Callable
import json
from pathlib import Path
import re
from typing import Any

import numpy as np
import pytest
from squeal_core.brake.dimensions import Brake
from squeal_core.common.resources import config_folder
from squeal_core.modes.fe.solid import pad_modes, SolidModes
from squeal_core.modes.readers.raw import RawModes
from squeal_ros.cli.main import main
from support import reader_samples as samples
import yaml

SHIPPED = yaml.safe_load((config_folder() / 'brakes' / 'kang2009.yaml').read_text())
FORMATS = ('unv', 'nastran_h5', 'table', 'ansys', 'vtu')
UNSTATED = ('ansys', 'vtu')  # formats with no place for modal masses
MODES = 10


@pytest.fixture(scope='module')
def raw(brake: Brake) -> RawModes:
    """Return a coarse pad where the top one is, in mm and t."""
    solved = pad_modes(brake.pad, brake.contact, MODES, elements=(3, 6, 1))
    modes = SolidModes(solved.basis, solved.angular_frequencies, solved.shapes, solved.names,
                       solved.density, offset=0.008).nodal()
    return RawModes(1e3 * modes.coordinates, modes.angular_frequencies / (2 * np.pi),
                    modes.shapes * np.sqrt(1e3), modes.elements)


@pytest.fixture
def written(raw: RawModes, tmp_path: Path,
            monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """Write the pad in a format, its shapes scaled."""
    def write(name: str, scale: Any = 1.0) -> Path:
        shapes = raw.shapes * scale
        hexahedra = raw.elements[0].nodes[:, :20]
        monkeypatch.setattr(samples, 'IDS', 10 + 3 * np.arange(len(raw.coordinates)))
        monkeypatch.setattr(samples, 'HEX', hexahedra)
        monkeypatch.setattr(samples, 'HERTZ', list(map(float, raw.frequencies_hz)))
        monkeypatch.setattr(samples, 'RAW', RawModes(
            raw.coordinates, raw.frequencies_hz, shapes, raw.elements))
        return samples.write_sample(name, tmp_path)
    return write


def refusal(path: Path, told: dict[str, Any], capfd: pytest.CaptureFixture[str], *,
            side: str = 'top', modes: int = MODES) -> str:
    """Return what `squeal build` says of a brake with this pad: one line and no model."""
    source = {'file': str(path), 'length_unit': 'mm', 'mass_unit': 't', **told}
    if path.stem in UNSTATED:
        source.setdefault('modal_mass', 1.0)
    pad = {'modes_from': source, 'thickness_mm': 11.0, 'density_kg_m3': 7820.0}
    pads = {'top': SHIPPED['pads'], 'bottom': SHIPPED['pads'], side: pad}
    if side == 'bottom':  # at the top it is right, and need not be solved
        pads['top'] = pad
    brake = path.with_name('brake.yaml')
    brake.write_text(json.dumps({**SHIPPED, 'pads': pads, 'modes': {'disc': 8, 'pad': modes}}))
    model = path.with_name('model.npz')
    there = sorted(path.parent.iterdir())
    assert main(['build', str(brake), '-o', str(model)]) == 2
    said = capfd.readouterr().err.strip()
    assert '\n' not in said
    assert str(path) in said
    assert '; ' in said
    assert sorted(path.parent.iterdir()) == there
    return said.partition(f'{path}: ')[2]


@pytest.mark.parametrize('name', FORMATS)
def test_confused_units_and_places(name: str, written: Callable[..., Path],
                                   capfd: pytest.CaptureFixture[str]) -> None:
    path = written(name)
    units = 'in units of 0.001 m, but' if name == 'unv' else 'spans 146 m with length_unit'
    assert units in refusal(path, {'length_unit': 'm'}, capfd)
    weighs = 'times the modal mass stated|kg by density and elements|kg to a cubic metre'
    for unit in ('kg', 'g', 'lb', 'slinch'):
        assert re.search(weighs, refusal(path, {'mass_unit': unit}, capfd))
    assert 'has its contact face at z = 0.019 m, the brake at -0.008 m; check axis, origin' in (
        refusal(path, {}, capfd, side='bottom'))
    lower = {'origin_m': [0.0, 0.0, 0.003]}
    assert 'has its contact face at z = 0.005 m, the brake at 0.008 m' in refusal(
        path, lower, capfd)
    assert re.search('its contact face at|none at those of the contact',
                     refusal(path, {'axis': 'x'}, capfd))
    assert f'has {MODES} modes, but the brake is to keep 12; export more modes' in refusal(
        path, {}, capfd, modes=12)


@pytest.mark.parametrize('name', FORMATS)
def test_shapes_of_another_normalisation(name: str, raw: RawModes, written: Callable[..., Path],
                                         capfd: pytest.CaptureFixture[str]) -> None:
    """The largest displacement one, as many packages have it, with modal masses of one."""
    largest = np.abs(raw.shapes).max(axis=(1, 2), keepdims=True)
    path = written(name, 1.0 / largest)
    weighs = 'times the modal mass stated|kg by density and elements|kg to a cubic metre'
    for told in ({}, {'modal_mass': 1.0, 'mass_unit': 'kg'}):
        assert re.search(weighs, refusal(path, told, capfd))

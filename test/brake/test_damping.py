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

"""Damping in brake descriptions: by component and frequency, loss factors, shims."""

from copy import deepcopy
import math
from typing import Any

import numpy as np
import pytest
from squeal_core.brake.brake_yaml import parse_brake, read_brake
from squeal_core.brake.damping import ComponentDamping, DampingTable
from squeal_core.brake.dimensions import Brake, Support
from squeal_core.common.errors import BrakeDescriptionError, SquealError
from squeal_core.common.resources import config_folder
import yaml

CONTENT = yaml.safe_load((config_folder() / 'brakes' / 'kang2009.yaml').read_text())
TABLE = {'frequency_khz': [1, 3, 9], 'damping_ratio': [0.002, 0.004, 0.01], 'source': 'hammer'}
SHIM = {'axial_stiffness_n_m3': 2e12, 'shear_stiffness_n_m3': 5e11, 'loss_factor': 0.3,
        'reference_frequency_hz': 2000.0}


def described(damping: Any = None, contact: Any = None, **pads: Any) -> dict[str, Any]:
    """Return the shipped description with damping by component, more of the contact or pads."""
    content = deepcopy(CONTENT)
    if damping is not None:
        del content['damping_ratio']
        content['damping'] = damping
    content['contact'].update(contact or {})
    content['pads'].update(pads)
    return content


def refusal(content: dict[str, Any]) -> str:
    with pytest.raises(BrakeDescriptionError) as caught:
        parse_brake(content, warn=lambda _: None)
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)


def warnings_of(content: dict[str, Any]) -> list[str]:
    said: list[str] = []
    parse_brake(content, warn=said.append)
    return said


def test_the_damped_brake_is_the_shipped_one_but_for_damping(brake: Brake) -> None:
    found = read_brake(config_folder() / 'brakes' / 'kang2009_damped.yaml')
    assert (found.disc, found.pads, found.caliper) == (brake.disc, brake.pads, brake.caliper)
    assert (brake.damping_ratio, brake.contact.retardation_time) == (0.002, 0.0)
    assert found.damping_ratio == 0.005
    assert found.contact.retardation_time == pytest.approx(0.1 / (2.0 * math.pi * 2000.0))
    for key in ('contact.loss_factor', 'contact.reference_frequency_hz', 'damping_ratio'):
        assert found.sources[key].startswith('assumed')


def test_damping_by_component_and_frequency() -> None:
    damping = parse_brake(described({'disc': {'value': 0.001, 'source': 'hammer'}, 'pads': {
        'top': TABLE, 'bottom': 0.02}})).damping_ratio
    assert isinstance(damping, ComponentDamping)
    at = 2.0 * math.pi * np.array([0.0, 1e3, 2e3, 6e3, 9e3, 5e4])
    assert damping.pads[0](at) == pytest.approx([0.002, 0.002, 0.003, 0.007, 0.01, 0.01])
    assert damping.pads[1](at) == pytest.approx([0.02] * 6)
    assert damping.disc(at) == pytest.approx([0.001] * 6)
    both = parse_brake(described({'disc': TABLE, 'pads': 0.01}))
    assert isinstance(both.damping_ratio, ComponentDamping)
    assert both.damping_ratio.pads[0] == both.damping_ratio.pads[1]
    assert both.sources['damping.disc'] == 'hammer'


@pytest.mark.parametrize('shared', [True, False])
def test_a_shim_is_a_layer_on_a_rigid_backing(shared: bool) -> None:
    content = described(shim=SHIM)
    if not shared:
        content['pads'] = {'top': content['pads'], 'bottom': deepcopy(CONTENT['pads'])}
    top, bottom = parse_brake(content).supports
    time = 0.3 / (2.0 * math.pi * 2000.0)
    assert top == Support(radial_stiffness=5e11, tangential_stiffness=5e11, axial_stiffness=2e12,
                          radial_damping=5e11 * time, tangential_damping=5e11 * time,
                          axial_damping=2e12 * time)
    assert bottom == (top if shared else Support())


def test_shim_and_abutment_in_different_directions() -> None:
    shim = {'axial_stiffness_n_m3': 2e12}
    support = {'tangential_stiffness_n_m3': 1e10, 'tangential_damping_ns_m3': 1e3}
    (found, _) = parse_brake(described(shim=shim, support=support)).supports
    assert found == Support(axial_stiffness=2e12, tangential_stiffness=1e10,
                            tangential_damping=1e3)


@pytest.mark.parametrize(('change', 'parts'), [
    ({'loss_factor': 0.1}, ('contact.reference_frequency_hz', 'is missing', 'loss_factor is 0.1',
                            'add the frequency')),
    ({'reference_frequency_hz': 2e3}, ('contact.reference_frequency_hz', '2000 Hz', 'without a',
                                       'add loss_factor')),
    ({'loss_factor': -0.1, 'reference_frequency_hz': 2e3},
     ('contact.loss_factor', 'is -0.1', 'give 0 to 10')),
    ({'loss_factor': 0.1, 'reference_frequency_hz': 0},
     ('contact.reference_frequency_hz', 'is 0.0 Hz', 'give 0 to 1e+06 Hz, both ends excluded')),
    ({'loss_factor': 'much', 'reference_frequency_hz': 2e3},
     ('contact.loss_factor', "'much'", 'write a number')),
    ({'loss_factor': 0.1, 'reference_frequency_hz': math.nan},
     ('reference_frequency_hz', 'is nan', 'write a finite number')),
    ({'loss_factor': 0.1, 'reference_frequency': 2e3},
     ('contact.reference_frequency', 'wrong unit suffix', 'use reference_frequency_hz'))])
def test_wrong_loss_factors(change: dict[str, Any], parts: tuple[str, ...]) -> None:
    text = refusal(described(contact=change))
    assert [part for part in parts if part not in text] == []


@pytest.mark.parametrize(('damping', 'parts'), [
    ({'disc': 0.01}, ('damping.pads', 'is missing', 'add pads')),
    ({'disc': 0.01, 'pads': 0.01, 'hat': 0.01}, ('damping.hat', 'unknown key', 'disc, pads')),
    ({'disc': 0.6, 'pads': 0.01}, ('damping.disc', 'is 0.6', 'give 0 to 0.5')),
    ({'disc': 0.01, 'pads': {'top': 0.01}}, ('damping.pads.bottom', 'is missing')),
    ({'disc': 0.01, 'pads': {**TABLE, 'damping_ratio': [0.1]}},
     ('damping.pads', '3 frequencies and 1 damping ratios', 'give as many')),
    ({'disc': 0.01, 'pads': {**TABLE, 'frequency_khz': [1, 9, 3]}},
     ('damping.pads', 'do not rise', 'sort')),
    ({'disc': 0.01, 'pads': {**TABLE, 'damping_ratio': [0.1, -0.1, 0.1]}},
     ('damping.pads.damping_ratio[1]', 'is -0.1', 'give 0 to 0.5')),
    ({'disc': 0.01, 'pads': {**TABLE, 'frequency_hz': [1, 2, 3]}}, ('says again', 'keep one')),
    ({'disc': 0.01, 'pads': [0.1]}, ('damping.pads', 'is [0.1]', 'write a number')),
    (0.01, ('brake.damping', 'is 0.01', 'write a mapping'))])
def test_wrong_damping_by_component(damping: Any, parts: tuple[str, ...]) -> None:
    text = refusal(described(damping))
    assert [part for part in parts if part not in text] == []


def test_damping_is_said_once() -> None:
    content = described({'disc': 0.01, 'pads': 0.01})
    content['damping_ratio'] = 0.002
    assert 'brake.damping: says again what damping_ratio says; keep one' in refusal(content)
    del content['damping'], content['damping_ratio']
    assert 'damping_ratio: is missing; add damping_ratio' in refusal(content)


@pytest.mark.parametrize(('shim', 'parts'), [
    ({'loss_factor': 0.3}, ('shim', 'reference_frequency_hz', 'is missing')),
    ({'shear_stiffness_n_m3': 1e11}, ('shim.axial_stiffness_n_m3', 'is missing')),
    ({**SHIM, 'axial_stiffness_n_m3': -1}, ('shim.axial_stiffness_n_m3', 'is -1', 'N/m^3')),
    ({**SHIM, 'thickness_mm': 1}, ('shim.thickness_mm', 'unknown key'))])
def test_wrong_shims(shim: dict[str, Any], parts: tuple[str, ...]) -> None:
    text = refusal(described(shim=shim))
    assert [part for part in parts if part not in text] == []


def test_a_direction_has_one_support() -> None:
    text = refusal(described(shim=SHIM, support={'tangential_stiffness_n_m3': 1e10}))
    assert 'brake.pads.shim: holds the pad in the tangential direction' in text
    assert 'leave the tangential keys of support out' in text


def test_unusual_numbers_are_doubted() -> None:
    (text,) = warnings_of(described(contact={'loss_factor': 0.1, 'reference_frequency_hz': 2.0}))
    assert 'contact.reference_frequency_hz: is 2.0 Hz; usual is 50 to 20000 Hz' in text
    assert '2 kHz would be 2000 Hz' in text
    (text,) = warnings_of(described(contact={'loss_factor': 10, 'reference_frequency_hz': 2e3}))
    assert '10 % would be 0.1' in text
    assert warnings_of(described(
        {'disc': 0.002, 'pads': TABLE}, {'loss_factor': 0.1, 'reference_frequency_khz': 2},
        shim=SHIM)) == []


@pytest.mark.parametrize(('frequency', 'ratio', 'words'), [
    ((1e3,), (0.1, 0.2), 'give as many'), ((2e3, 1e3), (0.1, 0.2), 'do not rise'),
    ((0.0,), (0.1,), r'frequency\[0\] is 0'), ((1e3,), (-0.1,), r'ratio\[0\] is -0.1')])
def test_tables_that_are_none(frequency: Any, ratio: Any, words: str) -> None:
    with pytest.raises(SquealError, match=f'damping table: .*{words}'):
        DampingTable(frequency, ratio)

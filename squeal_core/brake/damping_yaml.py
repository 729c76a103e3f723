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

"""Damping in brake descriptions: by component and frequency, loss factors, supports, shims."""

from collections.abc import Mapping

from squeal_core.brake.damping import ComponentDamping, DampingTable, retardation_time
from squeal_core.brake.dimensions import Support
from squeal_core.brake.quantity_ranges import (
    DAMPING_FREQUENCY,
    DAMPING_RATIO,
    LOSS_FACTOR,
    REFERENCE_FREQUENCY,
    SHIM,
    SUPPORT,
)
from squeal_core.common.errors import BrakeDescriptionError, SquealError
from squeal_core.common.quantities import QuantityReader

_DIRECTIONS = ('radial', 'tangential', 'axial')


def read_damping(root: QuantityReader) -> float | ComponentDamping:
    """Return the one `damping_ratio` of all components, or the entries of `damping` for each."""
    section = root.section('damping', required=False)
    if section is None:
        return root.number('damping_ratio', DAMPING_RATIO)
    if 'damping_ratio' in root.content:
        raise BrakeDescriptionError(root.path('damping'), 'says again what damping_ratio says',
                                    'keep one of them')
    disc = _table(section, 'disc')
    given = section.content.get('pads')
    if isinstance(given, Mapping) and {'top', 'bottom'} & set(given):
        both = section.required_section('pads')
        pads = _table(both, 'top'), _table(both, 'bottom')
        both.finish()
    else:
        pads = (_table(section, 'pads'),) * 2
    section.finish()
    return ComponentDamping(disc, pads)


def _table(section: QuantityReader, name: str) -> DampingTable:
    """Read a table over frequency, or a number for all frequencies."""
    if not isinstance(content := section.content.get(name), Mapping) or 'value' in content:
        return DampingTable((1.0,), (section.number(name, DAMPING_RATIO),))
    table = section.required_section(name)
    table.sources[table.where] = table.text('source', default='not given')
    frequency = table.quantities('frequency', DAMPING_FREQUENCY)
    ratio = table.quantities('damping_ratio', DAMPING_RATIO)
    table.finish()
    try:
        return DampingTable(frequency, ratio)
    except SquealError as error:
        raise BrakeDescriptionError(table.where, str(error), 'mend the lists') from None


def read_retardation_time(layer: QuantityReader) -> float:
    """Return c / k [s] of a layer, from its loss factor and the frequency that this holds at."""
    loss_factor = layer.number('loss_factor', LOSS_FACTOR)
    frequency = layer.number('reference_frequency', REFERENCE_FREQUENCY)
    if 'loss_factor' not in layer.content and frequency:
        raise BrakeDescriptionError(
            layer.path('reference_frequency_hz'), f'is {frequency:g} Hz without a loss factor',
            'add loss_factor, which it is the frequency of, or remove it')
    if loss_factor and not frequency:
        raise BrakeDescriptionError(
            layer.path('reference_frequency_hz'), f'is missing, loss_factor is {loss_factor:g}',
            'add the frequency at which the loss factor holds')
    return retardation_time(loss_factor, frequency) if loss_factor else 0.0


def read_support(pad: QuantityReader) -> Support:
    """Return the support of a pad at its back face: its `support` and its `shim`."""
    section = pad.section('support', required=False)
    held = {f'{way}_{kind}': 0.0 for way in _DIRECTIONS for kind in SUPPORT}
    if section is not None:
        held = {name: section.number(name, SUPPORT[name.partition('_')[2]]) for name in held}
        section.finish()
    shim = pad.section('shim', required=False)
    if shim is not None:
        _add_shim(held, shim)
    return Support(**held)


def _add_shim(held: dict[str, float], shim: QuantityReader) -> None:
    """Add a viscoelastic layer on a rigid backing to a support, along its stiff directions."""
    time = read_retardation_time(shim)
    axial, shear = (shim.number(name, quantity) for name, quantity in SHIM.items())
    shim.finish()
    for way, stiffness in zip(_DIRECTIONS, (shear, shear, axial), strict=True):
        if stiffness == 0.0:
            continue
        if held[f'{way}_stiffness'] or held[f'{way}_damping']:
            raise BrakeDescriptionError(
                shim.where, f'holds the pad in the {way} direction, as its support does',
                f'keep one: leave the {way} keys of support out, or give there both in series')
        held[f'{way}_stiffness'], held[f'{way}_damping'] = stiffness, time * stiffness

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

"""The directive `brake-keys`: keys of a brake description, from where its reader has them."""

from collections.abc import Iterable, Mapping
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from squeal_core.brake import quantity_ranges as ranges
from squeal_core.common.quantities import Quantity
from squeal_core.common.ranges import span, SYMBOLS, UNITS

_WAYS = ('radial', 'tangential', 'axial')
_LAYER = {'loss_factor': ranges.LOSS_FACTOR, 'reference_frequency': ranges.REFERENCE_FREQUENCY}
SECTIONS: dict[str, Mapping[str, Quantity]] = {
    'disc': ranges.DISC,
    'pads': ranges.PAD,
    'pads.support': {f'{way}_{kind}': quantity for kind, quantity in ranges.SUPPORT.items()
                     for way in _WAYS},
    'pads.shim': {**ranges.SHIM, **_LAYER},
    'contact': {**ranges.CONTACT, **_LAYER},
    'caliper': ranges.CALIPER,
    'friction': ranges.FRICTION,
    'damping': {'damping_ratio': ranges.DAMPING_RATIO},
}
MEANINGS = {
    'young_modulus': 'of the whole part', 'density': 'likewise', 'poisson_ratio': 'likewise',
    'rotor_thickness': 'between the contact faces', 'rotor_outer_radius': 'of the friction ring',
    'hat_wall_outer_radius': 'where the friction ring begins',
    'hat_wall_thickness': 'of the cylinder between ring and top plate',
    'hat_height': "top of the hat above the rotor's top face",
    'top_plate_thickness': 'of the flange at the hub',
    'clamp_radius': 'the flange is held within it',
    'thickness': 'of the back plate', 'inner_radius': 'of the patch', 'outer_radius': 'likewise',
    'angle': 'that the patch takes of the ring',
    'stiffness': 'of the lining, per area', 'axial_stiffness': 'at the back, per area',
    'radial_stiffness': 'likewise', 'tangential_stiffness': 'likewise: the abutment',
    'axial_damping': 'likewise', 'radial_damping': 'likewise', 'tangential_damping': 'likewise',
    'shear_stiffness': 'of the layer in its plane, per area',
    'loss_factor': 'of the layer', 'reference_frequency': 'at which the loss factor holds',
    'piston_diameter': 'of one piston as large as those of one side together',
    'efficiency': 'share of the piston force that arrives',
    'static': 'at rest', 'kinetic': 'at high sliding speed', 'decay': 'from one to the other',
    'damping_ratio': 'of all components, at the top level of the file',
}


class BrakeKeys(SphinxDirective):
    """The numbers of a section of a brake description."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        return self.parse_text_to_nodes('\n'.join(_table(SECTIONS[self.arguments[0]])))


def _table(quantities: Mapping[str, Quantity]) -> Iterable[str]:
    yield '| key | meaning | usual | possible | left out |'
    yield '|---|---|---|---|---|'
    for name, quantity in quantities.items():
        unit, scale = _usual_unit(quantity)
        keys = ', '.join(f'`{"_".join(filter(None, (name, suffix)))}`'
                         for suffix in UNITS[quantity.dimension])
        symbol = SYMBOLS.get(unit, unit)
        yield '| ' + ' | '.join((
            keys, MEANINGS[name], span(quantity.plausible, scale, symbol),
            span((quantity.above, quantity.below), scale, symbol),
            'required' if quantity.default is None else f'{quantity.default:g}')) + ' |'


def _usual_unit(quantity: Quantity) -> tuple[str, float]:
    """Return the unit that descriptions mostly have, and its SI value."""
    units = UNITS[quantity.dimension]
    unit = next((one for one in ('mm', 'gpa', 'deg', 'hz') if one in units), next(iter(units)))
    return unit, units[unit]


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive('brake-keys', BrakeKeys)
    return {'parallel_read_safe': True}

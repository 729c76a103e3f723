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

"""Models at changed values of a model's affine quantities, without a brake description."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from squeal_core.model.brake_model import BrakeModel

_PARTS = ('disc', 'pad 1', 'pad 2')


class AffineVariants:
    """
    Gives models with one of their own quantities multiplied by a factor.

    Parameters
    ----------
    model : BrakeModel
        Of any source. Parts are those that the names of its modes begin with: 'disc', 'pad 1',
        'pad 2'.

    Attributes
    ----------
    parameters : dict
        What can be varied: value [SI units] and unit by name.

    """

    def __init__(self, model: BrakeModel) -> None:
        self.model = model
        self._parts = {part: np.array([name.startswith(f'{part} ') for name in model.names])
                       for part in _PARTS if any(name.startswith(f'{part} ')
                                                 for name in model.names)}
        self.parameters = {name: value for name, value in self._known() if value[0]}

    def _known(self) -> list[tuple[str, tuple[float, str]]]:
        model, law, caliper = self.model, self.model.friction_law, self.model.caliper
        result = [('contact.stiffness', (model.nominal_contact_stiffness, 'N/m^3')),
                  ('contact.retardation_time', (model.contact_retardation_time, 's')),
                  ('damping_ratio', (float(np.mean(model.damping_ratios)), ''))]
        result += [(f'{part}.young_modulus', (1.0, 'times what it is')) for part in self._parts]
        if law is not None:
            result += [(f'friction.{name}', (getattr(law, name), unit)) for name, unit in (
                ('static', ''), ('kinetic', ''), ('decay', 's/m'))]
        if caliper is not None:
            result.append(('caliper.piston_area', (caliper.piston_area, 'm^2')))
        return result + [(f'support.{kind}', (1.0, 'times what it is'))
                         for kind in ('stiffness', 'damping')
                         if getattr(model, f'support_{kind}') is not None]

    def affine(self, _: str) -> bool:
        """Return True: no parameter needs a part solved again."""
        return True

    def __call__(self, path: str, factor: float) -> BrakeModel:
        """Return the model with the quantity of a name multiplied by a factor."""
        group, _, name = path.partition('.')
        if name == 'young_modulus':
            frequencies = np.where(self._parts[group], factor**0.5, 1.0)
            return replace(self.model, angular_frequencies=frequencies
                           * self.model.angular_frequencies)
        change: Callable[[Any], Any] = {
            'damping_ratio': lambda m: {'damping_ratios': factor * m.damping_ratios},
            'contact.stiffness': lambda m: {
                'nominal_contact_stiffness': factor * m.nominal_contact_stiffness,
                'stiffness_table': m.stiffness_table and replace(
                    m.stiffness_table, stiffness=tuple(
                        factor * one for one in m.stiffness_table.stiffness))},
            'contact.retardation_time': lambda m: {
                'contact_retardation_time': factor * m.contact_retardation_time},
        }.get(path, lambda m: self._other(group, name, factor))
        return replace(self.model, **change(self.model))

    def _other(self, group: str, name: str, factor: float) -> dict[str, Any]:
        if group == 'support':
            return {f'support_{name}': factor * getattr(self.model, f'support_{name}')}
        field = {'friction': 'friction_law', 'caliper': 'caliper'}[group]
        owner = getattr(self.model, field)
        return {field: replace(owner, **{name: factor * getattr(owner, name)})}

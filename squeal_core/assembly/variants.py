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

"""Models of a brake with one number of its description changed; built anew only where needed."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.assembly.build import damping_ratios
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.brake.design_parameters import scaled
from squeal_core.brake.dimensions import Brake, HatDisc, ModalResults, Pad
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.change_of_basis import aligned
from squeal_core.model.matrix_names import OPERATORS, SUPPORTS

_FURTHER = 4  # modes of each part


class BrakeVariants:
    """
    Models of a brake at changed values of its description, in the coordinates of one.

    Parameters
    ----------
    model : BrakeModel
        Of the brake as it is described.
    content : mapping
        Its description.
    folder : path
        In which files that it names are looked for.
    build : callable
        Builds the model of a brake, with the settings that the model was built with.

    Notes
    -----
    What no mode depends on (contact stiffness, damping, laws, caliper) is replaced in the model.
    Young's modulus and density of a part change its modes by factors, exactly: frequencies go
    with (E/rho)^1/2, mass-normalised shapes with rho^-1/2, and G0 stays. All else is built anew
    and aligned with the model (`change_of_basis.aligned`).

    """

    def __init__(self, model: BrakeModel, content: Mapping[str, Any], folder: Path,
                 build: Callable[[Brake], BrakeModel]) -> None:
        self.model, self.content, self._folder, self._build = model, content, folder, build
        self.brake = self._brake(content)
        count = self.brake.pad_modes
        self._cuts = [count, model.size - count]

    def _brake(self, content: Mapping[str, Any]) -> Brake:
        return parse_brake(content, folder=self._folder, warn=lambda _: None)

    def affine(self, path: str) -> bool:
        """Return whether the model follows a parameter without any part being solved again."""
        return self._same_modes(self._brake(scaled(self.content, path, 0.999)))

    def __call__(self, path: str, factor: float) -> BrakeModel:
        """
        Return the model with the number at a path multiplied by a factor.

        Raises
        ------
        BrakeDescriptionError
            For a value that is not possible.

        """
        changed = self._brake(scaled(self.content, path, factor))
        if not self._same_modes(changed):
            # a few modes more: where two change places at the end of the list, both are there
            return aligned(self._build(replace(
                changed, disc_modes=changed.disc_modes + _FURTHER,
                pad_modes=changed.pad_modes + _FURTHER)), self.model)
        stretch, size = self._of_modes(changed)
        frequencies = stretch * self.model.angular_frequencies
        arrays: dict[str, Any] = {
            name: size * array * size[:, None]
            for name in (*OPERATORS, *SUPPORTS) if name != 'gyroscopic'
            for array in [getattr(self.model, name)] if array is not None}
        contact = changed.contact
        return replace(
            self.model, angular_frequencies=frequencies, **arrays,
            damping_ratios=damping_ratios(changed, np.split(frequencies, self._cuts)),
            nominal_contact_stiffness=contact.stiffness, stiffness_table=contact.stiffness_table,
            contact_retardation_time=contact.retardation_time, caliper=changed.caliper,
            friction_law=changed.friction_law, friction_table=changed.friction_table)

    def _same_modes(self, changed: Brake) -> bool:
        return _geometry(changed) == _geometry(self.brake)

    def _of_modes(self, changed: Brake) -> tuple[FloatArray, FloatArray]:
        """Return the factors (N,) on frequencies and on shapes, pad 1 | disc | pad 2."""
        stretch, size = np.ones(self.model.size), np.ones(self.model.size)
        for place, before, after in zip(
                np.split(np.arange(self.model.size), self._cuts), _parts(self.brake),
                _parts(changed), strict=True):
            if isinstance(before, ModalResults) or isinstance(after, ModalResults):
                continue
            stiffer = after.material.young_modulus / before.material.young_modulus
            heavier = after.material.density / before.material.density
            stretch[place], size[place] = (stiffer / heavier)**0.5, heavier**-0.5
        return stretch, size


def _parts(brake: Brake) -> tuple[HatDisc | Pad | ModalResults, ...]:
    """Return the parts in the order of a model's modes."""
    return brake.pads[0], brake.disc, brake.pads[1]


def _geometry(brake: Brake) -> tuple[Any, ...]:
    """Return all that modes and contact arrays depend on, but for two factors."""
    parts = [part if isinstance(part, ModalResults) else replace(part, material=replace(
        part.material, young_modulus=1.0, density=1.0)) for part in _parts(brake)]
    contact = brake.contact
    return (*parts, brake.supports, contact.inner_radius, contact.outer_radius, contact.angle)

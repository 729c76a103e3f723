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

"""A small model, and what any model holds."""

import dataclasses
from typing import Any

import numpy as np
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.friction import FrictionLaw, FrictionTable
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.surface_shapes import SurfaceShapes

SMALL = np.arange(9.0).reshape(3, 3) / 7.0


def small_model(**changes: Any) -> BrakeModel:
    return BrakeModel(**{
        'angular_frequencies': [0.0, 1e4 / 3.0, 2e4], 'damping_ratios': [0.002, 0.003, 1e-300],
        'gyroscopic': SMALL - SMALL.T, 'contact_stiffness': SMALL + SMALL.T,
        'friction_couple': SMALL, 'radial_dissipation': None, 'contact_radius': 0.1 / 3,
        'caliper': Caliper(2.5e-3, 0.9), 'friction_law': FrictionLaw(0.55, 0.3, 1 / 3),
        'friction_table': FrictionTable(np.array([500 / 3, 293.15]), np.array([0.35, 0.4])),
        'names': ('slide', 'lift', 'Biegung ü'), 'provenance': {'made': 'here', 'n': [1, 2.5]},
        **changes})


def content(model: BrakeModel) -> dict[str, Any]:
    """Everything a model holds, arrays as bytes."""
    def frozen(value: Any) -> Any:
        if isinstance(value, SurfaceShapes):
            return frozen(value.points), frozen(value.shapes), value.patches
        return (value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value
    return {item.name: frozen(getattr(model, item.name)) for item in dataclasses.fields(model)}

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

"""A sector of steel, and the elements of second order that solids are made of."""

import numpy as np
import skfem
from squeal_core.brake.dimensions import Contact, Material

STEEL = Material(young_modulus=210e9, density=7850.0, poisson_ratio=0.3)
SECTOR = Contact(0.1, 0.142, np.deg2rad(40.0), 1e10)
SECOND_ORDER = {'tet10': (skfem.ElementTetP2, 'tetrahedra'),
                'hex20': (skfem.ElementHexS2, 'hexahedra'),
                'hex27': (skfem.ElementHex2, 'hexahedra')}

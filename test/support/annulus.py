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

"""Irregular nodes of an annulus."""

import numpy as np
from squeal_core.common.arrays import FloatArray

INNER, OUTER = 0.09, 0.15


def scattered(spacing: float, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """Nodes of an annulus a spacing apart, each moved at random, those on its edges along them."""
    rng = np.random.default_rng(seed)
    rows = np.linspace(INNER, OUTER, 1 + round((OUTER - INNER) / spacing))
    radius, angle = [], []
    for i, r in enumerate(rows):
        count = round(2.0 * np.pi * r / spacing)
        inside = 0 < i < rows.size - 1
        radius.append(r + inside * 0.3 * spacing * rng.uniform(-1, 1, count))
        angle.append((np.arange(count) + 0.3 * rng.uniform(-1, 1, count)) * 2.0 * np.pi / count)
    return np.concatenate(radius), np.concatenate(angle)

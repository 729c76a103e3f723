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

"""The build-up by growth rates against transients that know no matrix of friction."""

from collections.abc import Sequence

import numpy as np
import pytest
from squeal_core import BrakeModel, complex_modes, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.model.operators import ContactFace
from squeal_core.risk.build_up import FLOOR, saturation_energy
from squeal_core.risk.tracked_build_up import TrackedBuildUp
from squeal_core.simulation import OperatingHistory, Transient
from squeal_core.stability.eigensolution import SQUEAL_BAND

Faces = tuple[ContactFace, ContactFace]
DURATION, BLOCK = 0.08, 0.01  # s
RAMPS = ((0.30, 0.44), (0.50, 0.70))  # of friction; growth from 20 to 37 and 50 to 100 1/s


def operating(kang: BrakeModel, friction: float) -> OperatingPoint:
    return kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=friction,
                                friction_slope=0.0)


def in_band(frequency: FloatArray) -> FloatArray:
    return (frequency >= SQUEAL_BAND[0]) & (frequency <= SQUEAL_BAND[1])


def simulated(kang: BrakeModel, faces: Faces) -> FloatArray:
    """Return ln of the largest modal amplitude over the floor, (blocks, ramps)."""
    start, end = ([operating(kang, ramp[i]) for ramp in RAMPS] for i in (0, 1))
    transient = Transient(kang, faces, OperatingHistory.ramps(start, end, DURATION), floor=FLOOR)
    modes = transient.modes
    chosen = in_band(modes.angular_frequencies / (2.0 * np.pi))
    shapes, frequency = modes.shapes[:, chosen], modes.angular_frequencies[chosen, None]
    square = np.array([
        ((shapes.T @ block.displacement)**2
         + (shapes.T @ block.velocity / frequency)**2).mean(axis=0) / 2.0
        for block in transient.run()])
    amplitude = np.sqrt(square) * modes.contact_motion[chosen, None]
    return np.asarray(np.log(amplitude.max(axis=1) / FLOOR))


def computed(kang: BrakeModel, ramp: Sequence[float]) -> FloatArray:
    """Return the largest build-up in the middle of each block."""
    tracked = TrackedBuildUp.of(kang, operating(kang, ramp[0]))
    tracked.release(0)
    found = []
    for time in np.arange(0.5 * BLOCK, DURATION, BLOCK):
        point = operating(kang, ramp[0] + (ramp[1] - ramp[0]) * time / DURATION)
        roots = complex_modes(kang, point).oscillatory
        cap = saturation_energy(point.contact_pressure, point.contact_stiffness)
        found.append(tracked.update(round(1e9 * (time + 0.5 * BLOCK)), roots[
            in_band(roots.imag / (2.0 * np.pi))], float(cap)).max())
    return np.array(found)


def test_build_up_is_the_level_of_the_transient(kang: BrakeModel, faces: Faces) -> None:
    """Along two friction ramps; the mean of two blocks, as noise fluctuates."""
    levels = simulated(kang, faces)
    for ramp, level, least in zip(RAMPS, levels.T, (1.5, 4.5), strict=True):
        wanted = 0.5 * (level[1:] + level[:-1])
        found = computed(kang, ramp)
        assert 0.5 * (found[1:] + found[:-1]) == pytest.approx(wanted, abs=1.2)
        assert wanted[-1] > least

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

"""Which of many brake applications squeal: integrated side by side, each until it is heard."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.operators import ContactFace
from squeal_core.simulation.history import OperatingHistory
from squeal_core.simulation.levels import LevelMeter, SimulatedEvent, squeal_events, THRESHOLD
from squeal_core.simulation.microphone import Microphone
from squeal_core.simulation.transient import Transient

TOGETHER = 32
"""Applications at once: products with more columns are hardly faster a column."""
_EVERY = 0.1  # s between looks for events


def first_events(model: BrakeModel, faces: Sequence[ContactFace],
                 histories: Sequence[OperatingHistory], seeds: Sequence[int], *,
                 damping_scales: Sequence[float], floor: float = 1e-9,
                 threshold: float = THRESHOLD, steps: int = 1, together: int = TOGETHER,
                 progress: Callable[[int], None] = lambda _: None
                 ) -> list[SimulatedEvent | None]:
    """
    Return the first squeal event of each of many brake applications; None: it is silent.

    An application is integrated until its first event has been heard for 50 ms at least, and its
    pitch and level are those until then. What becomes of one depends on no other but by the mean
    contact stiffness and damping that its group has in common: by O(h^2) of the step.

    Parameters
    ----------
    model : BrakeModel
        Of all brakes.
    faces : sequence of ContactFace
        `contact_points` of the model.
    histories : sequence of OperatingHistory
        Of one brake each.
    seeds : sequence of int
        Of the noise of each.
    damping_scales : sequence of float
        Of each.
    floor, threshold, steps
        As of `simulate`; with one step a sample growth rates of modes up to 7 kHz are within 1 %.
    together : int
        Applications that are integrated side by side.
    progress : callable
        Told the number of applications that are done.

    Raises
    ------
    SquealError
        As of `simulate`.

    """
    result: dict[int, SimulatedEvent | None] = {}
    order = sorted(range(len(histories)), key=lambda i: float(np.ptp(histories[i].time)))
    for start in range(0, len(order), together):
        some = order[start:start + together]
        transient = Transient(
            model, faces, OperatingHistory.side_by_side([histories[i] for i in some]),
            floor=floor, steps=steps, seed=[seeds[i] for i in some],
            damping_scale=[damping_scales[i] for i in some])
        result |= zip(some, _heard(transient, Microphone.of(model), np.array(
            [np.ptp(histories[i].time) for i in some]), threshold), strict=True)
        progress(len(result))
    return [result[i] for i in range(len(histories))]


def _heard(transient: Transient, microphone: Microphone, duration: FloatArray,
           threshold: float) -> list[SimulatedEvent | None]:
    """Return the first event of each brake, whose application takes a time [s]."""
    meter, brakes = LevelMeter(transient.modes, microphone), transient.history.brakes
    result: dict[str, SimulatedEvent] = {}
    looked = 0.0

    def look() -> None:
        levels = meter.levels()
        left = [i for i, name in enumerate(brakes) if name not in result]
        part = replace(levels, **{name: getattr(levels, name)[:, :, left]
                                  for name in ('amplitude', 'frequency', 'level')})
        for event in squeal_events(part, tuple(brakes[i] for i in left), threshold=threshold):
            result.setdefault(event.brake, event)

    def ended(time: float) -> NDArray[np.bool_]:
        nonlocal looked
        if time >= looked + _EVERY:
            looked = time
            look()
        return (time >= duration) | np.isin(brakes, [*result])

    for block in transient.run(balance=False, ended=ended):
        meter.add(block)
    look()
    return [result.get(name) for name in brakes]

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


"""Simulation of squeal: a transient, heard by a microphone at each brake, and its events."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.operators import ContactFace
from squeal_core.simulation.history import OperatingHistory
from squeal_core.simulation.levels import (
    LevelMeter,
    ModalLevels,
    SimulatedEvent,
    squeal_events,
    THRESHOLD,
)
from squeal_core.simulation.microphone import Microphone
from squeal_core.simulation.transient import STEPS, Transient


@dataclass(frozen=True, eq=False)
class SimulationResult:
    """
    What was heard of B brakes.

    Parameters
    ----------
    brakes : tuple of str
    sound : (S, B) array
        Sound pressure at 48 kHz [Pa].
    levels : ModalLevels
        Of the modes at mu = 0, every 10 ms.
    events : list of SimulatedEvent
    sliding : (T, B) array of bool
        Whether each brake slid under load, on the times of the levels.

    """

    brakes: tuple[str, ...]
    sound: FloatArray
    levels: ModalLevels
    events: list[SimulatedEvent]
    sliding: NDArray[np.bool_]

    __repr__ = repr_with_shapes


def simulate(model: BrakeModel, faces: Sequence[ContactFace], history: OperatingHistory, *,
             floor: float = 1e-9, seed: int = 0, abutment: bool = True, steps: int = STEPS,
             damping_scale: float = 1.0, threshold: float = THRESHOLD,
             start: FloatArray | None = None,
             progress: Callable[[float], None] = lambda _: None) -> SimulationResult:
    """
    Integrate the nonlinear contact of brakes over a history and listen to it.

    Parameters
    ----------
    model : BrakeModel
        Of all brakes.
    faces : sequence of ContactFace
        `contact_points` of the model.
    history : OperatingHistory
        Where the brakes operate.
    floor, seed, abutment, steps, damping_scale
        As of `Transient`.
    threshold : float
        Sound pressure level at which an event starts [dB re 20 uPa].
    start : (2N, B) array, optional
        Modal coordinates and their rates at the start; None: at rest.
    progress : callable
        Told the time [s] that is reached.

    Raises
    ------
    SquealError
        For a model without surface, a step too long for the friction, and motion that does not
        stay finite.

    Examples
    --------
    >>> from squeal_core import BrakeModel
    >>> from squeal_core.simulation import contact_points, OperatingHistory, simulate
    >>> model = BrakeModel.load('kang2009')
    >>> point = model.operating_point(rotor_speed=20.0, pressure=8e5, friction=0.42,
    ...                               friction_slope=0.0)
    >>> result = simulate(model, contact_points(model),
    ...                   OperatingHistory.ramps([point], [point], 0.02))
    >>> result.sound.shape, result.levels.level.shape, result.events
    ((960, 1), (2, 92, 1), [])

    """
    transient = Transient(model, faces, history, floor=floor, seed=seed, abutment=abutment,
                          steps=steps, damping_scale=damping_scale)
    microphone = Microphone.of(model)
    meter = LevelMeter(transient.modes, microphone)
    recorders = [microphone.listen() for _ in history.brakes]
    sliding = []
    for block in transient.run(start, balance=False, progress=progress):
        meter.add(block)
        sliding.append(block.sliding)
        for i, recorder in enumerate(recorders):
            recorder.add(block.velocity[:, :, i])
    levels = meter.levels()
    return SimulationResult(
        history.brakes, np.column_stack([recorder.sound() for recorder in recorders]), levels,
        squeal_events(levels, history.brakes, threshold=threshold), np.array(sliding))

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

"""The unstable modes of a tracked sweep over one parameter, each with its mechanism."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Mode
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_core.stability.mechanism import mechanisms, without_rotation
from squeal_core.stability.mode_name import short_name
from squeal_core.stability.parameter_paths import PARAMETERS
from squeal_core.studies.sweep_record import Sweep


class UnstableMode(NamedTuple):
    """A mode that oscillates and grows, at one point of a sweep."""

    place: int
    identity: str
    frequency_hz: float
    growth_rate: float
    damping_ratio: float
    mechanism: str


def unstable_modes(model: BrakeModel, record: Sweep, *, workers: int = 0,
                   progress: Callable[[int, int], None] | None = None) -> list[UnstableMode]:
    """
    Return the flutter of a sweep, point by point, with the mechanism of each mode.

    Parameters
    ----------
    model : BrakeModel
        Of the sweep, with rotation.
    record : Sweep
        Of it; the mechanisms of a point take about a second.
    workers : int
        Processes; 0: this one.
    progress : callable, optional
        Told how many points are done, and of how many.

    """
    model = model if record.about['rotation'] else without_rotation(model)
    jobs = {int(place): (model, point_of(record, int(place)), _flutter(record, int(place)))
            for place in np.flatnonzero((record.kinds == 'flutter').any(axis=1))}
    labels: dict[int, list[str]] = {}
    for place, result in run_jobs(_labels, jobs, workers):
        labels[place] = result
        if progress:
            progress(len(labels), len(jobs))
    return [UnstableMode(place, str(record.identities[place, mode.index - 1]), mode.frequency_hz,
                         mode.growth_rate, mode.damping_ratio, label)
            for place, (*_, modes) in jobs.items()
            for mode, label in zip(modes, labels[place], strict=True)]


def _flutter(record: Sweep, place: int) -> list[Mode]:
    return [Mode(int(i) + 1, complex(record.eigenvalues[place, i]), 'flutter')
            for i in np.flatnonzero(record.kinds[place] == 'flutter')]


def _labels(model: BrakeModel, point: OperatingPoint, modes: Sequence[Mode]) -> list[str]:
    return [why.label for why in mechanisms(model, point, modes)]


def point_of(record: Sweep, place: int) -> OperatingPoint:
    """Return the operating point at a place of a sweep."""
    return OperatingPoint(**dict(zip(PARAMETERS, record.points[place].tolist(), strict=True)),
                          damping_scale=record.about.get('damping_scale', 1.0))


def mode_names(model: BrakeModel, record: Sweep,
               modes: Sequence[UnstableMode]) -> dict[str, str]:
    """
    Return the names of unstable modes by identity: its numbers and leading component modes.

    Parameters
    ----------
    model, record : BrakeModel, Sweep
        As for `unstable_modes`.
    modes : sequence of UnstableMode
        What it gave; each is named by where its damping ratio is the lowest.

    """
    worst: dict[str, UnstableMode] = {}
    for mode in sorted(modes, key=lambda one: one.damping_ratio):
        worst.setdefault(mode.identity, mode)
    model = model if record.about['rotation'] else without_rotation(model)
    return {identity: f'{identity}  {_leading(model, record, mode)}'.rstrip()
            for identity, mode in worst.items()}


def _leading(model: BrakeModel, record: Sweep, mode: UnstableMode) -> str:
    eigenvalue = complex(mode.growth_rate, 2.0 * np.pi * mode.frequency_hz)
    right = mode_vectors(model, point_of(record, mode.place), eigenvalue).right
    return short_name(model, right)

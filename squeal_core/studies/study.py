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

"""
Studies over any number of parameters, of the operation and of the design.

The grid is divided into boxes of points of one brake, each a job of its own: results do not depend
on how many processes there are, nor on what was kept of an earlier run.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, fields
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.dimensions import HatDisc, Pad
from squeal_core.common.errors import SquealError
from squeal_core.studies.design import BrakeDesign
from squeal_core.studies.study_checkpoint import BoxResult, StudyCheckpoint
from squeal_core.studies.study_jobs import solve_box, solve_part
from squeal_core.studies.study_record import in_order, Study
from squeal_core.studies.study_spec import Box, StudySpec, Values
from squeal_core.studies.study_tasks import LocusTask
from squeal_core.surrogate.grid_columns import IMPOSSIBLE

Run: TypeAlias = Callable[[Callable[..., Any], Mapping[int, tuple[Any, ...]]],
                          Iterator[tuple[int, Any]]]
"""Yields key and result of a function with the arguments of each job, in any order."""


def run_study(spec: StudySpec, run: Run, *, checkpoint: StudyCheckpoint | None = None,
              progress: Callable[[int, int], None] = lambda *_: None,
              warn: Callable[[str], None] = lambda _: None) -> Study:
    """
    Compute a study.

    Parameters
    ----------
    spec : StudySpec
        What is asked for.
    run : callable
        Runs jobs, as `run_jobs` does.
    checkpoint : StudyCheckpoint, optional
        Has the boxes of an earlier run, and keeps each new one.
    progress : callable
        Told how many points are done, and of how many.
    warn : callable
        Told of unusual values of the design.

    Raises
    ------
    SquealError
        Where no point is possible.

    Notes
    -----
    An interrupt (Ctrl-C) ends it early; points that are not done have the source 0.

    """
    spec.key  # noqa: B018 - hashed once, for workers too
    variants, boxes = spec.variants(), list(_boxes(spec))
    impossible = _impossible(spec, variants, warn)
    jobs = {i: (spec, variants[i // len(boxes)], boxes[i % len(boxes)])
            for i in range(len(variants) * len(boxes)) if i // len(boxes) not in impossible}
    table = _Table(spec, variants, boxes, impossible)
    kept = checkpoint.read(jobs) if checkpoint else {}
    for i, result in kept.items():
        table.take(i, result)
    progress(table.done, table.total)
    try:
        left = {i: job for i, job in jobs.items() if i not in kept}
        _solve_parts(spec, [variants[i] for i in sorted({i // len(boxes) for i in left})], run)
        for i, result in run(solve_box, left):
            if checkpoint:
                checkpoint.keep(i, result)
            table.take(i, result)
            progress(table.done, table.total)
    except KeyboardInterrupt:
        pass
    return table.study()


def _boxes(spec: StudySpec) -> Iterator[Box]:
    """Divide the grid of operating points into boxes of so many points, lines left whole."""
    most, shape = spec.task.points_of_a_job, spec.shape
    whole = isinstance(spec.task, LocusTask) and spec.task.along

    def divided(box: Box) -> Iterator[Box]:
        lengths = [high - low for low, high in box]
        free = lengths[:-1] if whole else lengths
        if int(np.prod(lengths)) <= most or max(free, default=1) <= 1:
            yield box
            return
        axis = int(np.argmax(free))
        low, high = box[axis]
        middle = (low + high) // 2
        for ends in ((low, middle), (middle, high)):
            yield from divided((*box[:axis], ends, *box[axis + 1:]))

    yield from divided(tuple((0, n) for n in shape))


def _impossible(spec: StudySpec, variants: list[Values],
                warn: Callable[[str], None]) -> dict[int, str]:
    """Return the reasons why brakes are impossible, by variant; raise where all are."""
    if not isinstance(spec.source, BrakeDesign):
        return {}
    reasons: dict[int, str] = {}
    for i, values in enumerate(variants):
        try:
            spec.source.brake(values, warn=warn)
        except SquealError as error:
            reasons[i] = str(error)
    if len(reasons) == len(variants):
        raise SquealError(reasons[0])
    return reasons


def _solve_parts(spec: StudySpec, variants: list[Values], run: Run) -> None:
    """Solve each disc and each pair of pads once, side by side, ahead of the brakes."""
    if not isinstance(spec.source, BrakeDesign) or spec.cache is None:
        return
    jobs: dict[Any, tuple[Any, ...]] = {}
    for values in variants:
        brake = spec.source.brake(values, warn=lambda _: None)
        if isinstance(brake.disc, HatDisc):
            jobs.setdefault((brake.disc, brake.disc_modes), (spec, values, 'disc'))
        sector = brake.contact.inner_radius, brake.contact.outer_radius, brake.contact.angle
        if any(isinstance(pad, Pad) for pad in brake.pads):
            jobs.setdefault((brake.pads, sector, brake.pad_modes), (spec, values, 'pads'))
    for _ in run(solve_part, dict(enumerate(jobs.values()))):
        pass


class _Table:
    """The columns of a study as its boxes come in."""

    def __init__(self, spec: StudySpec, variants: list[Values], boxes: list[Box],
                 impossible: Mapping[int, str]) -> None:
        self._spec, self._variants, self._boxes = spec, variants, boxes
        self._places = np.arange(int(np.prod(spec.shape))).reshape(spec.shape)
        self.total = len(variants) * self._places.size
        self._columns = {name: np.full((len(variants), self._places.size), np.nan)
                         for name in spec.task.columns}
        self._columns['source'][:] = 0.0
        self._counts: dict[str, float] = {}
        self._reasons: dict[tuple[int, str], int] = {}
        for i, reason in impossible.items():
            self._refuse(i, self._places.ravel(), reason)

    def take(self, job: int, result: BoxResult) -> None:
        variant, box = divmod(job, len(self._boxes))
        places = self._places[tuple(slice(*ends) for ends in self._boxes[box])].ravel()
        if not result.columns:
            self._refuse(variant, places, result.reason)
            return
        for name, values in result.columns.items():
            self._columns[name][variant, places] = values
        if result.reason:
            lost = places[result.columns['source'] == IMPOSSIBLE]
            self._refuse(variant, lost, result.reason)
        for name, count in result.counts.items():
            before = self._counts.get(name, 0.0)
            self._counts[name] = max(before, count) if name.startswith('largest') else (
                before + count)

    def _refuse(self, variant: int, places: Any, reason: str) -> None:
        self._columns['source'][variant, places] = IMPOSSIBLE
        key = variant, reason
        self._reasons[key] = self._reasons.get(key, 0) + len(places)

    @property
    def done(self) -> int:
        return int(np.count_nonzero(self._columns['source']))

    def study(self) -> Study:
        spec = self._spec
        order = (*spec.design, *spec.operation)
        options = {item.name: getattr(spec.options, item.name) for item in fields(spec.options)
                   if item.name not in spec.axes}
        about = {
            'brake': spec.brake, 'task': type(spec.task).__name__.removesuffix('Task').lower(),
            **{name: list(value) if isinstance(value, tuple) else value
               for name, value in asdict(spec.task).items()},
            'point': options, 'friction_law': spec.law, 'rotation': spec.rotation,
            'counts': self._counts, 'impossible': [
                {'values': self._variants[variant], 'points': count, 'reason': reason}
                for (variant, reason), count in sorted(self._reasons.items())]}
        return Study(axes=dict(spec.axes), about=about, columns=in_order(spec.axes, order, {
            name: values.ravel() for name, values in self._columns.items()}))

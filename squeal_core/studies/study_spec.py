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

"""Specification of a study: the brake, parameters, operating point and task."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import product
from typing import Any, TypeAlias

from squeal_core.common.arrays import FloatArray
from squeal_core.common.npz_archive import content_hash
from squeal_core.common.version import __version__
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.parameter_paths import Law, OPERATING
from squeal_core.studies.design import BrakeDesign
from squeal_core.studies.point_options import PointOptions
from squeal_core.studies.study_tasks import CriticalTask, LocusTask, MapTask
from squeal_core.surrogate.table_file import model_hash

Values: TypeAlias = dict[str, float]
Box: TypeAlias = tuple[tuple[int, int], ...]
"""First place and the one after the last, along each axis of a grid."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StudySpec:
    """
    Specification of a study.

    Parameters
    ----------
    source : BrakeModel or BrakeDesign
    axes : mapping
        Values by parameter: of `OPERATING`, or a path of the brake description.
    options : PointOptions
        What is not swept.
    task : MapTask, LocusTask or CriticalTask
    law : bool or 'slope'
        What follows the friction law.
    rotation : bool
        False: without G, R and S.
    cache : str, optional
        Folder of solved parts of brakes.

    """

    source: BrakeModel | BrakeDesign
    axes: Mapping[str, FloatArray]
    options: PointOptions
    task: MapTask | LocusTask | CriticalTask
    law: Law = False
    rotation: bool = True
    cache: str | None = None

    @cached_property
    def design(self) -> tuple[str, ...]:
        """Return the parameters of the design."""
        return tuple(name for name in self.axes if name not in OPERATING)

    @cached_property
    def operation(self) -> tuple[str, ...]:
        """Return those of the operation, last the one along which modes are followed."""
        names = [name for name in self.axes if name in OPERATING]
        if isinstance(self.task, LocusTask) and self.task.along:
            names = [*names[1:], names[0]]
        return tuple(names)

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the shape of the grid of operating points."""
        return tuple(len(self.axes[name]) for name in self.operation)

    @property
    def brake(self) -> str:
        """Return the name of the brake."""
        about = (self.source.content if isinstance(self.source, BrakeDesign)
                 else {'name': self.source.provenance.get('brake', '')})
        return str(about.get('name', ''))[:200]

    def variants(self) -> list[Values]:
        """Return the values of the design parameters of each brake."""
        return [dict(zip(self.design, values, strict=True))
                for values in product(*(self.axes[name].tolist() for name in self.design))]

    @cached_property
    def key(self) -> str:
        """Return a hash over all that results depend on."""
        source = self.source
        if isinstance(source, BrakeDesign):
            described: Any = [source.content, dict(source.settings), source.file_hashes()]
        else:
            caliper = source.caliper
            described = [model_hash(source), asdict(caliper) if caliper else None]
        return content_hash({
            'version': __version__, 'source': described, 'options': asdict(self.options),
            'task': [type(self.task).__name__, asdict(self.task),
                     self.task.points_of_a_job], 'law': self.law,
            'rotation': self.rotation, 'axes': list(self.axes)}, dict(self.axes))

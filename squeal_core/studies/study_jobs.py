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

"""The jobs of a study, done in whatever process: parts of brakes, boxes of operating points."""

from contextlib import suppress
from itertools import product
import math

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.mechanism import without_rotation
from squeal_core.stability.parameter_paths import OPERATING
from squeal_core.studies.design import BrakeDesign, DesignModels
from squeal_core.studies.point_options import grid_points, point_with
from squeal_core.studies.study_checkpoint import BoxResult
from squeal_core.studies.study_spec import Box, StudySpec, Values
from squeal_core.studies.study_tasks import CriticalTask, StudyPlace

# of this process: jobs of one study come one by one; a worker outlives the files it has read
_opened: dict[tuple[str, str | None], DesignModels] = {}


def _models(spec: StudySpec) -> DesignModels:
    assert isinstance(spec.source, BrakeDesign)
    key = spec.key, spec.cache
    if key not in _opened:
        _opened.clear()
        _opened[key] = DesignModels(spec.source, spec.cache)
    return _opened[key]


def solve_part(spec: StudySpec, values: Values, part: str) -> None:
    """Solve the 'disc' or the 'pads' of a brake; assembling it reports what fails."""
    with suppress(Exception):
        _models(spec).solve_part(values, part)


def solve_box(spec: StudySpec, values: Values, box: Box) -> BoxResult:
    """Compute a box of operating points of one brake; why not, where there is no such brake."""
    try:
        model = _model(spec, values)
    except SquealError as error:
        return BoxResult({}, {}, str(error))
    axes = {name: spec.axes[name][low:high].tolist()
            for name, (low, high) in zip(spec.operation, box, strict=True)}
    points, reason = grid_points(model, spec.options.at(model), axes, spec.law)
    moves = list(product(*axes.values()))

    def rebuilt(i: int, value: float) -> tuple[BrakeModel | None, OperatingPoint | None]:
        with suppress(SquealError):
            there = _model(spec, {**values, path: value})
            move = dict(zip(axes, moves[i], strict=True))
            return there, point_with(there, spec.options.at(there), move, spec.law)
        return None, None

    path = spec.task.parameter if isinstance(spec.task, CriticalTask) else OPERATING[0]
    along_design = path not in OPERATING
    columns, counts = spec.task.solve(StudyPlace(
        model=model, points=points, shape=[high - low for low, high in box],
        rebuilt=rebuilt if along_design else None,
        start=_models(spec).design.number(path) if along_design else math.nan))
    return BoxResult(columns, counts, reason)


def _model(spec: StudySpec, values: Values) -> BrakeModel:
    model = spec.source if isinstance(spec.source, BrakeModel) else _models(spec).model(values)
    return model if spec.rotation else without_rotation(model)

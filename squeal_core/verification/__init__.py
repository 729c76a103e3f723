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
Claims of K09 against results of this project: one row a claim, every number computed.

The only numbers written here are the paper's and the tolerances. Where the two differ and it is
known why, the row says so; any other difference makes `Verification.passed` False.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from itertools import chain
from typing import Any

import numpy as np
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.studies.sweep import sweep
from squeal_core.studies.sweep_record import Sweep
from squeal_core.verification.case import Case
from squeal_core.verification.claims import components, maps
from squeal_core.verification.friction_claims import pad_pair, third_doublet
from squeal_core.verification.paper import FAST, PRINTED, SLOW, SOFTER
from squeal_core.verification.parts import Parts, parts_or_why
from squeal_core.verification.row import ClaimResult, table, Verdict
from squeal_core.verification.speed_claims import over_speed, torsion

__all__ = ['as_text', 'Case', 'Parts', 'ClaimResult', 'Verdict', 'Verification', 'verify']


@dataclass(frozen=True, eq=False, kw_only=True)
class Verification:
    """Rows of the table, the sweeps behind them and K09's figures, and omissions with reasons."""

    model: BrakeModel
    rows: tuple[ClaimResult, ...]
    records: Mapping[str, Sweep]
    parts: Parts | None
    skipped: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Return whether every claim that is not reproduced is a known one, with its reason."""
        return all(row.known for row in self.rows if row.verdict == 'NOT reproduced')

    def to_json(self) -> dict[str, Any]:
        """Return the table for a program to read."""
        return {'passed': self.passed, 'rows': [asdict(row) for row in self.rows],
                'skipped': list(self.skipped)}


def verify(model: BrakeModel, *, progress: Callable[[str], None] = lambda _: None,
           workers: int = 0, stride: int = 1) -> Verification:
    """
    Rerun K09 and return, claim by claim, the paper's results and those of the model.

    Parameters
    ----------
    model : BrakeModel
        Of K09's brake: the shipped `kang2009`, or another build of its description.
    progress : callable
        Told in a few words what is being done.
    workers : int
        Processes for the stability maps; 0: this one.
    stride : int
        Solve every stride-th point of the sweeps that figures alone show; no claim uses them.

    Raises
    ------
    SquealError
        For a model of another brake.

    """
    missing = {name for _, name, *_ in PRINTED} - set(model.names)
    if missing or model.friction_law is None:
        what = ', '.join(sorted(missing)) or 'friction law'
        raise SquealError(f"verify: the model has no {what}; give one of K09's brake, as kang2009")
    progress('modes of disc and pads')
    parts, skipped = parts_or_why(model)
    progress('sweeps')
    records = sweeps(model, parts, workers, stride)
    rows: list[ClaimResult] = []
    for row in _rows(Case(model), records, parts):
        progress(row.claim)
        rows.append(row)
    return Verification(model=model, rows=tuple(rows), records=records, parts=parts,
                        skipped=skipped)


def _rows(case: Case, records: Mapping[str, Sweep], parts: Parts | None) -> Iterator[ClaimResult]:
    return chain(components(case), maps(case), third_doublet(case), pad_pair(case, parts),
                 over_speed(case, records['figure 15']), torsion(case, parts))


def sweeps(model: BrakeModel, parts: Parts | None, workers: int,
           stride: int = 1) -> dict[str, Sweep]:
    """Return the sweeps of K09's figures, and of two changed brakes in which fig. 11 comes out."""
    case, friction = Case(model), np.linspace(0.0, 0.6, 61)[::stride]
    stiffness = model.nominal_contact_stiffness * np.linspace(0.02, 1.2, 60)[::stride]
    speeds = np.concatenate([np.linspace(0.25, 5.0, 20), np.linspace(6.0, 25.0, 20)])
    result = {f'figure {figure}': sweep(model, case.at(speed), {'contact_stiffness': stiffness},
                                        workers=workers)
              for figure, speed in ((10, SLOW), (13, FAST))}
    result['figure 15'] = sweep(model, case.by_law(SLOW), {'rotor_speed': speeds},
                                friction_law=True, tracked=True)
    brakes = {'friction': (model, 1.0), 'friction, softer': (model, SOFTER[1])}
    if parts:
        brakes['friction, sums'] = parts.by_sums, 1.0
    for name, (brake, relative) in brakes.items():
        point, axes = case.at(SLOW, stiffness=relative), {'friction': friction}
        result[name] = sweep(brake, point, axes, tracked=True)
        result[f'{name}, no rotation'] = sweep(brake, point, axes, rotation=False, tracked=True)
    if not all(record.complete for record in result.values()):
        raise KeyboardInterrupt  # it ends a sweep early, which keeps what it has
    return result


def as_text(result: Verification) -> str:
    """Return the table as text, 99 columns wide, and claims not reproduced with the reason."""
    return table(result.rows, result.skipped, passed=result.passed)

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
Stability over one or two parameters: maps, loci and growth rates, as plain records.

Sources: K09 figs 10 and 13 (contact stiffness), 11 and 12 (friction, with and without rotation),
15 (speed, with the friction law).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray, readonly
from squeal_core.common.errors import SquealError
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.stability.mechanism import without_rotation
from squeal_core.stability.mode_tracking import track
from squeal_core.stability.parameter_paths import Law, PARAMETERS
from squeal_core.studies.point_options import brake_pressure, point_with
from squeal_core.studies.sweep_record import make_sweep, Sweep

_CHUNK = 8  # points a worker takes at a time

Progress: TypeAlias = Callable[[int, int], None]
_Row: TypeAlias = tuple[list[complex], list[str], list[str]]


def sweep(model: BrakeModel, point: OperatingPoint, axes: Mapping[str, ArrayLike], *,
          rotation: bool = True, friction_law: Law = False, tracked: bool = False,
          workers: int = 0, progress: Progress | None = None,
          tolerances: Tolerances | None = None) -> Sweep:
    """
    Solve for the modes over one or two parameters.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        What the parameters that are not swept are. With friction its slope goes in proportion.
    axes : mapping
        Values by name of parameter (`tracking.PARAMETERS`); one or two.
    rotation : bool
        False: without G, R and S, K09's disc that does not rotate.
    friction_law : bool or 'slope'
        Friction and slope by the model's law at each speed; 'slope': the slope alone, scaled to
        the friction.
    tracked : bool
        Carry identities along the last axis, from those at its first value.
    workers : int
        Processes to use; 0: this one, as for a single line that is tracked. The workers' BLAS
        runs one thread; where it does here too results are the same bit for bit.
    progress : callable, optional
        Told how many points are done, and of how many.
    tolerances : Tolerances, optional
        Of the classification of eigenvalues.

    Notes
    -----
    An interrupt (Ctrl-C) ends the sweep early: what is done is returned, `complete` is False.

    Examples
    --------
    >>> from squeal_core import BrakeModel, OperatingPoint, sweep
    >>> model = BrakeModel(angular_frequencies=[1e4, 1.02e4], damping_ratios=0.002,
    ...                    friction_couple=[[0.0, 1e-3], [-1e-3, 0.0]])
    >>> point = OperatingPoint(rotor_speed=7.0, friction=0.3, contact_pressure=5e5,
    ...                        contact_stiffness=1e10)
    >>> record = sweep(model, point, {'friction': [0.1, 0.2, 0.3]})
    >>> record.eigenvalues.real.max(axis=1).round(1).tolist()
    [-20.0, -18.8, 89.6]

    """
    grid = _grid(axes, friction_law)
    points = [point_with(model, point, dict(zip(grid, values, strict=True)), friction_law)
              for values in product(*grid.values())]
    about = {'model': str(model.provenance.get('brake', ''))[:200], 'rotation': rotation,
             'friction_law': friction_law, 'tracked': tracked,
             'nominal_contact_stiffness': model.nominal_contact_stiffness,
             'brake_pressure': brake_pressure(model, point)}
    if point.damping_scale != 1.0:
        about['damping_scale'] = point.damping_scale
    if not rotation:
        model = without_rotation(model)
    limits = tolerances or Tolerances.of(model, point)
    length = len(list(grid.values())[-1]) if tracked else _CHUNK
    if tracked and length == len(points):
        workers = 0  # one line is one piece of work, and an interrupt here keeps a part of it
    jobs = {start: (model, points[start:start + length], tracked, limits)
            for start in range(0, len(points), length)}
    rows: dict[int, _Row] = {}
    try:
        for place, row in _solved(jobs, workers):
            rows[place] = row
            if progress:
                progress(len(rows), len(points))
    except KeyboardInterrupt:
        pass
    return _record(grid, points, rows, model.size, about)


def _grid(axes: Mapping[str, ArrayLike], friction_law: Law) -> dict[str, FloatArray]:
    """Check the swept parameters and return their values."""
    if not 1 <= len(axes) <= 2 or not set(axes) <= set(PARAMETERS):
        raise SquealError(f'axes are {list(axes)}; give one or two of {", ".join(PARAMETERS)}')
    given = {'friction_slope'} if friction_law == 'slope' else {'friction', 'friction_slope'}
    if friction_law and not given.isdisjoint(axes):
        raise SquealError(f'friction_law: it gives {" and ".join(sorted(given))}; sweep other '
                          'parameters, or leave it off')
    grid = {name: readonly(np.atleast_1d(np.asarray(v, float))) for name, v in axes.items()}
    if not all(values.ndim == 1 and values.size for values in grid.values()):
        raise SquealError(f'axes: shapes {[v.shape for v in grid.values()]}; give lists of values')
    return grid


def _solved(jobs: Mapping[int, Any], workers: int) -> Iterator[tuple[int, _Row]]:
    """Yield rows by place of their point, as they are done."""
    if workers < 1:  # row by row: an interrupt keeps what is done
        for start, job in jobs.items():
            yield from enumerate(_rows(*job), start)
        return
    for start, rows in run_jobs(_solve, jobs, workers):
        yield from enumerate(rows, start)


def _solve(model: BrakeModel, points: Sequence[OperatingPoint], tracked: bool,
           limits: Tolerances) -> list[_Row]:
    return list(_rows(model, points, tracked, limits))


def _rows(model: BrakeModel, points: Sequence[OperatingPoint], tracked: bool,
          limits: Tolerances) -> Iterator[_Row]:
    if tracked:
        for here in track(model, points, tolerances=limits):
            yield ([mode.eigenvalue for mode in here.modes], [mode.kind for mode in here.modes],
                   list(map(str, here.identities)))
    else:
        for point in points:
            modes = complex_modes(model, point, tolerances=limits).modes
            yield ([mode.eigenvalue for mode in modes], [mode.kind for mode in modes],
                   [str(mode.index) for mode in modes])


def _record(grid: dict[str, FloatArray], points: Sequence[OperatingPoint],
            rows: Mapping[int, _Row], size: int, about: dict[str, Any]) -> Sweep:
    blank: _Row = ([complex(np.nan, np.nan)] * size, [''] * size, [''] * size)
    eigenvalues, kinds, identities = zip(
        *(rows.get(place, blank) for place in range(len(points))), strict=True)
    return make_sweep(
        axes=grid, points=[[getattr(point, name) for name in PARAMETERS] for point in points],
        growth_rates=np.real(eigenvalues), angular_frequencies=np.imag(eigenvalues), kinds=kinds,
        identities=identities, about=about)

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

"""What `squeal info` says of a table."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from squeal_core.common.errors import printable
from squeal_core.model.brake_model import BrakeModel
from squeal_core.surrogate.table_file import find_table_file, read_table_header


def table_lines(path: str | Path) -> Iterator[str]:
    """Yield the lines that describe a table file."""
    header = read_table_header(path)
    domain, tolerances, about = (_mapping(header.get(name)) for name in (
        'domain', 'tolerances', 'about'))
    yield f'table            {path}, {Path(path).stat().st_size / 1e6:.1f} MB'
    yield f'model            {printable(header.get("model"))}'
    yield f'written by       squeal_ros {printable(header.get("version"))}'
    for name, unit in (('rotor_speed', 'rad/s'), ('contact_pressure', 'Pa'), ('friction', '')):
        ends = domain.get(name)
        if isinstance(ends, list) and len(ends) == 2:
            yield f'{name.replace("_", " "):16} {ends[0]:g} to {ends[1]:g} {unit}'.rstrip()
    yield f'stiffness factor {_number(domain.get("stiffness_factor"))}'
    yield (f'error bound      {_number(tolerances.get("growth"))} 1/s, or '
           f'{_number(tolerances.get("decay"))} of a decay rate')
    yield f'omitted          growth rates below {_number(tolerances.get("matters"))} 1/s'
    for name in ('build_seconds', 'kept_rows', 'workers', 'given_up'):
        if name in about:
            yield f'{name.replace("_", " "):16} {printable(about[name])}'
    coverage = about.get('coverage')
    if isinstance(coverage, dict):
        yield from coverage_lines(coverage)


def coverage_lines(report: Mapping[str, Any], *, drive: str | None = None) -> list[str]:
    """Return the lines that describe a measured coverage."""
    where = f'points of {drive}' if drive else 'random points of the envelope'
    return [f'answers {report["answered"]:.2%} of {report["points"]} {where}; '
            f'{report["gaps"]:.2%} of the envelope without a cell, '
            f'{report["overlap"]:.2%} in more than one',
            f'worst error {report["worst_error"]:.2g} of the tolerance and '
            f'{report["wrong_verdicts"]} wrong verdicts at {report["solved"]} full solutions']


def model_table_lines(model: BrakeModel, name: str) -> Iterator[str]:
    """Yield the lines on the table that the monitor uses for a model."""
    path = find_table_file(model)
    if path is None:
        yield f'table            none; build one with `squeal tabulate {name}`'
    else:
        yield from table_lines(path)


def _number(value: object) -> str:
    return f'{value:.3g}' if isinstance(value, int | float) else printable(value)


def _mapping(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}

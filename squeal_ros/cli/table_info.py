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

"""Output of `squeal info` for a table and for a growth emulator."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
import math
from pathlib import Path
import textwrap
from typing import Any

from squeal_core.common.errors import printable
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.emulator_file import find_emulator, read_emulator_header
from squeal_core.risk.growth_emulator import INPUTS, STABLE
from squeal_core.surrogate.table_file import find_table, read_table_header


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
    result = find_table(model)
    if result is None:
        yield f'table            none; build one with `squeal tabulate {name}`'
    else:
        yield from table_lines(result[0])


def emulator_lines(path: str | Path, contact_area: float = math.nan) -> Iterator[str]:
    """Yield the lines that describe the file of a growth emulator; area of its contact [m^2]."""
    header = read_emulator_header(path)
    yield f'growth emulator  {path}, {Path(path).stat().st_size / 1e6:.2f} MB'
    yield f'model            {printable(header.get("model"))}'
    yield f'written by       squeal_ros {printable(header.get("version"))}'
    for name, low, high in zip(INPUTS, header['low'], header['high'], strict=True):
        plain, ends = name.removeprefix('ln_'), (low, high)
        if plain != name:
            ends = math.exp(low), math.exp(high)
        unit = {'rotor_speed': ' rad/s', 'contact_pressure': ' Pa', 'friction': ''}.get(
            plain, " times the model's")
        title = plain.replace('_', ' ').removeprefix('contact ')
        yield f'{title:16} {ends[0]:.3g} to {ends[1]:.3g}{unit}'
    steepest = header.get('steepest')
    if isinstance(steepest, float):
        yield ('limit            preload x friction / rotor speed up to '
               f'{steepest * contact_area:.4g} N s' if contact_area > 0.0 else
               f'limit            pressure x friction / rotor speed up to {steepest:.4g} Pa s')
    families = header.get('families')
    listed = [_mapping(item) for item in families] if isinstance(families, list) else []
    pitches = [_number(item.get('frequency_hz'), '.0f') for item in listed]
    yield _filled('families, Hz', (pitch + len(item.get('numbers', ())[1:]) * ' (2)'
                                   for pitch, item in zip(pitches, listed, strict=True)))
    yield _filled('never grow, Hz', (
        f'{pitch} (at most {item["largest_growth"]:.1f} 1/s)'
        for pitch, item in zip(pitches, listed, strict=True)
        if isinstance(item.get('largest_growth'), float) and item['largest_growth'] <= STABLE))
    yield from _piece_lines(header, pitches)
    error = _mapping(header.get('error'))
    yield (f'error            {_number(error.get("rms"))} 1/s rms, '
           f'{_number(error.get("largest"))} 1/s at most, by '
           f'{printable(error.get("points"))} full solutions')


def _piece_lines(header: Mapping[str, Any], pitches: Sequence[str]) -> Iterator[str]:
    """Yield a line a piece of contact stiffness, with the families that cross in it."""
    common = header.get('common')
    matrices = [_mapping(item) for item in common] if isinstance(common, list) else []
    for piece, ends in enumerate(pairwise(header['piece_ends'])):
        places = [item['families'] for item in matrices if item.get('piece') == piece
                  and isinstance(item.get('families'), list)]
        yield _filled(f'piece {piece + 1} of {header["pieces"]}', [
            f'contact stiffness {ends[0]:.3g} to {ends[1]:.3g} N/m^3',
            *(' + '.join(pitches[i] for i in own if i in range(len(pitches))) + ' Hz cross'
              for own in places)])


def _filled(title: str, items: Iterable[str]) -> str:
    return textwrap.fill(f'{title:16} ' + (', '.join(items) or 'none'), 99,
                         subsequent_indent=17 * ' ')


def model_emulator_lines(model: BrakeModel, name: str) -> Iterator[str]:
    """Yield the lines on the growth emulator that the monitor uses for a model."""
    result = find_emulator(model)
    if result is None:
        yield f'growth emulator  none; build one with `squeal tabulate {name} --growth-only`'
    else:
        yield from emulator_lines(result[0], model.contact_area)


def _number(value: object, form: str = '.3g') -> str:
    return format(value, form) if isinstance(value, int | float) else printable(value)


def _mapping(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}

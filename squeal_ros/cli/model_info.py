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

"""Output of `squeal info` for a model file, whatever its provenance holds."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
import textwrap
from typing import Any

import numpy as np
from squeal_core.common.errors import printable
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.matrix_names import OPERATORS

_MOST_LINES = 50  # of one group; a description of our own has a dozen
_WIDTH = 99


def model_lines(header: Mapping[str, Any], model: BrakeModel, name: str) -> Iterator[str]:
    """Yield the lines that describe a model; `name` stands for one that its file does not name."""
    provenance = _mapping(header.get('provenance'))
    yield f'model            {printable(provenance.get("brake", name))}'
    yield f'modes            {model.size}, {int(model.free_coordinates.sum())} without stiffness'
    yield (f'contact          area {model.contact_area * 1e4:.2f} cm^2, mean radius '
           f'{model.contact_radius * 1e3:.1f} mm, stiffness '
           f'{model.nominal_contact_stiffness:.3g} N/m^3{_by_table(model)}')
    if time := model.contact_retardation_time:
        yield (f'contact damping  loss factor {2e3 * np.pi * time:.3g} at 1 kHz, in proportion to '
               'frequency')
    yield f'arrays           {", ".join(n for n in OPERATORS if getattr(model, n) is not None)}'
    yield f'schema           {header.get("schema")}'
    yield f'hash             {printable(header.get("hash"))}'
    for word in ('fitted', 'assumed'):  # what the model's source does not print
        keys = [printable(key) for key, source in _items(provenance.get('sources'))
                if isinstance(source, str) and source.startswith(word)]
        if keys:
            yield textwrap.fill(f'{word:16} {", ".join(keys)}', _WIDTH, subsequent_indent=17 * ' ')
    for group in ('settings', 'software'):
        yield from _limited(f'{printable(key):16} {printable(value)}'
                            for key, value in _mapping(provenance.get(group)).items())
    checks = provenance.get('audit')
    yield from _limited(map(_check_line, checks if isinstance(checks, list | tuple) else ()))
    yield 'component modes  Hz'
    frequencies = model.angular_frequencies / 2.0 / np.pi
    for mode, frequency in zip(model.names, frequencies, strict=False):
        yield f'  {printable(mode):22} {frequency:10.2f}'


def _check_line(check: object) -> str:
    result = _mapping(check)
    verdict = 'ok' if result.get('passed') is True else 'WARNING'
    return (f'audit            {verdict:8}{printable(result.get("name", "unnamed")):36} '
            f'{_number(result.get("value"), "9.2e"):>9}  '
            f'limit {_number(result.get("limit"), "g")}')


def _number(value: object, form: str) -> str:
    if isinstance(value, float) or (type(value) is int and abs(value) < 10**300):
        return format(value, form)
    return printable(value)


def _mapping(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _items(value: object) -> list[tuple[str, Any]]:
    return list(islice(_mapping(value).items(), _MOST_LINES))


def _limited(lines: Iterable[str]) -> Iterator[str]:
    for count, line in enumerate(lines):
        if count == _MOST_LINES:
            yield f'...              more than {_MOST_LINES}; `--json` prints them all'
            return
        yield line


def _by_table(model: BrakeModel) -> str:
    """Return the range of a contact stiffness table, in words; empty without a table."""
    table = model.stiffness_table
    return '' if table is None else (
        f', by table {table.stiffness[0]:.3g} to {table.stiffness[-1]:.3g} N/m^3 over '
        f'{table.pressure[0] / 1e5:g} to {table.pressure[-1] / 1e5:g} bar of contact pressure')

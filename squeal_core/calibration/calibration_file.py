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

"""The calibration file: a small YAML of an ensemble of brakes, and its origin."""

from collections.abc import Iterator, Mapping
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.checks import check_number
from squeal_core.common.errors import did_you_mean, LocatedError, short_repr, SquealError
from squeal_core.common.npz_archive import content_hash
from squeal_core.common.output import output_file
from squeal_core.common.yaml_reader import read_yaml
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.emulator_records import EmulatorDomain
from squeal_core.risk.ensemble import Ensemble, MEMBERS
from squeal_core.risk.growth_emulator import INPUTS
from squeal_core.surrogate.table_file import model_hash

FORMAT = 'squeal_ros calibration'
SCHEMA = 2
_MAX_MEMBERS = 4096
_DIGITS = 6
_WEIGHT_DIGITS = 12  # that their sum is 1
_SUM_TOLERANCE = 1e-6
_LEAST_INSIDE = 0.5  # weight inside the emulator's domain, as the risk wants it
_AGAIN = 'write it again with `squeal calibrate`'
_SCATTERS = ('friction_scatter', 'damping_scatter')
_NUMBERS = (*_SCATTERS, 'likelihood_power')
_RANGES = {'ln_damping': (-2.0, 2.0), 'ln_contact_stiffness': (-2.0, 2.0),
           'friction_bias': (-0.5, 0.5), 'slope_scale': (0.0, 10.0),
           'audible_build_up': (0.0, 50.0), 'friction_scatter': (0.0, 0.5),
           'damping_scatter': (0.0, 2.0), 'likelihood_power': (0.0, 1.0), 'weight': (0.0, 1.0)}


class CalibrationFileError(LocatedError):
    """A calibration file that cannot be read, written or used with a model."""


def write_calibration(ensemble: Ensemble, model: BrakeModel, path: str | Path,
                      about: Mapping[str, Any] | None = None, *, overwrite: bool = True) -> None:
    """
    Write a calibrated ensemble.

    Parameters
    ----------
    ensemble : Ensemble
        With `calibrated` in words, or a `likelihood_power` of 0: no measured squeal counted.
    model : BrakeModel
        That it was calibrated with.
    path : path
        An existing file is replaced only by a whole one.
    about : mapping, optional
        Provenance, prior against posterior, scores: plain data, for readers of the file.
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    SquealError
        For an ensemble that is not calibrated.
    OutputError
        Where the file cannot be written.

    """
    if not ensemble.calibrated and ensemble.likelihood_power:
        raise SquealError('calibrated: is empty; say by what the ensemble was calibrated')
    columns = [*MEMBERS, 'weight']
    rows = np.column_stack([*(getattr(ensemble, name) for name in MEMBERS), ensemble.weights])
    texts = [[*(f'{value:.{_DIGITS}g}' for value in row), f'{weight:.{_WEIGHT_DIGITS}g}']
             for *row, weight in rows.tolist()]
    stated = {'calibrated': ' '.join(ensemble.calibrated.split()), 'model': model_hash(model),
              **{name: _rounded(getattr(ensemble, name)) for name in _NUMBERS}}
    content = {
        'format': FORMAT, 'schema': SCHEMA, **stated, **(about or {}), 'columns': columns,
        'member_count': len(texts), 'hash': _hash(stated, np.array(texts, float))}
    lines = ['# by `squeal calibrate`; the setting `calibration` names this file; it holds for',
             '# every brake of the model, whichever were listened to',
             *_lines(content), 'members:', *(f'- [{", ".join(row)}]' for row in texts)]
    with output_file(path, overwrite=overwrite) as partial:
        partial.write_text('\n'.join(lines) + '\n', encoding='utf-8')


def _hash(stated: Mapping[str, Any], rows: FloatArray) -> str:
    """Return a short hash of what is read; minus zero, which YAML does not keep, is zero."""
    return content_hash(stated, {'members': rows + 0.0})[:16]


def _lines(content: Mapping[str, Any], indent: str = '') -> Iterator[str]:
    """Yield plain data as YAML: JSON inside a line, as YAML takes it."""
    for key, value in content.items():
        if isinstance(value, Mapping):
            yield f'{indent}{key}:'
            yield from _lines(value, f'{indent}  ')
        else:
            yield f'{indent}{key}: {_text(value)}'


def _text(value: Any) -> str:
    if isinstance(value, float) and not math.isfinite(value):
        return '.nan'
    if isinstance(value, list | tuple):
        return f'[{", ".join(map(_text, value))}]'
    return json.dumps(_rounded(value) if isinstance(value, float) else value, ensure_ascii=False)


def read_calibration(path: str | Path, model: BrakeModel) -> Ensemble:
    """
    Read the calibrated ensemble of a model.

    Raises
    ------
    CalibrationFileError
        One line: which file, which key and value, and what to do.

    """
    content = read_yaml(path, CalibrationFileError)
    if not isinstance(content, Mapping) or content.get('format') != FORMAT:
        raise CalibrationFileError(path, 'is no calibration file', _AGAIN)
    if content.get('schema') != SCHEMA:
        raise CalibrationFileError(path, f'schema is {short_repr(content.get("schema"))}, and '
                                   f'this version reads {SCHEMA}', _AGAIN)
    if content.get('model') != model_hash(model):
        raise CalibrationFileError(path, 'is the calibration of another model',
                                   'calibrate this model with `squeal calibrate`')
    numbers = {name: _number(path, name, name, content.get(name)) for name in _NUMBERS}
    calibrated = content.get('calibrated')
    if not isinstance(calibrated, str) or bool(calibrated.strip()) != (
            numbers['likelihood_power'] > 0.0):
        raise CalibrationFileError(f'{path}: calibrated', f'is {short_repr(calibrated)} at '
                                   f'likelihood_power {numbers["likelihood_power"]:g}', _AGAIN)
    rows = _rows(path, content)
    stated = {'calibrated': ' '.join(calibrated.split()), 'model': content['model'], **numbers}
    if content.get('hash') != _hash(stated, rows):
        raise CalibrationFileError(f'{path}: hash', f'is {short_repr(content.get("hash"))}, which '
                                   'does not match the contents: they were altered', _AGAIN)
    friction, damping, power = numbers.values()
    ln_damping, stiffness, bias, slope, audible, weights = rows.T
    return Ensemble(ln_damping, stiffness, bias, slope, audible, weights, friction, damping,
                    stated['calibrated'], power)


def check_domain(path: str | Path, ensemble: Ensemble, domain: EmulatorDomain) -> None:
    """
    Refuse a calibration most of whose members the growth emulator does not know.

    Raises
    ------
    CalibrationFileError
        With the quantity, its range in the file, and the domain.

    """
    for i, name in enumerate(INPUTS):
        if name in MEMBERS:
            values, low, high = getattr(ensemble, name), domain.low[i], domain.high[i]
            inside = (values >= low) & (values <= high)
            if ensemble.weights @ inside < _LEAST_INSIDE:
                raise CalibrationFileError(
                    f'{path}: members', f'have {name} from {values.min():g} to {values.max():g}, '
                    f'and the growth emulator knows {low:g} to {high:g}', 'calibrate with this '
                    'emulator, or name the one of the calibration')


def _rows(path: str | Path, content: Mapping[str, Any]) -> FloatArray:
    columns, rows = content.get('columns'), content.get('members')
    wanted = [*MEMBERS, 'weight']
    if columns != wanted:
        near = did_you_mean(columns[0], wanted) if isinstance(columns, list) and columns else ''
        raise CalibrationFileError(f'{path}: columns', f'are {short_repr(columns)}{near}',
                                   f'write {", ".join(wanted)}')
    if not isinstance(rows, list) or not 1 <= len(rows) <= _MAX_MEMBERS:
        raise CalibrationFileError(f'{path}: members', f'are {short_repr(rows)}',
                                   f'write a list of 1 to {_MAX_MEMBERS}')
    result = np.array([_row(path, i, row, wanted) for i, row in enumerate(rows)])
    count, total = content.get('member_count'), float(result[:, -1].sum())
    if count != len(rows):
        raise CalibrationFileError(f'{path}: members', f'are {len(rows)}, and member_count is '
                                   f'{short_repr(count)}: the file was cut or altered', _AGAIN)
    if abs(total - 1.0) > _SUM_TOLERANCE:
        raise CalibrationFileError(f'{path}: members', f'have weights of sum {total:.7g}, and it '
                                   'should be 1', _AGAIN)
    return result


def _row(path: str | Path, number: int, row: Any, columns: list[str]) -> list[float]:
    where = f'members[{number}]'
    if not isinstance(row, list) or len(row) != len(columns):
        raise CalibrationFileError(f'{path}: {where}', f'is {short_repr(row)}',
                                   f'write {len(columns)} numbers')
    return [_number(path, f'{where}.{name}', name, value)
            for name, value in zip(columns, row, strict=True)]


def _number(path: str | Path, where: str, name: str, value: Any) -> float:
    low, high = _RANGES[name]
    try:
        if isinstance(value, str):  # a number in quotes
            value = float(value)
        check_number(where, value, least=low, most=high)
    except (SquealError, ValueError):
        raise CalibrationFileError(f'{path}: {where}', f'is {short_repr(value)}',
                                   f'write a number from {low:g} to {high:g}') from None
    return float(value)


def _rounded(value: float) -> float:
    return float(f'{value:.{_DIGITS}g}')

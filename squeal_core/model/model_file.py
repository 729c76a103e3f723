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
The model file: a .npz of plain arrays and a JSON header; never a pickle.

The header holds schema version, units, provenance, scalars and a SHA-256 over all contents. A
file that is truncated, altered, of a future schema or not finite is refused in one line.
"""

from collections.abc import Callable, Mapping
import dataclasses
from pathlib import Path
from typing import Any, TypeVar

from squeal_core.brake.dimensions import Caliper, StiffnessTable
from squeal_core.brake.friction import FrictionLaw, FrictionTable
from squeal_core.common import resources
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import did_you_mean, ModelFileError, short_repr, SquealError
from squeal_core.common.npz_archive import ArchiveKind, Arrays, Header, read_archive, write_archive
from squeal_core.model.matrix_names import MAX_MODES, OPERATORS, SUPPORTS
from squeal_core.model.surface_shapes import SurfaceShapes

Model = TypeVar('Model')

FORMAT = 'squeal_ros brake model'
SCHEMA = 3  # with contact damping; 2 with a stiffness table and 1 with neither

UNITS = {
    'angular_frequencies': 'rad/s', 'damping_ratios': '-', 'gyroscopic': '-',
    'contact_stiffness': 'm^2/kg', 'friction_couple': 'm^2/kg', 'radial_dissipation': 'm/kg',
    'negative_slope': 'm^2/kg', 'follower': 'm/kg', 'support_stiffness': '1/s^2',
    'support_damping': '1/s', 'contact_area': 'm^2', 'contact_radius': 'm',
    'nominal_contact_stiffness': 'N/m^3', 'piston_area': 'm^2', 'temperature': 'K',
    'surface_points': 'm', 'surface_shapes': 'kg^-1/2',
}
_ARRAYS = ('angular_frequencies', 'damping_ratios', *OPERATORS, *SUPPORTS)
_SURFACE = ('surface_points', 'surface_shapes')
_RECORDS = ('caliper', 'friction_law', 'friction_table')
_SCALARS = ('contact_area', 'contact_radius', 'nominal_contact_stiffness')

KIND = ArchiveKind(
    noun='model file', contents='model', format=FORMAT, schemas=range(1, SCHEMA + 1),
    error=ModelFileError,
    again='copy it again or build it with `squeal build`',
    renew='update squeal_ros or build the model again',
    missing=lambda path: 'give the path of a model file or the name of a shipped model '
    f'({", ".join(shipped := resources.names("models", ".npz"))}){did_you_mean(path, shipped)}',
    most_bytes=8 * MAX_MODES**2)
_WANTED = {'angular_frequencies': '<f8', **{
    f'{name}?': '<f8' for name in (*_ARRAYS[1:], *_SURFACE)}}


def write_model(model: Mapping[str, Any], path: str | Path, *, overwrite: bool = True) -> None:
    """
    Write a model by its attributes; an existing file is replaced, if it may be, by a whole one.

    Raises
    ------
    ModelFileError
        For a provenance that no file can hold.
    OutputError
        Where the file cannot be written.

    """
    arrays = {name: model[name] for name in _ARRAYS if model[name] is not None}
    surface: SurfaceShapes | None = model['surface']
    if surface:
        arrays.update(surface_points=surface.points, surface_shapes=surface.shapes)
    header: Header = {
        'schema': 1, 'units': UNITS, 'names': list(model['names']),
        'provenance': model['provenance'], **{name: model[name] for name in _SCALARS},
        **{name: dataclasses.asdict(model[name]) if model[name] else None for name in _RECORDS},
        **({'surface': surface.header()} if surface else {})}
    if model['stiffness_table']:
        # a reader of schema 1 would pass over it and answer for another brake
        header.update(schema=2, stiffness_table=dataclasses.asdict(model['stiffness_table']))
    if model['contact_retardation_time']:
        header.update(schema=3, contact_retardation_time=model['contact_retardation_time'],
                      units={**UNITS, 'contact_retardation_time': 's'})
    write_archive(path, KIND, header, arrays, overwrite=overwrite)


def read_model(path: str | Path, make: Callable[..., Model]) -> tuple[Header, Model]:
    """
    Return the header of a model's file and the model, made of its attributes.

    Parameters
    ----------
    path : path
        Of a file, or the name of a shipped model.
    make : callable
        `BrakeModel`.

    Raises
    ------
    ModelFileError
        One line: which file, what is wrong with it, and what to do.

    """
    path = resources.find('models', str(path), '.npz')
    if path.suffix.lower() in ('.yaml', '.yml') and path.exists():
        raise ModelFileError(path, 'is a description and no model file', 'build its model with '
                             f'`squeal build {path} -o {path.stem}.npz` and give that')
    header, arrays = _read(path)
    try:
        return header, make(**_attributes(header, arrays))
    except (SquealError, KeyError, TypeError, ValueError, OverflowError) as error:
        raise ModelFileError(path, f'holds no usable model ({error})', KIND.again) from None


def _read(path: Path) -> tuple[Header, Arrays]:
    return read_archive(path, KIND, lambda _: _WANTED, _check_shapes)


def _check_shapes(_: Header, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse arrays that are not of one number of modes, before they are read."""
    size = shapes['angular_frequencies']
    if len(size) != 1 or not 1 <= size[0] <= MAX_MODES:
        raise SquealError(f'angular_frequencies: shape {short_repr(size)}')
    for name, shape in shapes.items():
        right = (name in _SURFACE or (name == 'damping_ratios' and shape == size)
                 or shape == (size * 2 if name in (*OPERATORS, *SUPPORTS) else size))
        if not right:
            raise SquealError(f'{name}: shape {short_repr(shape)} with {size[0]} modes')


def _attributes(header: Mapping[str, Any], arrays: Mapping[str, FloatArray]) -> dict[str, Any]:
    table, names = header['friction_table'], header['names']
    stiffness = header.get('stiffness_table')
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise SquealError(f'names are {short_repr(names)}; give a list of texts')
    return {
        **{name: arrays[name] for name in _ARRAYS if name in arrays},
        **{name: header[name] for name in _SCALARS},
        'stiffness_table': StiffnessTable(**stiffness) if stiffness else None,
        'contact_retardation_time': header.get('contact_retardation_time', 0.0),
        'caliper': Caliper(**header['caliper']) if header['caliper'] else None,
        'friction_law': FrictionLaw(**header['friction_law']) if header['friction_law'] else None,
        'friction_table': FrictionTable(**table) if table else None,
        'names': tuple(names), 'provenance': dict(header['provenance']),
        'surface': SurfaceShapes.read(header.get('surface'), arrays)}

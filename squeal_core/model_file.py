"""The model file: a .npz of plain arrays and a JSON header; never a pickle.

The header holds schema version, units, provenance, scalars and a SHA-256 over all contents. A
file that is truncated, altered, of a future schema or not finite is refused in one line.
"""

from collections.abc import Mapping
import dataclasses
import hashlib
import json
import math
import os
from pathlib import Path
from typing import Any
import zipfile

import numpy as np

from squeal_core import resources
from squeal_core.arrays import FloatArray
from squeal_core.brake import Caliper, StiffnessTable
from squeal_core.brake_model import BrakeModel, MAX_MODES, OPERATORS, SUPPORTS
from squeal_core.errors import did_you_mean, ModelFileError, quoted, SquealError
from squeal_core.friction import FrictionLaw, FrictionTable
from squeal_core.surface import SurfaceShapes

FORMAT = 'squeal_ros brake model'
SCHEMA = 2  # of files with a stiffness table; without one they are of schema 1
MAX_BYTES = 8 * MAX_MODES**2  # of one array

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
_SCALARS = ('contact_area', 'contact_radius', 'nominal_contact_stiffness')


def save_model(model: BrakeModel, path: str | Path) -> None:
    """Write a model; an existing file is replaced only by a whole one."""
    path = Path(path)
    arrays = {name: getattr(model, name) for name in _ARRAYS if getattr(model, name) is not None}
    if model.surface:
        arrays.update(surface_points=model.surface.points, surface_shapes=model.surface.shapes)
    header: dict[str, Any] = {
        'format': FORMAT, 'schema': 1, 'units': UNITS, 'names': list(model.names),
        'provenance': model.provenance, **{name: getattr(model, name) for name in _SCALARS},
        'caliper': dataclasses.asdict(model.caliper) if model.caliper else None,
        'friction_law': dataclasses.asdict(model.friction_law) if model.friction_law else None,
        'friction_table': dataclasses.asdict(model.friction_table)
        if model.friction_table else None,
        **({'surface': model.surface.header()} if model.surface else {})}
    if model.stiffness_table:
        # a reader of schema 1 would pass over it and answer for another brake
        header.update(schema=2, stiffness_table=dataclasses.asdict(model.stiffness_table))
    try:
        header['hash'] = content_hash(header, arrays)
    except TypeError as error:
        raise ModelFileError(path, f'cannot hold this provenance ({error})',
                             'give texts, numbers, lists and mappings') from None
    partial = path.with_name(f'{path.name}.{os.getpid()}.part')
    try:
        with partial.open('wb') as file:
            np.savez_compressed(file, header=np.array(json.dumps(header)), **arrays)
        partial.replace(path)
    except OSError as error:
        raise ModelFileError(path, f'cannot be written ({error.strerror})',
                             'check folder and rights') from None
    finally:
        partial.unlink(missing_ok=True)


def load_model(path: str | Path) -> BrakeModel:
    """Read a model by path, or by the name of a shipped one.

    Raises
    ------
    ModelFileError
        One line: which file, what is wrong with it, and what to do.
    """
    path = resources.find('models', str(path), '.npz')
    header, arrays = _read(path)
    try:
        return _model(header, arrays)
    except (SquealError, KeyError, TypeError, ValueError, OverflowError) as error:
        raise ModelFileError(path, f'holds no usable model ({error})', _BUILD_AGAIN) from None


def read_header(path: str | Path) -> dict[str, Any]:
    """Return the header of a model file, checked against its contents."""
    return _read(resources.find('models', str(path), '.npz'))[0]


def content_hash(header: Mapping[str, Any], arrays: Mapping[str, FloatArray]) -> str:
    """Return SHA-256 over the header without its hash, and over every array."""
    digest = hashlib.sha256()
    plain = {key: value for key, value in header.items() if key != 'hash'}
    digest.update(json.dumps(plain, sort_keys=True).encode())
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name], dtype='<f8')
        digest.update(f'{name}{array.shape}'.encode() + array.tobytes())
    return digest.hexdigest()


_BUILD_AGAIN = 'copy it again or build it with `squeal build`'


def _read(path: Path) -> tuple[dict[str, Any], dict[str, FloatArray]]:
    try:
        with zipfile.ZipFile(path) as archive:
            header = json.loads(str(_read_array(path, archive, 'header', 'U')))
            _check_header(path, header)
            there = {name.removesuffix('.npy') for name in archive.namelist()}
            arrays = {name: _read_array(path, archive, name, 'f')
                      for name in (*_ARRAYS, *_SURFACE) if name in there}
    except FileNotFoundError:
        raise ModelFileError(
            path, 'does not exist', 'give the path of a model file or the name of a shipped '
            f'model ({", ".join(shipped := resources.names("models", ".npz"))})'
            f'{did_you_mean(path, shipped)}') from None
    except OSError as error:
        raise ModelFileError(path, f'cannot be read ({error.strerror})',
                             'check path and rights') from None
    except ModelFileError:
        raise
    except Exception as error:  # whatever a damaged archive makes zipfile, zlib or numpy say
        raise ModelFileError(
            path, f'is damaged or no model file ({type(error).__name__}: {str(error)[:120]})',
            _BUILD_AGAIN) from None
    if content_hash(header, arrays) != header['hash']:
        raise ModelFileError(path, 'was altered: its contents do not match its hash', _BUILD_AGAIN)
    return header, arrays


def _read_array(path: Path, archive: zipfile.ZipFile, name: str, kind: str) -> Any:
    """Read one array after its own header was checked: nothing large is allocated unchecked."""
    if f'{name}.npy' not in archive.namelist():
        raise ModelFileError(path, f'has no {name}, so it is no model file', _BUILD_AGAIN)
    with archive.open(f'{name}.npy') as file:
        version = np.lib.format.read_magic(file)
        read = (np.lib.format.read_array_header_1_0 if version == (1, 0)
                else np.lib.format.read_array_header_2_0)
        shape, _, dtype = read(file)
    size = math.prod(shape) * dtype.itemsize
    if dtype.kind != kind or (kind == 'f' and dtype.itemsize != 8) or size > MAX_BYTES:
        raise ModelFileError(path, f'{name} is an array of {dtype} and {size / 1e6:.1f} MB',
                             f'a model has at most {MAX_MODES} modes in double precision')
    with archive.open(f'{name}.npy') as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def _check_header(path: Path, header: Any) -> None:
    if not isinstance(header, dict) or header.get('format') != FORMAT:
        raise ModelFileError(path, 'is not a brake model', _BUILD_AGAIN)
    schema = header.get('schema')
    if type(schema) is not int or not 1 <= schema <= SCHEMA:
        raise ModelFileError(
            path, f'has schema {quoted(schema)}; this version reads up to {SCHEMA}',
            'update squeal_ros or build the model again')
    if not isinstance(header.get('hash'), str):
        raise ModelFileError(path, 'has no hash', _BUILD_AGAIN)


def _model(header: Mapping[str, Any], arrays: Mapping[str, FloatArray]) -> BrakeModel:
    table, names = header['friction_table'], header['names']
    stiffness = header.get('stiffness_table')
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise SquealError(f'names are {quoted(names)}; give a list of texts')
    return BrakeModel(
        **dict[str, Any]({name: arrays[name] for name in _ARRAYS if name in arrays}),
        **{name: header[name] for name in _SCALARS},
        stiffness_table=StiffnessTable(**stiffness) if stiffness else None,
        caliper=Caliper(**header['caliper']) if header['caliper'] else None,
        friction_law=FrictionLaw(**header['friction_law']) if header['friction_law'] else None,
        friction_table=FrictionTable(**table) if table else None,
        names=tuple(names), provenance=dict(header['provenance']),
        surface=SurfaceShapes.read(header.get('surface'), arrays))

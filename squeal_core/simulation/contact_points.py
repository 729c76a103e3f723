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
Contact points: relative mode shapes at the points at which a transient evaluates the contact.

A model file keeps integrals over the contact, from which no contact can open. The shapes under
them are computed again from the brake description that the model keeps, turned to the signs and
doublets of the model, compared with its integrals, and kept in the user's cache.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.assembly.build import contact_arrays, sample_contact
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.brake.dimensions import Brake
from squeal_core.common import resources
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import LocatedError, ModelError, SquealError
from squeal_core.common.npz_archive import ArchiveKind, content_hash, read_archive, write_archive
from squeal_core.common.output import make_folder, OutputError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.operators import ContactFace
from squeal_core.model.surface_shapes import SurfaceShapes

PANELS, POINTS = (1, 2), 8  # 128 a face: growth rates of kang2009 within 0.02 1/s of its model's
_ARRAYS = ('normal', 'tangential', 'radial', 'spin', 'radius', 'weight')
_MOST_DIFFERENCE = 0.05  # of an integral's norm; other modes differ by far more
_DOUBLET = 1e-6  # relative gap of frequencies


class ContactPointsError(LocatedError):
    """A cached file of contact points that cannot be read."""


_KIND = ArchiveKind(
    noun='file of contact points', contents='contact points', format='squeal_ros contact points',
    schemas=range(1, 2), error=ContactPointsError, again='remove it', renew='remove it',
    missing=lambda _: 'it is computed at need')


def contact_points(model: BrakeModel, brake: Brake | None = None, *,
                   panels: tuple[int, int] = PANELS, points: int = POINTS,
                   progress: Callable[[str], None] = lambda _: None
                   ) -> tuple[ContactFace, ContactFace]:
    """
    Return the top and the bottom contact face of a model, sampled at quadrature points.

    Parameters
    ----------
    model : BrakeModel
        Built by `build_model` or `squeal build`.
    brake : Brake, optional
        What the model was built from; None: the description that the model keeps.
    panels : (2,) ints
        Parts of the patch in r and theta, each with its own Gauss rule.
    points : int
        Gauss points of a part in each direction.
    progress : callable
        Told in a few words what is being done.

    Returns
    -------
    tuple of ContactFace
        Columns in the order and with the signs of the model's arrays.

    Raises
    ------
    ModelError
        For a model that keeps no description, or is not of this brake.
    ImportError
        Where the cache has none and scikit-fem is not installed.

    """
    path = _cached(model, panels, points)
    try:
        return _read(path, model.size)
    except SquealError:  # not there yet, or of no use
        pass
    progress('mode shapes at the contact')
    result, surface = sample_contact(brake or _described(model), panels=panels, points=points,
                                     **_settings(model))
    faces = _aligned(model, result, surface)
    _compare(model, faces)
    try:
        make_folder(path.parent)
        write_archive(path, _KIND, {'schema': 1}, {
            f'{side}_{name}': getattr(face, name) for side, face in enumerate(faces)
            for name in _ARRAYS})
    except OutputError:  # a cache that cannot be written costs time only
        pass
    return faces


def _cached(model: BrakeModel, panels: tuple[int, int], points: int) -> Path:
    names = ('angular_frequencies', 'contact_stiffness', 'friction_couple')
    arrays = {name: array for name in names if (array := getattr(model, name)) is not None}
    digest = content_hash({'panels': list(panels), 'points': points}, arrays)
    return resources.cache_folder() / f'contact_{digest[:16]}.npz'


def _read(path: Path, size: int) -> tuple[ContactFace, ContactFace]:
    arrays = read_archive(path, _KIND, lambda _: {
        f'{side}_{name}': '<f8' for side in (0, 1) for name in _ARRAYS})[1]
    faces = [ContactFace(**{name: arrays[f'{side}_{name}'] for name in _ARRAYS})
             for side in (0, 1)]
    if any(face.normal.shape != (size, face.weight.size) for face in faces):
        raise ContactPointsError(path, 'is of another model', 'remove it')
    return faces[0], faces[1]


def _described(model: BrakeModel) -> Brake:
    description = model.provenance.get('description')
    if not isinstance(description, Mapping):
        raise ModelError('this model keeps no brake description, so the shapes at its contact '
                         'are not known; give the brake description that it was built from, or '
                         'build the model with `squeal build`')
    return parse_brake(description, where='description of the model', warn=lambda _: None)


def _settings(model: BrakeModel) -> dict[str, Any]:
    """Return with which finite elements the model was built."""
    settings = model.provenance.get('settings', {})
    return {name: convert(settings[name]) for name, convert in (
        ('disc_order', int), ('pad_elements', tuple)) if name in settings}


def _aligned(model: BrakeModel, faces: tuple[ContactFace, ContactFace], surface: SurfaceShapes
             ) -> tuple[ContactFace, ContactFace]:
    """Turn shapes to the model's: an eigensolver leaves signs and a doublet's turn open."""
    if model.surface is None or model.surface.shapes.shape != surface.shapes.shape:
        return faces
    kept, solved = (s.shapes.reshape(-1, s.shapes.shape[2]).astype(float)
                    for s in (model.surface, surface))
    turn = np.zeros((model.size, model.size))
    for group in _groups(model.angular_frequencies, model.surface):
        left, _, right = np.linalg.svd(solved[:, group].T @ kept[:, group])
        turn[np.ix_(group, group)] = left @ right  # the orthogonal matrix nearest to it
    top, bottom = (replace(face, **{name: turn.T @ getattr(face, name)
                                    for name in _ARRAYS[:4]}) for face in faces)
    return top, bottom


def _groups(frequencies: FloatArray, surface: SurfaceShapes) -> list[list[int]]:
    """Return which modes of one component have one frequency."""
    patch = np.repeat(np.arange(len(surface.patches)), [p.size for p in surface.patches])
    moved = np.abs(surface.shapes).sum(axis=1)
    part = np.array([patch[row] for row in moved.argmax(axis=0)])
    groups = [[0]]
    for i in range(1, frequencies.size):
        same = part[i] == part[i - 1] and \
            frequencies[i] - frequencies[i - 1] <= _DOUBLET * frequencies[i]
        groups[-1].append(i) if same else groups.append([i])
    return groups


def _compare(model: BrakeModel, faces: tuple[ContactFace, ContactFace]) -> None:
    """Refuse shapes whose integrals are not the model's."""
    for name, result in contact_arrays(faces).items():
        wanted = getattr(model, name)
        fits = wanted is not None and wanted.shape == result.shape
        difference = np.linalg.norm(result - wanted) / np.linalg.norm(wanted) if fits else np.inf
        if not difference <= _MOST_DIFFERENCE:
            raise ModelError(
                f'{name}: differs by {difference:.3g} from that of the shapes of the brake '
                'description; give the description that the model was built from, or build the '
                'model again')

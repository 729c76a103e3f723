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

"""The modes that a model of K09's brake was built from, solved anew where shapes are needed."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from squeal_core.assembly.build import contact_arrays, contact_faces
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.brake.dimensions import Brake, HatDisc
from squeal_core.common.errors import short_repr, SquealError
from squeal_core.model import operators
from squeal_core.model.brake_model import BrakeModel
from squeal_core.modes.modal_basis import ModalBasis
from squeal_core.modes.planar_mesh import AS_PRINTED, contact_grid

_MOST_ELEMENTS = 200  # of a pad, each way


@dataclass(frozen=True, eq=False)
class Parts:
    """Modes of disc and pads, and the model whose coordinates are theirs, signs included."""

    brake: Brake
    disc: ModalBasis
    pads: tuple[ModalBasis, ModalBasis]
    faces: tuple[operators.ContactFace, ...]
    model: BrakeModel

    @cached_property
    def by_sums(self) -> BrakeModel:
        """Return the model with contact sums over 15 x 43 nodes, as K09 eq. (40) reads."""
        half = 0.5 * _hat(self.brake).rotor_thickness
        top, bottom = (contact_grid(self.brake.contact, z, AS_PRINTED) for z in (half, -half))
        first, second = self.pads
        return replace(self.model, **contact_arrays((  # type: ignore[arg-type]
            operators.top_face(first.sample(top), self.disc.sample(top), len(second.names)),
            operators.bottom_face(second.sample(bottom), self.disc.sample(bottom),
                                  len(first.names)))))


def parts_or_why(model: BrakeModel) -> tuple[Parts | None, tuple[str, ...]]:
    """Return the parts, or the omissions without them, and the reason."""
    try:
        return rebuild(model), ()
    except (ImportError, SquealError) as error:
        return None, (f'sums over nodes, follower force, mode shapes: {error}',)
    except (KeyError, TypeError, ValueError, AttributeError):  # a provenance of another make
        return None, ('sums over nodes, follower force, mode shapes: the model does not say how '
                      'it was built; build it from a description',)


def rebuild(model: BrakeModel) -> Parts:
    """Return the parts that a model of a hat disc was built from, solved anew (needs skfem)."""
    from squeal_core.modes.fe.axisymmetric import disc_modes
    from squeal_core.modes.fe.solid import pad_modes

    brake = parse_brake(model.provenance.get('description', {}), warn=lambda _: None)
    settings = model.provenance['settings']
    elements, half = tuple(settings['pad_elements']), 0.5 * _hat(brake).rotor_thickness
    if not all(type(count) is int and 1 <= count <= _MOST_ELEMENTS for count in elements):
        raise SquealError(f'pads of {short_repr(elements)} elements; build the model again')
    disc = disc_modes(_hat(brake), brake.disc_modes, order=settings['disc_order'])
    pad = pad_modes(brake.pad, brake.contact, brake.pad_modes, elements=elements)
    pads = replace(pad, offset=half), replace(pad, offset=-half - brake.pad.thickness)
    result = np.concatenate([part.angular_frequencies for part in (pads[0], disc, pads[1])])
    if result.shape != (model.size,) or not np.allclose(result, model.angular_frequencies, 1e-6):
        raise SquealError("modes solved anew are not the model's; build the model again")
    faces = contact_faces(brake, disc, pads, elements[:2], settings['contact_points'])
    gyroscopic = operators.gyroscopic(disc.volume_layers(), _hat(brake).material.density)
    return Parts(brake, disc, pads, faces, replace(
        model, gyroscopic=np.pad(gyroscopic, len(pad.names)),
        **contact_arrays(faces)))  # type: ignore[arg-type]


def _hat(brake: Brake) -> HatDisc:
    if not isinstance(brake.disc, HatDisc):
        raise SquealError(f'{brake.name}: its disc comes from a file; give a disc by dimensions')
    return brake.disc

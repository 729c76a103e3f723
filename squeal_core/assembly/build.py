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

"""Modal model of a brake from its description: modes, contact faces, arrays, audit."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import version
import platform
from typing import Any

import numpy as np
from squeal_core.assembly.checks import Check, model_checks, refuse_wrong
from squeal_core.assembly.parts import PartCache
from squeal_core.brake.damping import ComponentDamping
from squeal_core.brake.dimensions import Brake, Support
from squeal_core.common.arrays import FloatArray
from squeal_core.model import operators
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.surface_shapes import Patch, SurfaceShapes
from squeal_core.modes.modal_basis import ModalBasis, Quadrature, SampledShapes
from squeal_core.modes.planar_mesh import sector_quadrature


def build_model(brake: Brake, *, progress: Callable[[str], None] = lambda _: None,
                disc_order: int = 4, pad_elements: tuple[int, int, int] = (9, 18, 3),
                contact_points: int = 4, follower: bool = False,
                parts: PartCache | None = None, audit: bool = True) -> BrakeModel:
    """
    Return the modal brake model of a brake.

    Parameters
    ----------
    brake : Brake
        The brake that is described.
    progress : callable
        Told in a few words what is being done.
    disc_order : int
        Polynomial order of the disc's section elements.
    pad_elements : (3,) ints
        Elements of a pad in r, theta, z.
    contact_points : int
        Gauss points of the contact patch in each direction of a pad element.
    follower : bool
        Keep the in-plane follower force F0, which K09 leaves out of its results.
    parts : PartCache, optional
        Has the components of brakes that were built before.
    audit : bool
        Check the model, at half of the cost; variants of a checked brake can do without.

    Raises
    ------
    SquealError
        For modal results that cannot be read, or do not cover the contact.

    References
    ----------
    K09, appendix A: see `BrakeModel`.

    Examples
    --------
    A coarse model, in seconds:

    >>> from dataclasses import replace
    >>> from squeal_core import build_model, read_brake
    >>> from squeal_core.common.resources import config_folder
    >>> brake = read_brake(config_folder() / 'brakes' / 'kang2009.yaml')
    >>> brake = replace(brake, disc_modes=4, pad_modes=8)
    >>> build_model(brake, disc_order=2, pad_elements=(3, 6, 1)).size
    21

    """
    panels = (pad_elements[0], pad_elements[1])
    parts = parts or PartCache()
    progress('pad modes')
    pads = parts.pads(brake, pad_elements)
    progress('disc modes')
    disc = parts.disc(brake, disc_order)
    bases = (pads[0].basis, pads[1].basis)
    progress('contact and gyroscopic arrays')
    faces = contact_faces(brake, disc.basis, bases, panels, contact_points)
    model = _assembled(brake, disc.basis, parts.gyroscopic(disc), bases, faces, follower)
    checks: Sequence[Check] = ()
    if audit:
        progress('audit')
        checks = model_checks(
            model, disc.basis, _circle(brake),
            lambda: contact_arrays(contact_faces(brake, disc.basis, bases, panels,
                                                 contact_points + 2)),
            [(name, part.mac) for name, part in (('disc', disc), ('pad 1', pads[0]),
                                                 ('pad 2', pads[1])) if part.mac is not None])
        refuse_wrong(checks)
    return replace(model, provenance={
        **_provenance(brake, disc_order=disc_order, pad_elements=pad_elements,
                      contact_points=contact_points),
        'audit': [check.to_json() for check in checks]})


def build_settings(model: BrakeModel) -> dict[str, Any]:
    """Return the settings of `build_model` that a model was built with, as far as it has them."""
    result = model.provenance.get('settings')
    kept = result if isinstance(result, dict) else {}
    return {**{name: tuple(kept[name]) if isinstance(kept[name], list) else kept[name]
               for name in ('disc_order', 'pad_elements', 'contact_points') if name in kept},
            'follower': model.follower is not None}


def _assembled(brake: Brake, disc: ModalBasis, gyroscopic: FloatArray,
               pads: tuple[ModalBasis, ModalBasis], faces: tuple[operators.ContactFace, ...],
               follower: bool) -> BrakeModel:
    before, after = (len(pad.names) for pad in pads)
    frequencies = [part.angular_frequencies for part in (pads[0], disc, pads[1])]
    return BrakeModel(
        angular_frequencies=np.concatenate(frequencies),
        damping_ratios=damping_ratios(brake, frequencies),
        gyroscopic=np.pad(gyroscopic, ((before, after), (before, after))),
        **contact_arrays(faces),  # type: ignore[arg-type]
        follower=operators.follower(faces) if follower else None,
        support_stiffness=_supports(brake, pads, len(gyroscopic), 'stiffness'),
        support_damping=_supports(brake, pads, len(gyroscopic), 'damping'),
        contact_area=brake.contact.area, contact_radius=brake.contact.mean_radius,
        nominal_contact_stiffness=brake.contact.stiffness,
        stiffness_table=brake.contact.stiffness_table,
        contact_retardation_time=brake.contact.retardation_time, caliper=brake.caliper,
        friction_law=brake.friction_law, friction_table=brake.friction_table,
        names=(*(f'pad 1 {n}' for n in pads[0].names), *disc.names,
               *(f'pad 2 {n}' for n in pads[1].names)),
        surface=_surface(brake, disc, pads))


def damping_ratios(brake: Brake, frequencies: Sequence[FloatArray]) -> FloatArray | float:
    """Return xi of each mode, given the frequencies of pad 1, disc and pad 2 [rad/s]."""
    damping = brake.damping_ratio
    if not isinstance(damping, ComponentDamping):
        return damping
    tables = (damping.pads[0], damping.disc, damping.pads[1])
    return np.concatenate([table(own) for table, own in zip(tables, frequencies, strict=True)])


def _surface(brake: Brake, disc: ModalBasis,
             pads: tuple[ModalBasis, ModalBasis]) -> SurfaceShapes:
    """
    Return shapes for plots: of the ring that the pads sweep, and of the pads.

    They are taken on the contact faces, which every source of modes covers, just inside the
    edges; the pads' are drawn at their backs.
    """
    half, contact = 0.5 * brake.rotor_thickness, brake.contact

    def part(name: str, basis: ModalBasis, face: float, drawn: float,
             columns: int) -> tuple[Patch, SampledShapes, FloatArray]:
        inset = 0.02 * (contact.outer_radius - contact.inner_radius)
        ring = name == 'disc'
        angle = (2.0 * np.pi * np.arange(columns) / columns if ring
                 else 0.49 * contact.angle * np.linspace(-1.0, 1.0, columns))
        radius = np.linspace(contact.inner_radius + inset, contact.outer_radius - inset, 4)
        r, t = (grid.ravel() for grid in np.meshgrid(radius, angle, indexing='ij'))
        points = Quadrature(r, t, np.full_like(r, face), np.zeros_like(r))
        return Patch(name, 4, columns, ring), basis.sample(points), np.full_like(r, drawn)

    return SurfaceShapes.of([
        part('pad 1', pads[0], half, half + brake.pads[0].thickness, 12),
        part('disc', disc, half, half, 48),
        part('pad 2', pads[1], -half, -half - brake.pads[1].thickness, 12)])


def contact_arrays(faces: tuple[operators.ContactFace, ...]) -> dict[str, FloatArray]:
    """Return A0, B0, R0, S0 by the names a `BrakeModel` gives them."""
    return {name: getattr(operators, name)(faces) for name in (
        'contact_stiffness', 'friction_couple', 'radial_dissipation', 'negative_slope')}


def _circle(brake: Brake, count: int = 128) -> Quadrature:
    """Return points around the rotor's top face at the pads' mean radius."""
    angle = 2.0 * np.pi * np.arange(count) / count
    ones = np.ones(count)
    return Quadrature(brake.contact.mean_radius * ones, angle,
                      0.5 * brake.rotor_thickness * ones, ones)


def contact_faces(brake: Brake, disc: ModalBasis, pads: tuple[ModalBasis, ModalBasis],
                  panels: tuple[int, int], points: int) -> tuple[operators.ContactFace, ...]:
    """Return the top and the bottom face, sampled on a planar mesh that pads and disc share."""
    half = 0.5 * brake.rotor_thickness
    top, bottom = (sector_quadrature(brake.contact, z, panels=panels, points=points)
                   for z in (half, -half))
    first, second = pads
    return (operators.top_face(first.sample(top), disc.sample(top), len(second.names)),
            operators.bottom_face(second.sample(bottom), disc.sample(bottom), len(first.names)))


def sample_contact(brake: Brake, *, panels: tuple[int, int], points: int, disc_order: int = 4,
                   pad_elements: tuple[int, int, int] = (9, 18, 3)
                   ) -> tuple[tuple[operators.ContactFace, operators.ContactFace], SurfaceShapes]:
    """
    Return both contact faces at quadrature points, and surface shapes that identify modes.

    `panels` and `points` are those of the quadrature, the others those of `build_model`.
    """
    parts = PartCache()
    pads = parts.pads(brake, pad_elements)
    disc, bases = parts.disc(brake, disc_order), (pads[0].basis, pads[1].basis)
    faces = contact_faces(brake, disc.basis, bases, panels, points)
    return (faces[0], faces[1]), _surface(brake, disc.basis, bases)


def _supports(brake: Brake, pads: tuple[ModalBasis, ModalBasis], disc_modes: int,
              kind: str) -> FloatArray | None:
    """Return stiffness or damping of the supports of the pads, None where both are zero."""
    blocks = []
    half = 0.5 * brake.rotor_thickness
    for side, pad, basis, support in zip((1.0, -1.0), brake.pads, pads, brake.supports,
                                         strict=True):
        if support == Support():
            blocks.append(np.zeros((len(basis.names), len(basis.names))))
            continue
        back = basis.sample(sector_quadrature(brake.contact, side * (half + pad.thickness)))
        blocks.append(operators.support(back, *(
            getattr(support, f'{way}_{kind}') for way in ('radial', 'tangential', 'axial'))))
    if not any(np.any(block) for block in blocks):
        return None
    before, after = (len(block) for block in blocks)
    whole = np.zeros((before + disc_modes + after, before + disc_modes + after))
    whole[:before, :before] = blocks[0]
    whole[before + disc_modes:, before + disc_modes:] = blocks[1]
    return whole


def _provenance(brake: Brake, **settings: Any) -> dict[str, Any]:
    return {
        'brake': brake.name,
        'description': dict(brake.description),
        'sources': dict(brake.sources),
        'settings': {name: value if isinstance(value, int) else list(value)
                     for name, value in settings.items()},
        'software': {'python': platform.python_version(),
                     **{name: version(name) for name in ('numpy', 'scipy', 'scikit-fem')}},
    }

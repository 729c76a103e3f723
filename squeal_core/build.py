"""From a brake description to its modal model: modes, contact faces, six arrays."""

from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import version
import platform
from typing import Any

import numpy as np

from squeal_core import operators
from squeal_core.brake import Brake
from squeal_core.brake_model import BrakeModel
from squeal_core.planar_mesh import sector_quadrature


def build_model(brake: Brake, *, progress: Callable[[str], None] = lambda _: None,
                disc_order: int = 4, pad_elements: tuple[int, int, int] = (9, 18, 3),
                contact_points: int = 4, follower: bool = False) -> BrakeModel:
    """Return the modal brake model of a brake described by its dimensions.

    Parameters
    ----------
    brake : Brake
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
    """
    from squeal_core.fe.axisymmetric import disc_modes
    from squeal_core.fe.solid import pad_modes

    progress('disc modes')
    disc = disc_modes(brake.disc, brake.disc_modes, order=disc_order)
    progress('pad modes')
    pad = pad_modes(brake.pad, brake.contact, brake.pad_modes, elements=pad_elements)
    progress('contact and gyroscopic arrays')
    half = 0.5 * brake.disc.rotor_thickness
    pad1, pad2 = replace(pad, offset=half), replace(pad, offset=-half - brake.pad.thickness)
    top, bottom = (sector_quadrature(
        brake.contact, z, panels=pad_elements[:2], points=contact_points) for z in (half, -half))
    faces = (operators.top_face(pad1.sample(top), disc.sample(top), len(pad2.names)),
             operators.bottom_face(pad2.sample(bottom), disc.sample(bottom), len(pad1.names)))
    rim = len(pad.names)
    gyroscopic = np.pad(operators.gyroscopic(disc.volume_layers(), disc.density), rim)
    return BrakeModel(
        angular_frequencies=np.concatenate([
            pad1.angular_frequencies, disc.angular_frequencies, pad2.angular_frequencies]),
        damping_ratios=brake.damping_ratio, gyroscopic=gyroscopic,
        contact_stiffness=operators.contact_stiffness(faces),
        friction_couple=operators.friction_couple(faces),
        radial_dissipation=operators.radial_dissipation(faces),
        negative_slope=operators.negative_slope(faces),
        follower=operators.follower(faces) if follower else None,
        contact_area=brake.contact.area, contact_radius=brake.contact.mean_radius,
        nominal_contact_stiffness=brake.contact.stiffness, caliper=brake.caliper,
        friction_law=brake.friction_law, friction_table=brake.friction_table,
        names=(*(f'pad 1 {n}' for n in pad.names), *disc.names,
               *(f'pad 2 {n}' for n in pad.names)),
        provenance=_provenance(brake, disc_order=disc_order, pad_elements=pad_elements,
                               contact_points=contact_points))


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

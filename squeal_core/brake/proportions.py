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

"""Checks that the parts of a brake fit each other: errors and warnings."""

from functools import partial
import math

from squeal_core.brake.dimensions import Brake, Contact, HatDisc, Pad
from squeal_core.common.errors import BrakeDescriptionError
from squeal_core.common.ranges import check_ratio, Warn

_NONE = math.inf


def check_proportions(where: str, brake: Brake, warn: Warn) -> None:
    """
    Refuse proportions that no mesh can follow, and warn of unusual ones.

    Parameters
    ----------
    where : str
        Place of the description in texts.
    brake : Brake
        The brake that is described.
    warn : callable
        Told each warning.

    Raises
    ------
    BrakeDescriptionError

    """
    if isinstance(brake.disc, HatDisc):
        _check_disc(where, brake.disc, brake.contact, warn)
    _check_pads(where, brake, warn)
    _check_friction(where, brake, warn)
    _check_stiffness_table(where, brake.contact, warn)


def _check_disc(where: str, disc: HatDisc, contact: Contact, warn: Warn) -> None:
    check = partial(check_ratio, refuse=BrakeDescriptionError, warn=warn)
    gap = disc.hat_wall_inner_radius - disc.clamp_radius
    check(f'{where}.disc.clamp_radius',
          f'leaves {1e3 * gap:.4g} mm of the top plate free inside the hat wall, over its '
          f'thickness of {1e3 * disc.top_plate_thickness:.4g} mm', gap / disc.top_plate_thickness,
          possible=(0.1, _NONE), plausible=(0.8, 50.0), remedy='make the clamp smaller')
    wall = disc.hat_height - disc.top_plate_thickness
    check(f'{where}.disc.hat_height',
          f'leaves {1e3 * wall:.4g} mm of hat wall between rotor and top plate, over its '
          f'thickness of {1e3 * disc.hat_wall_thickness:.4g} mm', wall / disc.hat_wall_thickness,
          possible=(0.02, _NONE), plausible=(0.2, 30.0), remedy='check both heights')
    check(f'{where}.disc.rotor_thickness',
          f'is {1e3 * disc.rotor_thickness:.4g} mm over a radius of '
          f'{1e3 * disc.rotor_outer_radius:.4g} mm',
          disc.rotor_thickness / disc.rotor_outer_radius,
          possible=(3e-3, 2.0), plausible=(0.015, 0.4), remedy='check both')
    check(f'{where}.disc.hat_wall_thickness',
          f'is {1e3 * disc.hat_wall_thickness:.4g} mm over a radius of '
          f'{1e3 * disc.hat_wall_outer_radius:.4g} mm',
          disc.hat_wall_thickness / disc.hat_wall_outer_radius,
          possible=(2e-3, 1.0), plausible=(0.02, 0.45), remedy='check both')
    check(f'{where}.contact.outer_radius',
          f"is {1e3 * contact.outer_radius:.4g} mm over the rotor's outer radius of "
          f'{1e3 * disc.rotor_outer_radius:.4g} mm',
          contact.outer_radius / disc.rotor_outer_radius,
          possible=(0.05, 1.0), plausible=(0.75, 1.0), remedy='move the pads to the rim')


def _check_pads(where: str, brake: Brake, warn: Warn) -> None:
    check = partial(check_ratio, refuse=BrakeDescriptionError, warn=warn)
    contact = brake.contact
    width = contact.outer_radius - contact.inner_radius
    check(f'{where}.contact.outer_radius',
          f'leaves a patch {1e3 * width:.4g} mm wide at a radius of '
          f'{1e3 * contact.outer_radius:.4g} mm', width / contact.outer_radius,
          possible=(5e-3, 1.0), plausible=(0.08, 0.6), remedy='check both radii')
    names = ('pads', 'pads') if brake.pads[0] == brake.pads[1] else ('pads.top', 'pads.bottom')
    for name, pad in dict(zip(names, brake.pads, strict=True)).items():
        if isinstance(pad, Pad):
            check(f'{where}.{name}.thickness',
                  f'is {1e3 * pad.thickness:.4g} mm over a width of {1e3 * width:.4g} mm',
                  pad.thickness / width, possible=(5e-3, 20.0), plausible=(0.03, 1.5),
                  remedy='check thickness and radii')
    check(f'{where}.caliper.piston_diameter',
          f'gives a piston area of {1e4 * brake.caliper.piston_area:.4g} cm^2 over a pad area of '
          f'{1e4 * contact.area:.4g} cm^2', brake.caliper.piston_area / contact.area,
          possible=(1e-3, 50.0), plausible=(0.08, 1.5), remedy='check diameter, radii and angle')


def _check_friction(where: str, brake: Brake, warn: Warn) -> None:
    law = brake.friction_law
    if law.static < law.kinetic:
        warn(f'{where}.friction.static: is {law.static:g}, below kinetic {law.kinetic:g}: '
             'friction would rise with the sliding speed; swap them unless it is meant')
    if law.decay == 0.0 and law.static != law.kinetic:
        warn(f'{where}.friction.decay_s_m: is 0, so friction stays at static {law.static:g} and '
             f'never comes to kinetic {law.kinetic:g}; give a decay, or both alike')


def _check_stiffness_table(where: str, contact: Contact, warn: Warn) -> None:
    table = contact.stiffness_table
    if table is None:
        return
    place = f'{where}.contact.stiffness_table'
    if any(b < a for a, b in zip(table.stiffness, table.stiffness[1:], strict=False)):
        warn(f'{place}: stiffness falls with pressure; a friction material stiffens: check it')
    if not min(table.stiffness) / 5.0 <= contact.stiffness <= 5.0 * max(table.stiffness):
        warn(f'{where}.contact.stiffness_n_m3: is {contact.stiffness:g} N/m^3, far from its '
             f"table's {min(table.stiffness):g} to {max(table.stiffness):g} N/m^3; check both")

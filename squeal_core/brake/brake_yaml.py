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

"""Brake descriptions: YAML -> Brake, every key checked."""

from collections.abc import Mapping
from dataclasses import replace
import math
from pathlib import Path
from typing import Any

from squeal_core.brake.damping_yaml import read_damping, read_retardation_time, read_support
from squeal_core.brake.dimensions import (
    Brake,
    Caliper,
    Contact,
    HatDisc,
    Material,
    ModalResults,
    Pad,
    StiffnessTable,
    Support,
)
from squeal_core.brake.friction import FrictionLaw, FrictionTable
from squeal_core.brake.proportions import check_proportions
from squeal_core.brake.quantity_ranges import (
    CALIPER,
    CONTACT,
    CONTACT_PRESSURE,
    DISC,
    DISC_MODES,
    FIRST_TEMPERATURE,
    FRICTION,
    MODAL_MASS,
    ORIGIN,
    PAD,
    PAD_MODES,
    TABLE_FRICTION,
    TEMPERATURE,
)
from squeal_core.common.errors import BrakeDescriptionError, SquealError
from squeal_core.common.quantities import Quantity, QuantityReader
from squeal_core.common.ranges import hint, span, Warn, warn_implausible
from squeal_core.common.yaml_reader import read_yaml

ZERO_CELSIUS = 273.15


def read_brake(path: str | Path, *, warn: Warn = warn_implausible) -> Brake:
    """
    Read a brake description.

    Parameters
    ----------
    path : path
        Where the file is.
    warn : callable
        Given a text for each value that can be used but is unusual.

    Raises
    ------
    BrakeDescriptionError
        Naming the key's path, its value and the remedy.

    Examples
    --------
    >>> from squeal_core import read_brake
    >>> from squeal_core.common.resources import config_folder
    >>> read_brake(config_folder() / 'brakes' / 'kang2009.yaml').name
    'kang2009'

    """
    return parse_brake(read_yaml(path, BrakeDescriptionError), where=Path(path).name,
                       folder=Path(path).parent, warn=warn)


def parse_brake(content: Any, *, where: str = 'brake', folder: Path = Path(),
                warn: Warn = warn_implausible) -> Brake:
    """
    Return the brake that a mapping describes.

    `where` names its place in errors; files it names are looked for in `folder`.
    """
    said: set[str] = set()

    def warn_once(text: str) -> None:  # both pads may share one description
        if text not in said:
            said.add(text)
            warn(text)

    root = QuantityReader(where, content, warn=warn_once)
    name = root.text('name')
    for note in ('title', 'notes'):
        root.text(note, default='')
    contact = _contact(root.required_section('contact'))
    disc = _disc(root.required_section('disc'), folder)
    pads, supports = _pads(root.required_section('pads'), folder)
    if isinstance(disc, HatDisc):
        _check_patch_on_disc(where, contact, disc)
    modes = root.required_section('modes')
    disc_modes, pad_modes = modes.count('disc'), modes.count('pad', least=7)
    for key, count, usual in (('disc', disc_modes, DISC_MODES), ('pad', pad_modes, PAD_MODES)):
        if not usual[0] <= count <= usual[1]:
            warn_once(f'{modes.path(key)}: is {count}; usual is {usual[0]:g} to {usual[1]:g}: few '
                      'modes miss couplings, many cost time')
    modes.finish()
    brake = Brake(
        name=name, disc=disc, pads=pads, supports=supports, contact=contact,
        caliper=_caliper(root.required_section('caliper')),
        friction_law=_friction_law(friction := root.required_section('friction')),
        friction_table=_friction_table(friction),
        damping_ratio=read_damping(root),
        disc_modes=disc_modes, pad_modes=pad_modes,
        description=dict(root.content),
        sources={key.removeprefix(f'{where}.'): text for key, text in root.sources.items()})
    friction.finish()
    root.finish()
    check_proportions(where, brake, warn_once)
    return brake


def _numbers(section: QuantityReader, quantities: Mapping[str, Quantity]) -> dict[str, float]:
    return {name: section.number(name, quantity) for name, quantity in quantities.items()}


def _part(section: QuantityReader,
          quantities: Mapping[str, Quantity]) -> tuple[Material, dict[str, Any]]:
    """Return the material of a part and its other numbers."""
    numbers = _numbers(section, quantities)
    section.finish()
    material = Material(*(numbers.pop(name) for name in (
        'young_modulus', 'density', 'poisson_ratio')))
    return material, numbers


def _disc(section: QuantityReader, folder: Path) -> HatDisc | ModalResults:
    if 'modes_from' in section.content:
        return _modal_results(section, DISC, 'rotor_thickness', folder)
    material, lengths = _part(section, DISC)
    disc = HatDisc(material=material, **lengths)
    _in_order(section.where, 'the wall stands outside the clamp',
              hat_wall_thickness=disc.hat_wall_thickness,
              hat_wall_outer_radius=disc.hat_wall_outer_radius)
    _in_order(section.where, 'from the shaft outwards', clamp_radius=disc.clamp_radius,
              hat_wall_outer_radius=disc.hat_wall_outer_radius,
              rotor_outer_radius=disc.rotor_outer_radius)
    if disc.clamp_radius >= disc.hat_wall_inner_radius:
        raise BrakeDescriptionError(
            f'{section.where}.hat_wall_thickness',
            f'is {1e3 * disc.hat_wall_thickness:g} mm, so the wall reaches in to '
            f'{1e3 * disc.hat_wall_inner_radius:g} mm '
            f'(clamp_radius {1e3 * disc.clamp_radius:g} mm)',
            'make the wall thinner or the clamp smaller')
    _in_order(section.where, 'the plate lies within the hat',
              top_plate_thickness=disc.top_plate_thickness, hat_height=disc.hat_height)
    return disc


def _pads(section: QuantityReader, folder: Path) -> tuple[
        tuple[Pad | ModalResults, Pad | ModalResults], tuple[Support, Support]]:
    """Read both pads: one description for the two, or `top` and `bottom`."""
    if {'top', 'bottom'} & set(section.content):
        parts = [section.required_section('top'), section.required_section('bottom')]
        section.finish()
    else:
        parts = [section, section]
    supports = [read_support(part) for part in parts]
    pads = [_pad(part, folder) for part in parts]
    return (pads[0], pads[1]), (supports[0], supports[1])


def _pad(section: QuantityReader, folder: Path) -> Pad | ModalResults:
    if 'modes_from' in section.content:
        return _modal_results(section, PAD, 'thickness', folder)
    material, lengths = _part(section, PAD)
    return Pad(material=material, **lengths)


def _modal_results(section: QuantityReader, quantities: Mapping[str, Quantity], thickness: str,
                   folder: Path) -> ModalResults:
    """Read the source of a component's modes: `modes_from`, and data that no file contains."""
    source = section.required_section('modes_from')
    origin = tuple(source.numbers('origin_m')) if 'origin_m' in source.content else (0.0,) * 3
    if len(origin) != 3:
        raise BrakeDescriptionError(source.path('origin_m'), f'is {list(origin)}',
                                    'give three coordinates')
    for i, place in enumerate(origin):
        if not ORIGIN[0] <= place <= ORIGIN[1]:
            source.warn(f'{source.path("origin_m")}[{i}]: is {place:g} m; usual is '
                        f'{span(ORIGIN, 1.0, "m")}: check it'
                        f'{hint(place, "length", 1.0, "m", ORIGIN)}')
    results = ModalResults(
        file=str(folder / source.text('file')), format=source.text('format', '') or None,
        length_unit=source.text('length_unit'), mass_unit=source.text('mass_unit', 'kg'),
        axis=source.text('axis', 'z'), origin=origin,
        modal_mass=source.number('modal_mass', MODAL_MASS),
        density=section.number('density', quantities['density']),
        thickness=section.number(thickness, quantities[thickness]))
    source.finish()
    section.finish()
    if math.isnan(results.modal_mass or 0.0):
        return replace(results, modal_mass=None)
    return results


def _contact(section: QuantityReader) -> Contact:
    contact = Contact(**_numbers(section, CONTACT), stiffness_table=_stiffness_table(section),
                      retardation_time=read_retardation_time(section))
    section.finish()
    _in_order(section.where, 'the patch has a width', inner_radius=contact.inner_radius,
              outer_radius=contact.outer_radius)
    return contact


def _stiffness_table(contact: QuantityReader) -> StiffnessTable | None:
    table = contact.section('stiffness_table', required=False)
    if table is None:
        return None
    contact.sources[table.where] = table.text('source', default='not given')
    pressure = table.quantities('contact_pressure', CONTACT_PRESSURE)
    stiffness = table.quantities('stiffness', CONTACT['stiffness'])
    table.finish()
    try:
        return StiffnessTable(pressure, stiffness)
    except SquealError as error:
        raise BrakeDescriptionError(table.where, str(error), 'mend the lists') from None


def _caliper(section: QuantityReader) -> Caliper:
    numbers = _numbers(section, CALIPER)
    section.finish()
    return Caliper(piston_area=math.pi / 4.0 * numbers['piston_diameter']**2,
                   efficiency=numbers['efficiency'])


def _friction_law(section: QuantityReader) -> FrictionLaw:
    return FrictionLaw(**_numbers(section, FRICTION))


def _friction_table(root: QuantityReader) -> FrictionTable | None:
    table = root.section('temperature_table', required=False)
    if table is None:
        return None
    root.sources[table.where] = table.text('source', default='not given')
    celsius = table.checked_numbers('temperature_degc', TEMPERATURE, 'degC')
    friction = table.checked_numbers('friction', TABLE_FRICTION)
    table.finish()
    if min(celsius) > FIRST_TEMPERATURE:
        table.warn(f'{table.path("temperature_degc")}: begins at {min(celsius):g} degC; check it '
                   f'({min(celsius):g} K would be {min(celsius) - ZERO_CELSIUS:.4g} degC)')
    try:
        return FrictionTable(tuple(t + ZERO_CELSIUS for t in celsius), friction)
    except SquealError as error:
        raise BrakeDescriptionError(table.where, str(error), 'mend the lists') from None


def _check_patch_on_disc(where: str, contact: Contact, disc: HatDisc) -> None:
    if contact.outer_radius > disc.rotor_outer_radius:
        raise BrakeDescriptionError(
            f'{where}.contact.outer_radius',
            f'is {1e3 * contact.outer_radius:g} mm, off the disc (rotor_outer_radius '
            f'{1e3 * disc.rotor_outer_radius:g} mm)', 'move the contact patch inwards')
    if contact.inner_radius < disc.hat_wall_outer_radius:
        raise BrakeDescriptionError(
            f'{where}.contact.inner_radius',
            f'is {1e3 * contact.inner_radius:g} mm, within the hat (hat_wall_outer_radius '
            f'{1e3 * disc.hat_wall_outer_radius:g} mm)', 'move the contact patch outwards')


def _in_order(where: str, why: str, **lengths: float) -> None:
    pairs = list(lengths.items())
    for (inner, low), (outer, high) in zip(pairs, pairs[1:], strict=False):
        if not low < high:
            raise BrakeDescriptionError(
                f'{where}.{outer}',
                f'{outer} is {1e3 * high:g} mm and {inner} {1e3 * low:g} mm ({why})',
                f'make {outer} the larger')

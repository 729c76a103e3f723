"""Brake descriptions: YAML -> Brake, every key checked."""

from dataclasses import replace
import math
from pathlib import Path
from typing import Any

from squeal_core.brake import (
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
from squeal_core.description import Quantity, Section
from squeal_core.errors import BrakeDescriptionError, SquealError
from squeal_core.friction import FrictionLaw, FrictionTable
from squeal_core.yaml_file import read_yaml

ZERO_CELSIUS = 273.15

_LENGTH = Quantity('length', above=0.0, below=5.0)
_STIFFNESS = Quantity('stiffness', above=1e6, below=1e15)


def read_brake(path: str | Path) -> Brake:
    """Read a brake description.

    Raises
    ------
    BrakeDescriptionError
        Naming the key's path, its value and the remedy.
    """
    return parse_brake(read_yaml(path, BrakeDescriptionError), where=Path(path).name,
                       folder=Path(path).parent)


def parse_brake(content: Any, *, where: str = 'brake', folder: Path = Path()) -> Brake:
    """Return the brake that a mapping describes.

    `where` names its place in errors; files it names are looked for in `folder`.
    """
    root = Section(where, content)
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
    modes.finish()
    brake = Brake(
        name=name, disc=disc, pads=pads, supports=supports, contact=contact,
        caliper=_caliper(root.required_section('caliper')),
        friction_law=_friction_law(friction := root.required_section('friction')),
        friction_table=_friction_table(friction),
        damping_ratio=root.number('damping_ratio', Quantity('number', 0.0, 0.999, closed=True)),
        disc_modes=disc_modes, pad_modes=pad_modes,
        description=dict(root.content),
        sources={key.removeprefix(f'{where}.'): text for key, text in root.sources.items()})
    friction.finish()
    root.finish()
    return brake


def _material(section: Section) -> Material:
    return Material(
        young_modulus=section.number('young_modulus', Quantity('modulus', 1e6, 2e12)),
        density=section.number('density', Quantity('density', 10.0, 30e3)),
        poisson_ratio=section.number('poisson_ratio', Quantity('number', -1.0, 0.5)))


def _disc(section: Section, folder: Path) -> HatDisc | ModalResults:
    if 'modes_from' in section.content:
        return _modal_results(section, 'rotor_thickness', folder)
    disc = HatDisc(material=_material(section), **{
        name: section.number(name, _LENGTH) for name in (
            'rotor_thickness', 'rotor_outer_radius', 'hat_wall_outer_radius',
            'hat_wall_thickness', 'hat_height', 'top_plate_thickness', 'clamp_radius')})
    section.finish()
    _in_order(section.where, 'the wall stands outside the clamp',
              hat_wall_thickness=disc.hat_wall_thickness,
              hat_wall_outer_radius=disc.hat_wall_outer_radius)
    _in_order(section.where, 'from the shaft outwards', clamp_radius=disc.clamp_radius,
              hat_wall_outer_radius=disc.hat_wall_outer_radius,
              rotor_outer_radius=disc.rotor_outer_radius)
    if disc.clamp_radius >= disc.hat_wall_inner_radius:
        raise BrakeDescriptionError(
            f'{section.where}.hat_wall_thickness',
            f'is {disc.hat_wall_thickness:g} m, so the wall reaches in to '
            f'{disc.hat_wall_inner_radius:g} m (clamp_radius {disc.clamp_radius:g} m)',
            'make the wall thinner or the clamp smaller')
    _in_order(section.where, 'the plate lies within the hat',
              top_plate_thickness=disc.top_plate_thickness, hat_height=disc.hat_height)
    return disc


def _pads(section: Section, folder: Path) -> tuple[
        tuple[Pad | ModalResults, Pad | ModalResults], tuple[Support, Support]]:
    """Read both pads: one description for the two, or `top` and `bottom`."""
    if {'top', 'bottom'} & set(section.content):
        parts = [section.required_section('top'), section.required_section('bottom')]
        section.finish()
    else:
        parts = [section, section]
    supports = [_support(part.section('support', required=False)) for part in parts]
    pads = [_pad(part, folder) for part in parts]
    return (pads[0], pads[1]), (supports[0], supports[1])


def _pad(section: Section, folder: Path) -> Pad | ModalResults:
    if 'modes_from' in section.content:
        return _modal_results(section, 'thickness', folder)
    pad = Pad(material=_material(section), thickness=section.number('thickness', _LENGTH))
    section.finish()
    return pad


def _support(section: Section | None) -> Support:
    if section is None:
        return Support()
    kinds = {'stiffness': 1e15, 'damping': 1e12}
    support = Support(**{
        f'{way}_{kind}': section.number(
            f'{way}_{kind}', Quantity(kind, 0.0, most, closed=True, default=0.0))
        for way in ('radial', 'tangential', 'axial') for kind, most in kinds.items()})
    section.finish()
    return support


def _modal_results(section: Section, thickness: str, folder: Path) -> ModalResults:
    """Read what says where a component's modes are: `modes_from`, and what no file can say."""
    source = section.required_section('modes_from')
    origin = tuple(source.numbers('origin_m')) if 'origin_m' in source.content else (0.0,) * 3
    if len(origin) != 3:
        raise BrakeDescriptionError(source.path('origin_m'), f'is {list(origin)}',
                                    'give three coordinates')
    results = ModalResults(
        file=str(folder / source.text('file')), format=source.text('format', '') or None,
        length_unit=source.text('length_unit'), mass_unit=source.text('mass_unit', 'kg'),
        axis=source.text('axis', 'z'), origin=origin,
        modal_mass=source.number('modal_mass', Quantity('number', 0.0, default=math.nan)),
        density=section.number('density', Quantity('density', 10.0, 30e3)),
        thickness=section.number(thickness, _LENGTH))
    source.finish()
    section.finish()
    if math.isnan(results.modal_mass or 0.0):
        return replace(results, modal_mass=None)
    return results


def _contact(section: Section) -> Contact:
    contact = Contact(
        inner_radius=section.number('inner_radius', _LENGTH),
        outer_radius=section.number('outer_radius', _LENGTH),
        angle=section.number('angle', Quantity('angle', 0.0, math.pi)),
        stiffness=section.number('stiffness', _STIFFNESS),
        stiffness_table=_stiffness_table(section))
    section.finish()
    _in_order(section.where, 'the patch has a width', inner_radius=contact.inner_radius,
              outer_radius=contact.outer_radius)
    return contact


def _stiffness_table(contact: Section) -> StiffnessTable | None:
    table = contact.section('stiffness_table', required=False)
    if table is None:
        return None
    contact.sources[table.where] = table.text('source', default='not given')
    pressure = table.quantities('contact_pressure', Quantity('pressure', 0.0, 1e9, closed=True))
    stiffness = table.quantities('stiffness', _STIFFNESS)
    table.finish()
    try:
        return StiffnessTable(pressure, stiffness)
    except SquealError as error:
        raise BrakeDescriptionError(table.where, str(error), 'mend the lists') from None


def _caliper(section: Section) -> Caliper:
    diameter = section.number('piston_diameter', _LENGTH)
    efficiency = section.number(
        'efficiency', Quantity('number', 0.01, 1.0, closed=True, default=1.0))
    section.finish()
    return Caliper(piston_area=math.pi / 4.0 * diameter**2, efficiency=efficiency)


def _friction_law(section: Section) -> FrictionLaw:
    return FrictionLaw(
        static=section.number('static', Quantity('number', 0.0, 2.0)),
        kinetic=section.number('kinetic', Quantity('number', 0.0, 2.0)),
        decay=section.number(
            'decay', Quantity('inverse_speed', 0.0, 1e3, closed=True)))


def _friction_table(root: Section) -> FrictionTable | None:
    table = root.section('temperature_table', required=False)
    if table is None:
        return None
    root.sources[table.where] = table.text('source', default='not given')
    celsius, friction = table.numbers('temperature_degc'), table.numbers('friction')
    table.finish()
    try:
        return FrictionTable(tuple(t + ZERO_CELSIUS for t in celsius), friction)
    except SquealError as error:
        raise BrakeDescriptionError(table.where, str(error), 'mend the lists') from None


def _check_patch_on_disc(where: str, contact: Contact, disc: HatDisc) -> None:
    if contact.outer_radius > disc.rotor_outer_radius:
        raise BrakeDescriptionError(
            f'{where}.contact.outer_radius',
            f'is {contact.outer_radius:g} m, off the disc (rotor_outer_radius '
            f'{disc.rotor_outer_radius:g} m)', 'move the contact patch inwards')
    if contact.inner_radius < disc.hat_wall_outer_radius:
        raise BrakeDescriptionError(
            f'{where}.contact.inner_radius',
            f'is {contact.inner_radius:g} m, within the hat (hat_wall_outer_radius '
            f'{disc.hat_wall_outer_radius:g} m)', 'move the contact patch outwards')


def _in_order(where: str, why: str, **lengths: float) -> None:
    pairs = list(lengths.items())
    for (inner, low), (outer, high) in zip(pairs, pairs[1:], strict=False):
        if not low < high:
            raise BrakeDescriptionError(
                f'{where}.{outer}', f'{outer} is {high:g} m and {inner} {low:g} m ({why})',
                f'make {outer} the larger')

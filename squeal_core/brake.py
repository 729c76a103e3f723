"""What a brake is: hat disc, pads, contact, caliper, friction; read from a YAML description."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import math
from pathlib import Path
from typing import Any

from squeal_core.description import Quantity, Section
from squeal_core.errors import BrakeDescriptionError, SquealError
from squeal_core.friction import check_number, FrictionLaw, FrictionTable
from squeal_core.yaml_file import read_yaml

ZERO_CELSIUS = 273.15

_LENGTH = Quantity('length', above=0.0, below=5.0)
_RATIO = Quantity('number', above=0.0, below=1.0)


@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic: Young's modulus [Pa], density [kg/m^3], Poisson ratio [-]."""

    young_modulus: float
    density: float
    poisson_ratio: float


@dataclass(frozen=True)
class HatDisc:
    """Rotor plate, hat wall and top plate, clamped at the shaft; lengths in m.

    The rotor plate lies at |z| <= rotor_thickness / 2 and runs in to the wall's inner radius;
    the top plate's upper face stands `hat_height` above the rotor's top face.
    """

    material: Material
    rotor_thickness: float
    rotor_outer_radius: float
    hat_wall_outer_radius: float
    hat_wall_thickness: float
    hat_height: float
    top_plate_thickness: float
    clamp_radius: float

    @property
    def hat_wall_inner_radius(self) -> float:
        return self.hat_wall_outer_radius - self.hat_wall_thickness


@dataclass(frozen=True)
class Pad:
    """A free annular sector plate over the contact patch; thickness in m."""

    material: Material
    thickness: float


@dataclass(frozen=True)
class Contact:
    """The sector in which pads touch the disc, and the stiffness of the friction material.

    Radii in m, angle in rad, stiffness per area in N/m^3.
    """

    inner_radius: float
    outer_radius: float
    angle: float
    stiffness: float

    @property
    def area(self) -> float:
        """A_c [m^2]."""
        return 0.5 * self.angle * (self.outer_radius**2 - self.inner_radius**2)

    @property
    def mean_radius(self) -> float:
        """Area-mean radius r_ctr [m], at which the sliding speed is taken."""
        ri, ro = self.inner_radius, self.outer_radius
        return 2.0 / 3.0 * (ro**3 - ri**3) / (ro**2 - ri**2)


@dataclass(frozen=True)
class Caliper:
    """What turns brake pressure into preload: piston area [m^2] on one side, efficiency [-]."""

    piston_area: float
    efficiency: float = 1.0

    def __post_init__(self) -> None:
        for name, most in (('piston_area', 1.0), ('efficiency', 1.0)):
            check_number(f'caliper.{name}', getattr(self, name), above=0.0, most=most)

    def preload(self, pressure: float) -> float:
        """Return N0 [N] of one pad at a pressure [Pa]."""
        return pressure * self.piston_area * self.efficiency


@dataclass(frozen=True)
class Brake:
    """A brake described by its dimensions, and how many modes its model keeps."""

    name: str
    disc: HatDisc
    pad: Pad
    contact: Contact
    caliper: Caliper
    friction_law: FrictionLaw
    friction_table: FrictionTable | None
    damping_ratio: float
    disc_modes: int
    pad_modes: int
    description: Mapping[str, Any] = field(repr=False, compare=False, default_factory=dict)
    sources: Mapping[str, str] = field(repr=False, compare=False, default_factory=dict)


def read_brake(path: str | Path) -> Brake:
    """Read a brake description.

    Raises
    ------
    BrakeDescriptionError
        Naming the key's path, its value and the remedy.
    """
    return parse_brake(read_yaml(path, BrakeDescriptionError), where=Path(path).name)


def parse_brake(content: Any, *, where: str = 'brake') -> Brake:
    """Return the brake that a mapping describes; `where` names its place in errors."""
    root = Section(where, content)
    name = root.text('name')
    for note in ('title', 'notes'):
        root.text(note, default='')
    contact = _contact(root.required_section('contact'))
    disc = _disc(root.required_section('disc'))
    pad = _pad(root.required_section('pads'))
    _check_patch_on_disc(where, contact, disc)
    modes = root.required_section('modes')
    disc_modes, pad_modes = modes.count('disc'), modes.count('pad', least=7)
    modes.finish()
    brake = Brake(
        name=name, disc=disc, pad=pad, contact=contact,
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


def _disc(section: Section) -> HatDisc:
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


def _pad(section: Section) -> Pad:
    pad = Pad(material=_material(section), thickness=section.number('thickness', _LENGTH))
    section.finish()
    return pad


def _contact(section: Section) -> Contact:
    contact = Contact(
        inner_radius=section.number('inner_radius', _LENGTH),
        outer_radius=section.number('outer_radius', _LENGTH),
        angle=section.number('angle', Quantity('angle', 0.0, math.pi)),
        stiffness=section.number('stiffness', Quantity('stiffness', 1e6, 1e15)))
    section.finish()
    _in_order(section.where, 'the patch has a width', inner_radius=contact.inner_radius,
              outer_radius=contact.outer_radius)
    return contact


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

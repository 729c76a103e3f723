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

"""Records of a brake description: hat disc, pads, contact, caliper, friction."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import math
from typing import Any

import numpy as np
from squeal_core.brake.damping import ComponentDamping
from squeal_core.brake.friction import FrictionLaw, FrictionTable
from squeal_core.common.arrays import FloatArray
from squeal_core.common.checks import check_number, check_rising, column
from squeal_core.common.errors import SquealError


@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic: Young's modulus [Pa], density [kg/m^3], Poisson ratio [-]."""

    young_modulus: float
    density: float
    poisson_ratio: float


@dataclass(frozen=True)
class HatDisc:
    """
    Rotor plate, hat wall and top plate, clamped at the shaft; lengths in m.

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
        """Return the radius [m] of the inner face of the hat wall."""
        return self.hat_wall_outer_radius - self.hat_wall_thickness


@dataclass(frozen=True)
class Pad:
    """A free annular sector plate over the contact patch; thickness in m."""

    material: Material
    thickness: float


@dataclass(frozen=True)
class ModalResults:
    """
    Modes of a component in a file of another package, and how to read it.

    Fields as the arguments of `squeal_core.modes.readers.read_modes`; origin in m, density kg/m^3,
    thickness of the rotor or of the pad in m.
    """

    file: str
    format: str | None  # noqa: A003
    length_unit: str
    mass_unit: str
    axis: str
    origin: tuple[float, float, float]
    modal_mass: float | None
    density: float
    thickness: float


@dataclass(frozen=True)
class Support:
    """Elastic support at a pad's back face, per area: stiffness [N/m^3], damping [N s/m^3]."""

    radial_stiffness: float = 0.0
    tangential_stiffness: float = 0.0
    axial_stiffness: float = 0.0
    radial_damping: float = 0.0
    tangential_damping: float = 0.0
    axial_damping: float = 0.0


@dataclass(frozen=True)
class StiffnessTable:
    """
    Contact stiffness over contact pressure, linear between its points, flat beyond.

    Friction material stiffens as it is pressed together. Beyond the measured pressures the last
    value is held rather than refused: a running monitor must answer at every pressure.

    Parameters
    ----------
    pressure : tuple of floats
        p0, preload over contact area, rising, the first may be zero [Pa].
    stiffness : tuple of floats
        k_c per area at each pressure, above zero [N/m^3].

    Raises
    ------
    SquealError
        For lists that do not match, do not rise, or hold what is no number in range.

    """

    pressure: tuple[float, ...]
    stiffness: tuple[float, ...]

    def __post_init__(self) -> None:
        table = 'stiffness table'
        object.__setattr__(self, 'pressure', column(
            table, 'pressure', self.pressure, above=-math.inf, least=0.0))
        object.__setattr__(self, 'stiffness', column(table, 'stiffness', self.stiffness))
        check_rising(table, ('pressures', 'stiffnesses'), self.pressure, self.stiffness)

    def __call__(self, pressure: FloatArray | float) -> FloatArray:
        """Return k_c [N/m^3] at contact pressures [Pa]."""
        return np.asarray(np.interp(pressure, self.pressure, self.stiffness))


@dataclass(frozen=True)
class Contact:
    """
    The sector in which pads touch the disc, and the stiffness of the friction material.

    Radii in m, angle in rad, nominal stiffness per area in N/m^3; with a table the stiffness
    follows the contact pressure. A retardation time in s (`damping.retardation_time`) damps it.
    """

    inner_radius: float
    outer_radius: float
    angle: float
    stiffness: float
    stiffness_table: StiffnessTable | None = None
    retardation_time: float = 0.0

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
    """Caliper, from pressure to preload: piston area [m^2] on one side, efficiency [-]."""

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
    """
    A brake described by dimensions or modal results, and how many modes its model keeps.

    `pads` and `supports` are those of the top (pad 1) and of the bottom (pad 2); `damping_ratio`
    is one for all components, or that of each over frequency.
    """

    name: str
    disc: HatDisc | ModalResults
    pads: tuple[Pad | ModalResults, Pad | ModalResults]
    supports: tuple[Support, Support]
    contact: Contact
    caliper: Caliper
    friction_law: FrictionLaw
    friction_table: FrictionTable | None
    damping_ratio: float | ComponentDamping
    disc_modes: int
    pad_modes: int
    description: Mapping[str, Any] = field(repr=False, compare=False, default_factory=dict)
    sources: Mapping[str, str] = field(repr=False, compare=False, default_factory=dict)

    @property
    def rotor_thickness(self) -> float:
        """Return h [m]: the contact faces lie at z = +-h/2."""
        disc = self.disc
        return disc.rotor_thickness if isinstance(disc, HatDisc) else disc.thickness

    @property
    def pad(self) -> Pad:
        """Return the pad, where both are alike and described by dimensions."""
        first, second = self.pads
        if first != second or not isinstance(first, Pad):
            raise SquealError(f'{self.name}: its pads differ or come from files; use `pads`')
        return first

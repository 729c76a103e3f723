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

"""The modal brake model: an affine family of damping and stiffness matrices."""

from dataclasses import dataclass, field, fields
from functools import cached_property
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.brake.dimensions import Caliper, Contact, StiffnessTable
from squeal_core.brake.friction import FrictionLaw, FrictionTable
from squeal_core.brake.operating_point import Coefficients, DASHPOTS, OperatingPoint
from squeal_core.common.arrays import FloatArray, readonly
from squeal_core.common.checks import check_number, finite_array
from squeal_core.common.errors import ModelError
from squeal_core.model.matrix_names import MAX_MODES, OPERATORS, SUPPORTS
from squeal_core.model.model_file import read_model, write_model
from squeal_core.model.surface_shapes import SurfaceShapes

_KANG = Contact(inner_radius=0.1, outer_radius=0.142, angle=np.deg2rad(62.0), stiffness=0.35e11)


@dataclass(frozen=True, kw_only=True, eq=False)
class BrakeModel:
    """
    a'' + D(q) a' + K(q) a = 0 with mass-normalised modal coordinates a; K09 eq. (36).

    Parameters
    ----------
    angular_frequencies : (N,) array
        w_n of the uncoupled components [rad/s]; pad 1 | disc | pad 2, or any order of your own.
    damping_ratios : (N,) array or float
        xi_n [-].
    gyroscopic, contact_stiffness, friction_couple, radial_dissipation, negative_slope, follower :
        (N, N) arrays G0, A0, B0, R0, S0, F0 without their scalars (`model.operators`); what
        is None is left out of the model.
    support_stiffness, support_damping : (N, N) arrays
        What holds the pads, the same at every operating point [1/s^2], [1/s]; None: nothing (K09).
    contact_area : float
        A_c [m^2] of one pad.
    contact_radius : float
        r_ctr [m], where the sliding speed is taken.
    nominal_contact_stiffness : float
        k_c per area [N/m^3], where no table says more.
    stiffness_table : StiffnessTable, optional
        k_c over contact pressure; None: nominal at every pressure (K09).
    contact_retardation_time : float
        c_c / k_c of lining and contact layer as a spring and a dashpot side by side, loss factor
        over angular reference frequency (`brake.damping.retardation_time`) [s]; 0: none (K09).
    caliper, friction_law, friction_table
        What turns pressure, speed and temperature into an operating point; None: not known.
    names : tuple of str
        A name for each mode, may be empty.
    provenance : mapping
        How the model came to be: texts and numbers for `squeal info`.
    surface : SurfaceShapes, optional
        Shapes of the modes, for plots.

    Raises
    ------
    ModelError
        For shapes that do not fit, values that are not finite, a wrong symmetry.

    References
    ----------
    K09: J. Kang, Squeal analysis of gyroscopic disc brake system based on finite element method,
    Int. J. Mech. Sci. 51 (2009) 284-294.

    Examples
    --------
    >>> from squeal_core import BrakeModel
    >>> BrakeModel.load('kang2009').size
    92

    """

    angular_frequencies: FloatArray
    damping_ratios: FloatArray | float = 0.002
    gyroscopic: FloatArray | None = None
    contact_stiffness: FloatArray | None = None
    friction_couple: FloatArray | None = None
    radial_dissipation: FloatArray | None = None
    negative_slope: FloatArray | None = None
    follower: FloatArray | None = None
    support_stiffness: FloatArray | None = None
    support_damping: FloatArray | None = None
    contact_area: float = _KANG.area
    contact_radius: float = _KANG.mean_radius
    nominal_contact_stiffness: float = _KANG.stiffness
    stiffness_table: StiffnessTable | None = None
    contact_retardation_time: float = 0.0
    caliper: Caliper | None = None
    friction_law: FrictionLaw | None = None
    friction_table: FrictionTable | None = None
    names: tuple[str, ...] = ()
    provenance: dict[str, Any] = field(default_factory=dict, repr=False)
    surface: SurfaceShapes | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        w = finite_array('angular_frequencies', self.angular_frequencies)
        if w.ndim != 1 or not 1 <= w.size <= MAX_MODES or np.any(w < 0):
            raise ModelError(f'angular_frequencies: shape {w.shape}, least '
                             f'{w.min(initial=0.0):g}; give 1 to {MAX_MODES} frequencies, none '
                             'negative')
        self._keep('angular_frequencies', w)
        damping = finite_array('damping_ratios', self.damping_ratios)
        if damping.shape not in ((), w.shape):
            raise ModelError(
                f'damping_ratios: shape {damping.shape}; give {w.shape} or one number')
        self._keep('damping_ratios', np.broadcast_to(damping, w.shape))
        for name in (*OPERATORS, *SUPPORTS):
            self._check_operator(name)
        for name in ('contact_area', 'contact_radius', 'nominal_contact_stiffness'):
            check_number(name, getattr(self, name), above=0.0)
        check_number('contact_retardation_time', self.contact_retardation_time, least=0.0)
        if self.names and len(self.names) != w.size:
            raise ModelError(f'names: {len(self.names)} for {w.size} modes; give one for each')
        if self.surface and self.surface.shapes.shape[2] != w.size:
            raise ModelError(f'surface: shapes of {self.surface.shapes.shape[2]} modes for '
                             f'{w.size}; give them for each')

    def __repr__(self) -> str:
        hertz = self.angular_frequencies / (2.0 * np.pi)
        arrays = [name for name in (*OPERATORS, *SUPPORTS) if getattr(self, name) is not None]
        return (f'BrakeModel({self.provenance.get("brake", "")!r:.60}: {self.size} modes, '
                f'{hertz.min():.0f} to {hertz.max():.0f} Hz, contact stiffness '
                f'{self.nominal_contact_stiffness:.3g} N/m^3, {len(arrays)} arrays)')

    def _check_operator(self, name: str) -> None:
        if getattr(self, name) is None:
            return
        array = finite_array(name, getattr(self, name))
        if array.shape != (self.size, self.size):
            raise ModelError(f'{name}: shape {array.shape}; give {(self.size, self.size)}')
        sign = {'gyroscopic': -1.0, 'friction_couple': 0.0, 'follower': 0.0}.get(name, 1.0)
        error = np.abs(array - sign * array.T).max() if sign else 0.0
        if error > 1e-6 * np.abs(array).max():
            kind = 'skew' if sign < 0 else 'symmetric'
            raise ModelError(
                f'{name}: not {kind} (off by {error:.3g}); check how it was assembled')
        self._keep(name, array)

    def _keep(self, name: str, values: ArrayLike) -> None:
        object.__setattr__(self, name, readonly(values))

    @property
    def size(self) -> int:
        """N, the number of modes."""
        return int(self.angular_frequencies.size)

    @cached_property
    def largest_frequency(self) -> float:
        """Return the largest angular frequency of parts and supports without contact [rad/s]."""
        if self.support_stiffness is None:
            return float(self.angular_frequencies.max())
        held = np.diag(self.angular_frequencies**2) + self.support_stiffness
        return math.sqrt(float(np.linalg.norm(held, 2)))

    @cached_property
    def structural_damping(self) -> FloatArray:
        """Diagonal of C, 2 xi_n w_n [1/s]; K09 eq. (A.1)."""
        return readonly(2.0 * self.damping_ratios * self.angular_frequencies)

    @cached_property
    def material_damping(self) -> FloatArray:
        """C [1/s], (N, N): structural damping and that of the supports."""
        matrix = np.diag(self.structural_damping)
        return readonly(matrix if self.support_damping is None else matrix + self.support_damping)

    @cached_property
    def contact_damping(self) -> FloatArray | None:
        """c_c / k_c times A0 [s m^2/kg]: the force of the layer's dashpot; None without one."""
        return self._dashpot('contact_stiffness')

    @cached_property
    def contact_damping_couple(self) -> FloatArray | None:
        """c_c / k_c times B0 [s m^2/kg]: the friction of that force; None without one."""
        return self._dashpot('friction_couple')

    def _dashpot(self, name: str) -> FloatArray | None:
        spring = getattr(self, name)
        if spring is None or self.contact_retardation_time == 0.0:
            return None
        return readonly(self.contact_retardation_time * spring)

    @cached_property
    def free_coordinates(self) -> FloatArray:
        """
        Mask (N,) of coordinates that no stiffness acts on, as K09's pads sliding in plane.

        Their columns of K vanish at every operating point, so each gives an eigenvalue of
        exactly zero.
        """
        free = self.angular_frequencies == 0.0
        for name in ('contact_stiffness', 'friction_couple', 'follower', 'support_stiffness'):
            array = getattr(self, name)
            if array is not None:
                free = free & (np.abs(array).max(axis=0) <= 1e-12 * np.abs(array).max())
        return readonly(free, bool)

    def damping(self, point: OperatingPoint) -> FloatArray:
        """Return D(q) [1/s], (N, N)."""
        c = point.coefficients()
        return self._add(c.material_damping * self.material_damping, c, 'gyroscopic',
                         'radial_dissipation', 'negative_slope', *DASHPOTS.values())

    def stiffness(self, point: OperatingPoint) -> FloatArray:
        """Return K(q) [1/s^2], (N, N)."""
        c = point.coefficients()
        matrix = np.diag(self.angular_frequencies**2)
        if self.support_stiffness is not None:
            matrix += self.support_stiffness
        return self._add(matrix, c, 'contact_stiffness', 'friction_couple', 'follower')

    def _add(self, matrix: FloatArray, coefficients: Coefficients, *names: str) -> FloatArray:
        for name in names:
            array = getattr(self, name)
            if array is not None:
                matrix += getattr(coefficients, name) * array
        return matrix

    def operating_point(self, *, rotor_speed: float, pressure: float,
                        friction: float | None = None,
                        friction_slope: float | None = None,
                        contact_stiffness: float | None = None,
                        damping_scale: float = 1.0) -> OperatingPoint:
        """
        Return the point at which signals of a vehicle put the brake.

        Parameters
        ----------
        rotor_speed : float
            Omega [rad/s]; negative for a disc turning backwards.
        pressure : float
            Brake pressure [Pa].
        friction : float, optional
            Measured mu [-], positive; the friction law's where None.
        friction_slope : float, optional
            mu_v [s/m]; the friction law's, scaled to the measured mu, where None.
        contact_stiffness : float, optional
            k_c [N/m^3]; by the stiffness table where None, nominal without one.
        damping_scale : float
            Factor on the model's damping [-].

        """
        contact_pressure = self.contact_pressure(pressure)
        speed = self.contact_radius * rotor_speed
        if self.friction_law is not None:
            if friction is None:
                friction = self.friction_law.coefficient(speed)
            if friction_slope is None:
                friction_slope = self.friction_law.slope_at(speed, friction)
        if friction is None:
            raise ModelError('friction_law: this model has none; give a friction coefficient')
        return OperatingPoint(
            rotor_speed=rotor_speed, friction=math.copysign(friction, rotor_speed),
            friction_slope=friction_slope or 0.0, contact_pressure=contact_pressure,
            contact_stiffness=self.contact_stiffness_at(contact_pressure)
            if contact_stiffness is None else contact_stiffness, damping_scale=damping_scale)

    def contact_pressure(self, pressure: float) -> float:
        """Return p0, preload over contact area [Pa], at a brake pressure [Pa]."""
        if self.caliper is None:
            raise ModelError('caliper: this model has none, so a pressure says nothing; give the '
                             'preload through OperatingPoint(contact_pressure=...)')
        return self.caliper.preload(pressure) / self.contact_area

    def contact_stiffness_at(self, contact_pressure: float) -> float:
        """Return k_c [N/m^3] at a contact pressure p0 [Pa]: the table's, else nominal."""
        if self.stiffness_table is None:
            return self.nominal_contact_stiffness
        return float(self.stiffness_table(contact_pressure))

    def save(self, path: str | Path, *, overwrite: bool = True) -> None:
        """Write the model to a file; see `squeal_core.model.model_file`."""
        write_model({one.name: getattr(self, one.name) for one in fields(self)}, path,
                    overwrite=overwrite)

    @staticmethod
    def load(path: str | Path) -> 'BrakeModel':
        """Read a model from a file; see `squeal_core.model.model_file`."""
        return read_model(path, BrakeModel)[1]

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
Possible and usual ranges of the keys of a brake description, SI units.

Possible is what a computation can follow. Usual is what disc brakes from bicycles to trains
have; a number beyond it is most often one in another unit.
"""

import math

from squeal_core.common.quantities import Quantity
from squeal_core.common.ranges import Ends

_DEGREE = math.pi / 180.0


def _length(possible_mm: Ends, usual_mm: Ends) -> Quantity:
    low, high = (1e-3 * end for end in possible_mm)
    return Quantity('length', low, high, closed=True,
                    plausible=(1e-3 * usual_mm[0], 1e-3 * usual_mm[1]))


def _number(possible: Ends, usual: Ends, default: float | None = None) -> Quantity:
    return Quantity('number', *possible, closed=True, default=default, plausible=usual)


DISC = {
    'young_modulus': Quantity('modulus', 1e9, 1e12, closed=True, plausible=(15e9, 250e9)),
    'density': Quantity('density', 300.0, 25e3, closed=True, plausible=(1400.0, 9000.0)),
    'poisson_ratio': _number((-0.5, 0.49), (0.05, 0.45)),
    'rotor_thickness': _length((0.5, 300.0), (1.5, 120.0)),
    'rotor_outer_radius': _length((10.0, 1500.0), (60.0, 400.0)),
    'hat_wall_outer_radius': _length((5.0, 1400.0), (25.0, 250.0)),
    'hat_wall_thickness': _length((0.3, 200.0), (2.0, 40.0)),
    'hat_height': _length((0.5, 600.0), (4.0, 150.0)),
    'top_plate_thickness': _length((0.3, 200.0), (2.0, 40.0)),
    'clamp_radius': _length((1.0, 1300.0), (8.0, 200.0)),
}
PAD = {
    'young_modulus': Quantity('modulus', 50e6, 1e12, closed=True, plausible=(300e6, 250e9)),
    'density': Quantity('density', 300.0, 25e3, closed=True, plausible=(1000.0, 9000.0)),
    'poisson_ratio': _number((-0.5, 0.49), (0.05, 0.45)),
    'thickness': _length((0.3, 150.0), (2.0, 50.0)),
}
CONTACT = {
    'inner_radius': _length((5.0, 1400.0), (30.0, 350.0)),
    'outer_radius': _length((6.0, 1500.0), (40.0, 400.0)),
    'angle': Quantity('angle', 1.0 * _DEGREE, 179.0 * _DEGREE, closed=True,
                      plausible=(10.0 * _DEGREE, 120.0 * _DEGREE)),
    'stiffness': Quantity('stiffness', 1e6, 1e15, plausible=(5e8, 5e12)),
}
CONTACT_PRESSURE = Quantity('pressure', 0.0, 1e9, closed=True, plausible=(1e4, 5e7), zero=True)
CALIPER = {
    'piston_diameter': _length((2.0, 500.0), (15.0, 150.0)),
    'efficiency': _number((0.01, 1.0), (0.6, 1.0), 1.0),
}
FRICTION = {
    'static': _number((0.01, 1.5), (0.1, 0.9)),
    'kinetic': _number((0.01, 1.5), (0.08, 0.9)),
    'decay': Quantity('inverse_speed', 0.0, 1e3, closed=True, plausible=(0.01, 50.0), zero=True),
}
DAMPING_RATIO = _number((0.0, 0.5), (1e-4, 0.05))
DAMPING_FREQUENCY = Quantity('frequency', 0.0, 1e6, plausible=(20.0, 3e4))
LOSS_FACTOR = Quantity('number', 0.0, 10.0, closed=True, default=0.0, plausible=(5e-3, 1.0),
                       zero=True)
REFERENCE_FREQUENCY = Quantity('frequency', 0.0, 1e6, default=0.0, plausible=(50.0, 2e4))
SUPPORT = {
    'stiffness': Quantity('stiffness', 0.0, 1e15, closed=True, default=0.0,
                          plausible=(1e6, 1e13), zero=True),
    'damping': Quantity('damping', 0.0, 1e12, closed=True, default=0.0,
                        plausible=(1.0, 1e9), zero=True),
}
SHIM = {
    'axial_stiffness': Quantity('stiffness', 0.0, 1e15, plausible=(1e9, 1e14)),
    'shear_stiffness': Quantity('stiffness', 0.0, 1e15, closed=True, default=0.0,
                                plausible=(1e8, 1e14), zero=True),
}
MODAL_MASS = Quantity('number', 0.0, default=math.nan, plausible=(1e-9, 1e9))
ORIGIN: Ends = (-2.0, 2.0)  # m
DISC_MODES: Ends = (8, 300)
PAD_MODES: Ends = (8, 150)
# temperature [degC] and friction [-] of a table
TEMPERATURE = Quantity('temperature', -100.0, 1500.0, closed=True, plausible=(-50.0, 1000.0))
TABLE_FRICTION = _number((0.01, 1.5), (0.05, 0.9))
FIRST_TEMPERATURE = 200.0  # degC; a table that begins above it probably is in K

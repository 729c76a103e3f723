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
Build-up: how far a mode's amplitude has grown above its noise floor.

The energy E of a mode over that of its floor obeys E' = 2 sigma E + S. Noise S = 2 d holds it at
E = 1 while it decays with its own damping d and nothing drives it. A tone ends where the contact
opens, at an amplitude near c p0 / k_c. The build-up is ln sqrt(E) [nepers].
"""

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.common.arrays import FloatArray, RealArray

FLOOR = 1e-9  # m, root mean square relative displacement of a mode at the contact, by noise
SATURATION = 2.0  # c: transients of kang2009 end 9.9 to 10 nepers above 1 nm, p0 / k_c being 10 um
_LEAST_DAMPING_RATIO = 0.001  # of modes without damping of their own, as in the transients
# 1/s; nearer to zero the stationary energy has no end: in double precision, and in single
_LEAST_RATE, _LEAST_OF_SINGLE = 1e-6, 1e-3


def saturation_energy(contact_pressure: ArrayLike, contact_stiffness: ArrayLike,
                      noise_floor: float = FLOOR) -> FloatArray:
    """
    Return the energy over the floor's at which a tone saturates.

    Parameters
    ----------
    contact_pressure : array_like
        p0 [Pa].
    contact_stiffness : array_like
        k_c [N/m^3].
    noise_floor : float
        [m].

    """
    gap = np.asarray(contact_pressure, dtype=float) / np.asarray(contact_stiffness, dtype=float)
    return np.asarray(np.maximum(SATURATION * gap / noise_floor, 1.0)**2)


def noise_decay(decay_rate: ArrayLike, frequency_hz: ArrayLike) -> FloatArray:
    """Return the decay rates d [1/s] at which noise holds modes at their floors."""
    least = _LEAST_DAMPING_RATIO * 2.0 * np.pi * np.asarray(frequency_hz)
    return np.asarray(np.maximum(decay_rate, least))


def nepers(energy: RealArray) -> RealArray:
    """Return the build-up of an energy over the floor's."""
    return np.asarray(0.5 * np.log(energy))


def grown(energy: RealArray, growth_rate: RealArray, duration: float | RealArray,
          decay_rate: RealArray, cap: RealArray) -> RealArray:
    """
    Return the energies after a time at constant growth rates, exactly; all arrays broadcast.

    Parameters
    ----------
    energy : array
        Over the floor's.
    growth_rate : array
        sigma [1/s]. Where it is NaN nothing is known and nothing added.
    duration : float or array
        [s].
    decay_rate : array
        d [1/s]: the growth rate at which noise holds the floor is -d.
    cap : array
        Energy at saturation.

    """
    return after(energy, *gain_and_noise(growth_rate, duration, decay_rate), cap)


def gain_and_noise(growth_rate: RealArray, duration: float | RealArray,
                   decay_rate: RealArray) -> tuple[RealArray, RealArray]:
    """Return the factor on energies over a time, and d / sigma; for `after`."""
    least = _LEAST_OF_SINGLE if growth_rate.dtype == np.float32 else _LEAST_RATE
    size = np.abs(growth_rate)
    usual = size.min(initial=np.inf) >= least  # not where a rate is NaN
    rate = growth_rate if usual else np.where(size < least, least, growth_rate)
    gain = np.asarray((2.0 * duration) * rate)
    with np.errstate(over='ignore'):  # the cap ends it
        np.exp(gain, out=gain)
    noise = np.asarray(decay_rate / rate)
    if not usual:
        gain[np.isnan(gain)], noise[np.isnan(noise)] = 1.0, 0.0
    return gain, noise


def after(energy: RealArray, gain: RealArray, noise: RealArray, cap: RealArray) -> RealArray:
    """Return the energies after a time by what `gain_and_noise` returns of it."""
    result = np.asarray(energy + noise)
    with np.errstate(over='ignore'):
        result *= gain
    result -= noise
    return np.minimum(result, cap, out=result)


def halves(before: RealArray, now: RealArray, *, edge: bool) -> RealArray:
    """
    Return the growth rates (2, ...) of the two halves of the time between two ticks.

    Both ways their mean is that of the ticks (trapezoidal rule). Along a change that goes on
    over the whole time they are those of its quarter points. At an edge, where sliding under load
    begins or ends at an unknown moment between the ticks, it does so in the middle.
    """
    if edge:
        return np.stack([before, now])
    quarter = 0.25 * (now - before)
    return np.stack([before + quarter, now - quarter])

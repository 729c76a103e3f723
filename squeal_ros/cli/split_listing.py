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

"""Output of `squeal sensitivity --split-doublet`: growth rates over the angle of the masses."""

import argparse
from collections.abc import Iterator
from dataclasses import asdict
import math
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.studies.led_doublet import led_doublet
from squeal_core.studies.split_doublet import ModeOverAngle, SplitDoublet, SplitGrowth
from squeal_ros.cli.listing import point_in_words

_SLOW = 0.25  # of n Omega over the split: exchange of the two modes is some 5 % then
_UNSPLIT = 1e-3  # Hz: a doublet that masses leave as it is
_SHOWN = 6  # modes, those that grow most at some angle


def turning(masses: SplitDoublet, point: OperatingPoint) -> float:
    """Return the rate n Omega at which the doublet's axes turn, over its split 2 pi df [-]."""
    first, second = masses.frequencies_hz
    return masses.diameters * abs(point.rotor_speed) / (math.tau * (second - first))


def limits(masses: SplitDoublet, point: OperatingPoint) -> str:
    """Return the limits within which the answer holds, in words."""
    first, second = masses.frequencies_hz
    ratio = turning(masses, point)
    return ('frozen contact: each angle of the masses to the pads is solved as if the disc stayed '
            f'there. It turns: n x rotor speed is {ratio:.2g} of the split of '
            f'{second - first:.3g} Hz ({_slow(ratio)}). The mean over angles is what a tone '
            'gathers over turns, the largest what it gathers while a mass passes')


def _slow(ratio: float) -> str:
    return ('slow against the split, modes can follow' if ratio < _SLOW else
            'not slow: rotation mixes the two again, and growth at frozen angles does not hold')


def side_effect(masses: SplitDoublet, growth: SplitGrowth,
                point: OperatingPoint) -> dict[str, Any] | None:
    """Return the mode of another doublet that grows most at some angle; how fast it turns."""
    for mode in _shown(growth):
        result = led_doublet(masses, point, mode)
        if np.nanmax(mode.over_angle) > 0.0 and result and result[0] != masses.diameters:
            diameters, split = result
            rate = diameters * abs(point.rotor_speed) / math.tau
            return {'identity': str(mode.identity), 'frequency_hz': mode.frequency_hz,
                    'nodal_diameters': diameters, 'split_hz': split,
                    'turning_over_split': rate / split if split > _UNSPLIT else math.inf}
    return None


def _shown(growth: SplitGrowth) -> list[ModeOverAngle]:
    return sorted(growth.modes[1:], key=lambda mode: -np.nanmax(mode.over_angle))[:_SHOWN]


def split_lines(model: BrakeModel, masses: SplitDoublet, growth: SplitGrowth,
                point: OperatingPoint) -> Iterator[str]:
    """Yield the table."""
    yield point_in_words(model, point)
    first, second = masses.frequencies_hz
    yield (f'{masses.count} masses of {1e3 * masses.mass:.3g} g every '
           f'{180.0 / masses.diameters:.4g} deg at radius {1e3 * masses.ring.radius:.4g} mm split '
           f'the doublet of {masses.diameters} nodal diameters ({masses.bare_hz:.1f} Hz without '
           f'them) by {100.0 * masses.split:.3g} %: '
           f'{first:.1f} and {second:.1f} Hz of the free disc')
    yield limits(masses, point)
    yield (f'{"mode":>12} {"Hz":>7} {"without 1/s":>11} {"mean":>9} {"least":>9} {"largest":>9} '
           f'{"at deg":>6}  growth rate with masses, over the angle')
    yield _line('least stable', growth.least_stable, growth.angles)
    for mode in (growth.modes[0], *_shown(growth)):
        yield _line(str(mode.identity), mode, growth.angles)
    if side := side_effect(masses, growth, point):
        ratio = side['turning_over_split']
        yield (f'mode {side["identity"]} ({side["frequency_hz"]:.0f} Hz) is led by another '
               f'doublet, of {(n := side["nodal_diameters"])} nodal diameters: {n} x rotor speed '
               f'is {ratio:.2g} of its split of {side["split_hz"]:.3g} Hz ({_slow(ratio)})')


def _line(name: str, mode: ModeOverAngle, angles: Any) -> str:
    place = int(np.nanargmax(mode.over_angle))
    return (f'{name:>12} {mode.frequency_hz:7.0f} {mode.without:+11.2f} '
            f'{np.nanmean(mode.over_angle):+9.2f} {np.nanmin(mode.over_angle):+9.2f} '
            f'{mode.over_angle[place]:+9.2f} {math.degrees(angles[place]):6.1f}')


def split_json(masses: SplitDoublet, growth: SplitGrowth, point: OperatingPoint,
               options: argparse.Namespace) -> dict[str, Any]:
    """Return the output of `--json`."""
    def mode_json(mode: ModeOverAngle) -> dict[str, Any]:
        return {'identity': str(mode.identity), 'frequency_hz': mode.frequency_hz,
                'growth_rate_without': mode.without, 'growth_rates': mode.over_angle.tolist(),
                'mean': float(np.nanmean(mode.over_angle))}

    return {
        'model': str(options.model), 'point': asdict(point), 'nodal_diameters': masses.diameters,
        'masses': masses.count, 'mass_g': 1e3 * masses.mass, 'radius_mm': 1e3 * masses.ring.radius,
        'split_percent': 100.0 * masses.split, 'frequencies_hz': list(masses.frequencies_hz),
        'frequency_without_hz': masses.bare_hz, 'side_effect': side_effect(masses, growth, point),
        'turning_over_split': turning(masses, point), 'limits': limits(masses, point),
        'angles_deg': np.degrees(growth.angles).tolist(),
        'least_stable': mode_json(growth.least_stable),
        'modes': [mode_json(mode) for mode in growth.modes], 'plot': options.plot}

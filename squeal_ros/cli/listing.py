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

"""Modes as lines of text, squeal before groan before divergence."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import SQUEAL_BAND
from squeal_core.studies.point_options import brake_pressure
from squeal_core.studies.sweep_file import UNITS
from squeal_core.studies.sweep_record import Sweep

_SHOWN = 3  # unstable modes in a line; the record holds all
_HEADINGS = {'friction': 'friction', **{
    name: f'{name.replace("_", " ")} {unit}' for name, unit in UNITS.items() if unit != '-'}}


def squeals(kind: str, hertz: float) -> bool:
    """Return whether a mode is squeal: flutter in the audible squeal band."""
    return kind == 'flutter' and SQUEAL_BAND[0] <= hertz <= SQUEAL_BAND[1]


def rank(kind: str, hertz: float, growth: float) -> tuple[int, float]:
    """Return a key that sorts squeal first, then other flutter, then divergence; worst first."""
    kinds = ('flutter', 'divergence', 'stable', 'rigid')
    return (0 if squeals(kind, hertz) else 1 + kinds.index(kind)), -growth


def counts_in_words(modes: Sequence[tuple[str, float]]) -> str:
    """Return the unstable modes (kind, Hz) counted by kind: `1 squeal, 2 divergence`."""
    squeal = sum(squeals(*mode) for mode in modes)
    flutter = sum(kind == 'flutter' for kind, _ in modes) - squeal
    band = f'{SQUEAL_BAND[0]:g}-{SQUEAL_BAND[1]:g} Hz'
    parts = [f'{count} {name}' for count, name in (
        (squeal, f'squeal (flutter in {band})'), (flutter, 'flutter outside that band'),
        (len(modes) - squeal - flutter, 'divergence')) if count]
    return ', '.join(parts)


def points_in_words(counts: Mapping[str, Any]) -> str:
    """Return the number of points with an instability or boundary, in words; of loci ''."""
    kinds = {'squeal': 'squeal', 'flutter': 'flutter', 'divergence': 'divergence',
             'boundary': 'a stability boundary'}
    return ', '.join(f'{words} at {counts[name]}' for kind, words in kinds.items()
                     if (name := f'points_with_{kind}') in counts)


def point_in_words(model: BrakeModel, point: OperatingPoint) -> str:
    """Return an operating point in words; the brake pressure where the model has a caliper."""
    pressure, contact = brake_pressure(model, point), f'{point.contact_pressure / 1e5:.3f} bar'
    load = (f'contact pressure {contact}' if pressure is None else
            f'brake pressure {pressure / 1e5:.4g} bar (contact {contact})')
    return (f'rotor speed {point.rotor_speed:g} rad/s, friction {point.friction:.4g}, slope '
            f'{point.friction_slope:.4g} s/m, {load}, contact stiffness '
            f'{point.contact_stiffness:.4g} N/m^3')


def sweep_rows(record: Sweep, numbers: Sequence[int] = ()) -> Iterator[dict[str, Any]]:
    """
    Yield the swept parameters of each point that is done, and its unstable modes.

    Parameters
    ----------
    record : Sweep
        The sweep.
    numbers : sequence of int
        Modes that are followed: these are listed then, stable or not.

    """
    followed = {number: (record.of(number), record.names(number)) for number in numbers}
    for place in np.flatnonzero(record.done).tolist():
        row = {name: float(record.column(name)[place]) for name in record.axes}
        if numbers:
            yield {**row, 'modes': [_mode(str(names[place]), '', complex(eigenvalues[place]))
                                    for eigenvalues, names in followed.values()]}
            continue
        unstable = np.flatnonzero(record.unstable[place]).tolist()
        modes = [_mode(str(record.identities[place, i]), str(record.kinds[place, i]),
                       complex(record.eigenvalues[place, i])) for i in unstable]
        modes.sort(key=lambda m: rank(m['kind'], m['frequency_hz'], m['growth_rate']))
        yield {**row, 'unstable': modes}


def _mode(identity: str, kind: str, eigenvalue: complex) -> dict[str, Any]:
    return {'identity': identity, **({'kind': kind} if kind else {}),
            'frequency_hz': abs(eigenvalue.imag) / (2.0 * np.pi), 'growth_rate': eigenvalue.real}


def sweep_lines(record: Sweep, numbers: Sequence[int] = ()) -> Iterator[str]:
    """Yield a table of a sweep: a line a point."""
    columns = [_HEADINGS[name] for name in record.axes]
    what = 'modes' if numbers else 'unstable modes, squeal first'
    yield '  '.join([*(f'{name:>12}' for name in columns), '' if numbers else 'unstable',
                     f'{what}: number Hz (growth rate 1/s)']).rstrip()
    for row in sweep_rows(record, numbers):
        modes = row['modes' if numbers else 'unstable']
        shown = modes if numbers else modes[:_SHOWN]
        texts = [f'{m["identity"] or "?"}: {m["frequency_hz"]:.1f} ({m["growth_rate"]:+.3f})'
                 for m in shown]
        more = [f'and {len(modes) - len(shown)} more'] if len(modes) > len(shown) else []
        places = (f'{row[name]:>{max(12, len(heading))}.6g}'
                  for name, heading in zip(record.axes, columns, strict=True))
        yield '  '.join([*places, '' if numbers else f'{len(modes):8d}',
                         ', '.join([*texts, *more])]).rstrip()

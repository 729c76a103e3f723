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

"""Schedules of brake applications as on a dynamometer: drags and stops at start temperatures."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
import math
from pathlib import Path
from typing import Any, Literal, TypeAlias

from squeal_core.common.errors import BrakeDescriptionError, LocatedError
from squeal_core.common.quantities import Quantity, QuantityReader
from squeal_core.common.ranges import Warn, warn_implausible
from squeal_core.common.yaml_reader import read_yaml

Kind: TypeAlias = Literal['drag', 'deceleration']
ZERO_CELSIUS = 273.15
MAX_STOPS = 20_000
_KINDS: tuple[Kind, ...] = ('drag', 'deceleration')
_DIRECTIONS = {'forward': (1.0,), 'backward': (-1.0,), 'forward and backward': (1.0, -1.0)}
_SPEED = Quantity('road_speed', 0.1, 100.0, closed=True, plausible=(0.5, 60.0))
_END_SPEED = Quantity('road_speed', 0.0, 100.0, closed=True, default=0.0)
_PRESSURE = Quantity('pressure', 0.5e5, 300e5, closed=True, plausible=(1e5, 120e5))
_DECELERATION = Quantity('acceleration', 0.1, 15.0, closed=True, plausible=(0.3, 10.0))
_TEMPERATURE = Quantity('celsius', -50.0, 800.0, closed=True, default=math.nan,
                        plausible=(25.0, 600.0))
_DURATION = Quantity('time', 0.5, 3600.0, closed=True, plausible=(1.0, 600.0))
_PAUSE = Quantity('time', 0.0, 3600.0, closed=True, default=0.0)


class ScheduleError(LocatedError):
    """A schedule that cannot be used."""


@dataclass(frozen=True)
class Stop:
    """
    One brake application.

    Parameters
    ----------
    module : str
        Its name.
    kind : str
        'drag': the speed is held; 'deceleration': the vehicle slows down.
    speed : float
        At the start [m/s]; negative: backward.
    end_speed : float
        Magnitude at which a deceleration ends [m/s].
    pressure, deceleration : float
        Of the front brakes [Pa]; of the vehicle [m/s^2]. The one that is not given is NaN.
    temperature : float
        Mean of the front discs at the start [K]; NaN: as it comes.
    duration : float
        At most, of a deceleration [s].
    pause : float
        Afterwards, brakes released [s].

    """

    module: str
    kind: Kind
    speed: float
    end_speed: float
    pressure: float
    deceleration: float
    temperature: float
    duration: float
    pause: float


@dataclass(frozen=True)
class Conditioning:
    """
    Conditioning of discs to a start temperature: by driving released, or dragging.

    Parameters
    ----------
    cooling_speed, heating_speed : float
        [m/s].
    heating_pressure : float
        Of the front brakes [Pa].
    longest : float
        Time after which a start temperature counts as out of reach [s].

    """

    cooling_speed: float = 100.0 / 3.6
    heating_speed: float = 50.0 / 3.6
    heating_pressure: float = 15e5
    longest: float = 1800.0


@dataclass(frozen=True)
class Schedule:
    """Brake applications one after the other."""

    name: str
    stops: tuple[Stop, ...]
    conditioning: Conditioning = Conditioning()
    source: str = ''


def read_schedule(path: str | Path, *, warn: Warn = warn_implausible) -> Schedule:
    """
    Read a schedule from YAML.

    Parameters
    ----------
    path : path
        Where the file is; its stem becomes the name. Keys: `modules`, a list, and `source` and
        `conditioning` where wanted (docs/howto/schedules.md).
    warn : callable
        Given a text for each number that can be used but is unusual.

    Raises
    ------
    ScheduleError
        With the key's path, its value and the remedy.

    """
    path = Path(path)
    content = read_yaml(path, ScheduleError)
    if content is None:
        raise ScheduleError(path.name, 'is empty', 'write keys and values')
    try:
        whole = QuantityReader(path.name, content, warn=warn)
        source = whole.text('source', '')
        conditioning = _conditioning(whole.section('conditioning', required=False))
        modules = whole.sections('modules')
        whole.finish()
        stops = tuple(stop for module in modules for stop in _stops(module))
    except BrakeDescriptionError as error:
        raise ScheduleError(error.where, error.what, error.remedy) from None
    if len(stops) > MAX_STOPS:
        raise ScheduleError(path.name, f'has {len(stops)} brake applications',
                            f'give at most {MAX_STOPS}')
    return Schedule(path.stem, stops, conditioning, source)


def _conditioning(section: QuantityReader | None) -> Conditioning:
    if section is None:
        return Conditioning()
    usual = Conditioning()

    def number(name: str, quantity: Quantity) -> float:
        default: float = getattr(usual, name)
        return section.number(name, Quantity(
            quantity.dimension, quantity.above, quantity.below, True, default,
            quantity.plausible))

    result = Conditioning(number('cooling_speed', _SPEED), number('heating_speed', _SPEED),
                          number('heating_pressure', _PRESSURE),
                          number('longest', Quantity('time', 1.0, 1e5)))
    section.finish()
    return result


def _stops(module: QuantityReader) -> Iterator[Stop]:
    """Yield the applications of a module: temperatures outermost, repetitions innermost."""
    kind: Any = module.choice('kind', _KINDS)
    name = module.text('name', kind)
    directions = _DIRECTIONS[module.choice('direction', tuple(_DIRECTIONS), 'forward')]
    temperatures = _values(module, 'temperature', _TEMPERATURE)
    speeds = _values(module, 'speed', _SPEED)
    slows = kind == 'deceleration'
    end = module.number('end_speed', _END_SPEED) if slows else 0.0
    by_deceleration = slows and any(str(key).startswith('deceleration') for key in module.content)
    forces = _values(module, 'deceleration', _DECELERATION) if by_deceleration else (
        _values(module, 'pressure', _PRESSURE))
    duration = module.number('duration', Quantity(
        'time', 0.5, 3600.0, True, 60.0, (1.0, 600.0)) if slows else _DURATION)
    pause = module.number('pause', _PAUSE)
    repetitions = module.count('repetitions', most=1000) if 'repetitions' in module.content else 1
    module.finish()
    if slows and end >= min(speeds):
        raise ScheduleError(module.path('end_speed'), f'is {3.6 * end:g} km/h',
                            f'give less than speed, {3.6 * min(speeds):g} km/h')
    for degrees, speed, force, _, sign in product(
            temperatures, speeds, forces, range(repetitions), directions):
        yield Stop(name, kind, sign * speed, end, math.nan if by_deceleration else force,
                   force if by_deceleration else math.nan, degrees + ZERO_CELSIUS, duration,
                   pause)


def _values(module: QuantityReader, name: str, quantity: Quantity) -> tuple[float, ...]:
    """Return the values of a quantity that may be one number or a list."""
    written: Any = next((value for key, value in module.content.items()
                         if str(key).startswith(name)), None)
    return module.quantities(name, quantity) if isinstance(written, list) else (
        module.number(name, quantity),)

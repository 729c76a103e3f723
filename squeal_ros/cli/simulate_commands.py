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


"""The command that simulates squeal in the time domain."""

import argparse
import json
import time
from typing import Any

import numpy as np
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import did_you_mean, SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.simulation import contact_points, OperatingHistory
from squeal_core.simulation import simulate as run_simulation
from squeal_core.simulation.levels import SimulatedEvent
from squeal_core.simulation.simulation_files import SimulationFiles
from squeal_core.stability.eigensolution import complex_modes
from squeal_ros.cli.arguments import operating_point, positive, shipped
from squeal_ros.cli.console import plain, ProgressBar, report_progress, warn
from squeal_ros.cli.drive_signals import drive_and_vehicle, signals_of
from squeal_ros.cli.point_checks import check_value

_RAMPED = ('rotor_speed', 'friction', 'pressure', 'preload')
_POINT = (*_RAMPED, 'friction_slope', 'friction_law', 'contact_stiffness', 'duration')
_SIGNAL_RATE = 100.0  # samples a second of the inputs of a drive
_LONGEST = 600.0  # s


def simulate(options: argparse.Namespace) -> int:
    """Integrate the nonlinear contact, write sound and events."""
    _check(options)
    model = BrakeModel.load(options.model)
    history = _of_drive(model, options) if options.drive else _of_points(model, options)
    files = SimulationFiles(options.output, history.brakes, levels=options.levels)
    files.prepare(overwrite=options.force)
    brake = read_brake(shipped('brakes', options.description, '.yaml'), warn=warn) \
        if options.description else None
    faces = contact_points(model, brake, progress=report_progress)
    begun = time.monotonic()
    first, duration = float(history.time[0]), float(history.time[-1] - history.time[0])
    with ProgressBar('ms simulated') as progress:
        result = run_simulation(
            model, faces, history, floor=options.floor, seed=options.seed,
            abutment=not options.free_pads, steps=options.steps, threshold=options.threshold_db,
            damping_scale=options.damping_scale,
            progress=lambda now: progress(round(1e3 * (now - first)), round(1e3 * duration)))
    about: dict[str, Any] = {
        'model': options.model, 'brakes': list(history.brakes), 'start_s': first,
        'duration_s': duration, 'seed': options.seed, 'floor_m': options.floor,
        'threshold_db': options.threshold_db, 'free_pads': options.free_pads,
        'steps': options.steps, 'damping_scale': options.damping_scale,
        'drive': options.drive,
        'sliding_s': (0.01 * result.sliding.sum(axis=0)).round(2).tolist()}
    files.write(result, about, overwrite=options.force)
    events = [_event_json(event) for event in result.events]
    if options.json:
        print(json.dumps(plain({**about, 'output': options.output, 'events': events,
                                'files': [str(path) for path in files.paths]})))
    else:
        _print(result.events, duration, history.brakes, time.monotonic() - begun)
        print(f'written: {", ".join(map(str, files.paths))}')
    return 0


def _event_json(event: SimulatedEvent) -> dict[str, Any]:
    return {'time_s': event.start, 'end_s': event.end, 'brake': event.brake, 'mode': event.mode,
            'frequency_hz': event.frequency_hz, 'level_db': event.level_db}


def _print(events: list[SimulatedEvent], duration: float, brakes: tuple[str, ...],
           seconds: float) -> None:
    print(f'{duration:g} s of {len(brakes)} brake{"s" if len(brakes) > 1 else ""} simulated in '
          f'{seconds:.0f} s; {len(events)} squeal event{"" if len(events) == 1 else "s"}')
    for event in events:
        print(f'{event.start:8.3f} to {event.end:8.3f} s  {event.brake}: mode {event.mode}, '
              f'{event.frequency_hz:.0f} Hz, {event.level_db:.0f} dB')


def _check(options: argparse.Namespace) -> None:
    """Refuse options that exclude each other, and numbers that nothing can follow."""
    mixed = [name for name in _POINT if getattr(options, name) not in (None, False)]
    if options.drive and mixed:
        raise SquealError(f'--{mixed[0].replace("_", "-")}: --drive says where the brakes '
                          'operate; give one of the two')
    if not options.drive and options.rotor_speed is None:
        raise SquealError('--rotor-speed: is missing; give it, or --drive CYCLE')
    for name, value in (('from', options.from_), ('to', options.to), ('brakes', options.brakes)):
        if value is not None and not options.drive:
            raise SquealError(f'--{name}: is of a --drive; give --duration with an operating '
                              'point')
    for name in _RAMPED:
        for value in getattr(options, name) or ():
            check_value(f'--{name.replace("_", "-")}', name, value)
    for name in ('friction_slope', 'contact_stiffness', 'damping_scale'):
        check_value(f'--{name.replace("_", "-")}', name, getattr(options, name))
    if not (0.0 <= options.floor <= 1e-3):
        raise SquealError(f'--floor: is {options.floor:g} m; give 0 to 1e-3 m, usual is 1e-9')
    if not 1 <= options.steps <= 100:
        raise SquealError(f'--steps: is {options.steps}; give 1 to 100')
    if options.seed < 0:
        raise SquealError(f'--seed: is {options.seed}; give 0 or more')
    if not np.isfinite(options.threshold_db):
        raise SquealError(f'--threshold-db: is {options.threshold_db}; give a finite number')


def _of_points(model: BrakeModel, options: argparse.Namespace) -> OperatingHistory:
    """Return a constant operating point, or a ramp from one to another."""
    duration = positive('--duration', 0.5 if options.duration is None else options.duration)
    _check_duration('--duration', duration)
    ends = [operating_point(model, argparse.Namespace(**{**vars(options), **{
        name: value[i] for name in _RAMPED if (value := getattr(options, name))}}))
        for i in (0, 1)]
    if options.free_pads:
        _refuse_divergence(model, ends)
    return OperatingHistory.ramps([ends[0]], [ends[1]], duration, ('brake',))


def _refuse_divergence(model: BrakeModel, points: list[OperatingPoint]) -> None:
    for point in points:
        for mode in complex_modes(model, point).unstable:
            if mode.kind == 'divergence':
                raise SquealError(
                    f'--free-pads: at {point.rotor_speed:g} rad/s the pads diverge at '
                    f'{mode.growth_rate:.3g} 1/s, as nothing holds them in plane; leave it out, '
                    'or describe supports of the pads')


def _of_drive(model: BrakeModel, options: argparse.Namespace) -> OperatingHistory:
    """Return the operating history of a vehicle's brakes in a part of a drive cycle."""
    cycle, vehicle = drive_and_vehicle(options.drive, options.vehicle)
    signals = signals_of(cycle, vehicle, model, rate=_SIGNAL_RATE)
    low = float(signals.time[0]) if options.from_ is None else options.from_
    high = float(signals.time[-1]) if options.to is None else options.to
    if not (signals.time[0] <= low < high <= signals.time[-1]):
        raise SquealError(f'--from, --to: are {low:g} and {high:g} s; give two times that rise, '
                          f'in {signals.time[0]:g} to {signals.time[-1]:g} s')
    _check_duration('--from, --to', high - low)
    columns = _columns(vehicle.brakes, options.brakes)
    within = np.flatnonzero((signals.time >= low - 0.5 / _SIGNAL_RATE)
                            & (signals.time <= high + 0.5 / _SIGNAL_RATE))
    if within.size < 2:
        raise SquealError(f'--from, --to: are {high - low:g} s apart; give at least '
                          f'{2.0 / _SIGNAL_RATE:g} s')
    pick = np.ix_(within, np.array(columns))
    history = OperatingHistory.of_signals(
        model, tuple(vehicle.brakes[i] for i in columns), time=signals.time[within],
        rotor_speed=signals.rotor_speed[pick], pressure=signals.pressure[pick],
        friction=signals.friction[pick])
    if not any(history.sliding(now).any() for now in history.time.tolist()):
        raise SquealError(f'--from, --to: no brake slides under load from {low:g} to {high:g} s '
                          f'of {options.drive}; give a part in which the vehicle brakes')
    return history


def _columns(brakes: tuple[str, ...], wanted: str | None) -> list[int]:
    names = wanted.split(',') if wanted else list(brakes)
    for name in names:
        if name not in brakes:
            raise SquealError(f'--brakes: {name!r} is none of the vehicle; give some of '
                              f'{",".join(brakes)}{did_you_mean(name, brakes)}')
    return [brakes.index(name) for name in dict.fromkeys(names)]


def _check_duration(option: str, duration: float) -> None:
    if duration > _LONGEST:
        raise SquealError(f'{option}: {duration:g} s are to be simulated, of which each takes '
                          f'some 30 s; give at most {_LONGEST:g} s')

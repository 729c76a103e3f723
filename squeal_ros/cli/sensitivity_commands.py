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

"""`squeal sensitivity`: sensitivities of a brake to its parameters."""

import argparse
from collections.abc import Callable
from functools import partial
import json
import math
from pathlib import Path

import numpy as np
from squeal_core.assembly.build import build_model, build_settings
from squeal_core.assembly.parts import PartCache
from squeal_core.assembly.variants import BrakeVariants
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.brake.design_parameters import design_parameters
from squeal_core.brake.dimensions import Brake, ModalResults
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common import resources
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import did_you_mean, short_repr, SquealError
from squeal_core.common.wording import listed
from squeal_core.model.affine_variants import AffineVariants
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.results.result_files import ReplayResult
from squeal_core.stability.eigensolution import SQUEAL_BAND
from squeal_core.stability.mode_tracking import identify
from squeal_core.studies.design_sensitivity import make_study, OPERATING
from squeal_core.studies.point_options import brake_pressure
from squeal_core.studies.split_doublet import split_growth, SplitDoublet
from squeal_core.studies.target_modes import target_modes
from squeal_core.studies.worst_points import worst_points
from squeal_ros.cli.arguments import (
    check_output,
    check_workers,
    DEFAULT_SPEED,
    is_description,
    is_there,
    PLOT_SUFFIXES,
    point_options,
    positive,
    shipped,
)
from squeal_ros.cli.console import plain, ProgressBar, report_progress, warn
from squeal_ros.cli.drive_signals import drive_and_vehicle, signals_of
from squeal_ros.cli.point_checks import check_numbers, check_point
from squeal_ros.cli.sensitivity_listing import (
    affine_only,
    sensitivity_json,
    sensitivity_lines,
    Units,
)
from squeal_ros.cli.split_listing import split_json, split_lines

_POINT = ('rotor_speed', 'friction', 'friction_slope', 'friction_law', 'preload', 'pressure',
          'contact_stiffness')
_OPERATING_UNITS = {'friction': '', 'rotor_speed': 'rad/s', 'contact_pressure': 'Pa'}
_MOST_MODES = 6
_MOST_DIAMETERS = 20
_COLUMNS = ('rotor_speed_rad_s', 'pressure_pa', 'friction')


def sensitivity(options: argparse.Namespace) -> int:
    """Print the effect of each parameter on the worst modes, per per cent."""
    _check(options)
    if options.split_doublet is not None:
        return _split(options)
    variants, units, note = _variants(options)
    if note and not options.json:
        print(note)
    parameters = _chosen(options, units)
    points, numbers = _points(options, variants.model)
    report_progress('modes, critical friction and risk')
    study = make_study(variants, points, numbers, count=options.count, duration=options.braking,
                       with_risk=not options.no_risk)
    with ProgressBar('parameters') as progress:
        effects = study.effects(parameters, workers=options.workers, progress=progress.timed)
    if options.plot:
        from squeal_core.view.tornado import plot_tornado
        plot_tornado(study, effects, units, options.plot, title=str(options.model),
                     overwrite=options.force)
    if options.json:
        print(json.dumps(plain(sensitivity_json(study, effects, units, note, options))))
    else:
        print('\n'.join(sensitivity_lines(study, effects, units, options.braking)))
    return 0


def _split(options: argparse.Namespace) -> int:
    """Print the effect of masses on the disc on growth rates."""
    variants, _, _ = _variants(options)
    model = variants.model
    masses = SplitDoublet.of(model, options.split_doublet, **(
        {'split': 0.01 * options.split} if options.grams is None
        else {'mass': 1e-3 * options.grams}))
    points, numbers = _points(options, model)
    point = points[0](model)
    tracked = identify(model, point)
    result = target_modes(model, point, tracked, numbers[0][:1], 1, SQUEAL_BAND)
    if not result:
        raise SquealError('no mode oscillates in the squeal band there; choose another point')
    with ProgressBar('angles') as progress:
        growth = split_growth(masses, result[0], tracked, progress=progress)
    if options.plot:
        from squeal_core.view.tornado import plot_over_angle
        plot_over_angle(masses, growth, result[0].point, options.plot, title=str(options.model),
                        pressure=brake_pressure(model, result[0].point),
                        overwrite=options.force)
    if options.json:
        print(json.dumps(plain(split_json(masses, growth, point, options))))
    else:
        print('\n'.join(split_lines(model, masses, growth, point)))
    return 0


def _check(options: argparse.Namespace) -> None:
    check_workers(options.workers)
    check_point(options)
    check_output('--plot', options.plot, PLOT_SUFFIXES, force=options.force)
    positive('--braking', options.braking)
    for name in ('split', 'grams'):
        if getattr(options, name) is not None:
            positive(f'--{name}', getattr(options, name))
            if options.split_doublet is None:
                raise SquealError(f'--{name}: says how far to split a doublet; add '
                                  '--split-doublet N')
    if options.split_doublet is not None and not 1 <= options.split_doublet <= _MOST_DIAMETERS:
        raise SquealError(f'--split-doublet: is {options.split_doublet}; give 1 to '
                          f'{_MOST_DIAMETERS} nodal diameters')
    options.split = options.split or 1.0
    if not 1 <= options.count <= _MOST_MODES:
        raise SquealError(f'--count: is {options.count}; give 1 to {_MOST_MODES}')
    if len(options.modes) > _MOST_MODES:
        raise SquealError(f'--modes: are {len(options.modes)}; give {_MOST_MODES} at most')
    given = [name for name in _POINT if getattr(options, name) not in (None, False)]
    if options.drive and given:
        raise SquealError(f'--drive: has operating points of its own; leave out '
                          f'--{given[0].replace("_", "-")}')
    if not options.drive and options.rotor_speed is None:
        options.rotor_speed = DEFAULT_SPEED


def _variants(options: argparse.Namespace) -> tuple[BrakeVariants | AffineVariants, Units, str]:
    """Return the models at changed values, their parameters, and what cannot be varied."""
    parts = PartCache(resources.cache_folder())
    if is_description(options.model):
        path = shipped('brakes', options.model, '.yaml')
        brake = read_brake(path, warn=warn)
        model = build_model(brake, progress=report_progress, parts=parts)
        # workers get their own: what was solved is on disk
        return _of_brake(model, path.parent, partial(
            build_model, parts=PartCache(resources.cache_folder()), audit=False))
    model = BrakeModel.load(options.model)
    if not isinstance(model.provenance.get('description'), dict):
        affine = AffineVariants(model)
        return affine, affine.parameters, affine_only(options.model)
    folder = Path(resources.find('models', options.model, '.npz')).parent
    return _of_brake(model, folder, partial(
        build_model, parts=parts, audit=False, **build_settings(model)))


def _of_brake(model: BrakeModel, folder: Path,
              build: Callable[[Brake], BrakeModel]) -> tuple[BrakeVariants, Units, str]:
    content = model.provenance['description']
    variants = BrakeVariants(model, content, folder, build)
    parts = (('disc', variants.brake.disc), ('pads', variants.brake.pads[0]))
    files = [name for name, part in parts if isinstance(part, ModalResults)]
    note = (f'modes of {" and ".join(files)} come from files: their dimensions and materials '
            'cannot be varied' if files else '')
    return variants, {one.path: (one.value, one.unit) for one in design_parameters(content)}, note


def _chosen(options: argparse.Namespace, units: Units) -> list[str]:
    """Return the parameters to vary, those of the operating point among them."""
    every = [*units, *OPERATING]
    units.update({name: (math.nan, unit) for name, unit in _OPERATING_UNITS.items()})
    for prefix in options.only:
        if not any(name.startswith(prefix) for name in every):
            raise SquealError(f'--only: {short_repr(prefix)} begins no parameter; give one of '
                              f'{listed(every, 40)}{did_you_mean(prefix, every)}')
    return [name for name in every if not options.only or any(
        name.startswith(prefix) for prefix in options.only)]


def _points(options: argparse.Namespace, model: BrakeModel
            ) -> tuple[list[Callable[[BrakeModel], OperatingPoint]], list[tuple[int, ...]]]:
    """Return operating points by model, and the modes that are meant at each."""
    check_numbers(options.modes, model.size)
    if not options.drive:
        return [point_options(options).at], [tuple(options.modes)]
    with ProgressBar('operating points') as progress:
        worst = worst_points(model, *_driven(options, model),
                             count=_MOST_MODES if options.modes else options.count,
                             progress=progress)
    if options.modes:
        worst = [one for one in worst if set(one.numbers) & set(options.modes)]
    if not worst:
        raise SquealError('--modes: none of them is the least stable anywhere in the drive; leave '
                          '--modes out, or give an operating point')
    return ([partial(_signals_point, one.rotor_speed, one.pressure, one.friction)
             for one in worst], [one.numbers[:1] for one in worst])


def _signals_point(rotor_speed: float, pressure: float, friction: float,
                   model: BrakeModel) -> OperatingPoint:
    return model.operating_point(rotor_speed=rotor_speed, pressure=pressure, friction=friction)


def _driven(options: argparse.Namespace,
            model: BrakeModel) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return rotor speeds, pressures and frictions of a result folder, a cycle or a schedule."""
    if is_there(Path(options.drive)) and Path(options.drive).is_dir():
        blocks = list(ReplayResult.load(options.drive).blocks(_COLUMNS))
        speed, pressure, friction = (np.concatenate([
            block.numbers[name] for block in blocks]) for name in _COLUMNS)
        return speed, pressure, friction
    signals = signals_of(*drive_and_vehicle(options.drive, options.vehicle), model, rate=2.0)
    return signals.rotor_speed.ravel(), signals.pressure.ravel(), signals.friction.ravel()

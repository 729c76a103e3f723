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

"""Plots that `squeal modes` draws: a mode's shape, still or moving, and bars."""

import argparse
from collections.abc import Sequence
import math
from pathlib import Path

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common import resources
from squeal_core.common.errors import short_repr, SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import ComplexModes, Mode, SQUEAL_BAND
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_core.stability.mechanism import Mechanism, mechanisms
from squeal_core.studies.point_options import brake_pressure
from squeal_ros.cli.arguments import check_output, PLOT_SUFFIXES
from squeal_ros.cli.command_parser import add_force

_KINDS = ('shape', 'damping', 'mechanism')
_THRESHOLD = 0.5  # %, of the damping ratio


def add_plot_options(p: argparse.ArgumentParser) -> None:
    """Add the options for plots of modes."""
    p.add_argument('--plot', metavar='FILE', help=f'a plot, {", ".join(PLOT_SUFFIXES)}; of a '
                   'shape .html too, which turns')
    p.add_argument('--plot-kind', choices=_KINDS, default='shape',
                   help='of --plot: shape of a mode (default), damping ratios of all modes in the '
                   'squeal band, or what adds up to the growth rate of a mode')
    p.add_argument('--animate', metavar='FILE', help='one cycle of the shape, .gif or .html')
    p.add_argument('--mode', metavar='NUMBER', help='whose plot, as the column `mode` has it; '
                   'default: the least stable one in the squeal band')
    p.add_argument('--threshold', type=float, default=_THRESHOLD, metavar='PERCENT',
                   help='of the damping ratio, below which a mode counts as squeal (default '
                   f'{_THRESHOLD:g}; industry uses 0.25 to 0.5)')
    p.add_argument('--title', default='')
    add_force(p)


def check_plots(options: argparse.Namespace) -> None:
    """Refuse before any work plots that could not be drawn or written."""
    model = resources.find('models', options.model, '.npz')
    suffixes = (*PLOT_SUFFIXES, '.html') if options.plot_kind == 'shape' else PLOT_SUFFIXES
    for option, path, kinds in (('--plot', options.plot, suffixes),
                                ('--animate', options.animate, ('.gif', '.html'))):
        check_output(option, path, kinds, force=options.force, inputs=(model,))
    if options.plot and options.animate and Path(options.plot) == Path(options.animate):
        raise SquealError(f'--animate: {options.animate} is that of --plot, too; give another')
    if not (math.isfinite(options.threshold) and 0.0 < options.threshold <= 100.0):
        raise SquealError(f'--threshold: is {options.threshold} %; give a positive number of '
                          'per cent, as 0.5')


def draw_plots(options: argparse.Namespace, model: BrakeModel, point: OperatingPoint,
               result: ComplexModes, numbers: Sequence[str]) -> None:
    """Draw the requested plots."""
    if options.plot and options.plot_kind == 'damping':
        _draw_damping(options, model, point, result, numbers)
    elif options.plot and options.plot_kind == 'mechanism':
        from squeal_core.view.mode_bars import plot_mechanism
        why = _mechanism(options.mode, model, point, result, numbers)
        plot_mechanism(why, options.plot, overwrite=options.force, **_words(
            options, model, point, why, numbers))
    if options.animate or options.plot and options.plot_kind == 'shape':
        _draw_shapes(options, model, point, result, numbers)


def _draw_damping(options: argparse.Namespace, model: BrakeModel, point: OperatingPoint,
                  result: ComplexModes, numbers: Sequence[str]) -> None:
    from squeal_core.view.mode_bars import damping_bars, plot_damping
    from squeal_core.view.slide import point_words
    bars = damping_bars(result.modes, numbers, options.threshold, SQUEAL_BAND)
    if not bars:
        raise SquealError('--plot-kind damping: no mode oscillates in {:g} to {:g} Hz at this '
                          'point'.format(*SQUEAL_BAND))
    plot_damping(bars, options.plot, threshold=options.threshold, overwrite=options.force,
                 title=options.title or 'Damping ratio of modes, below zero: unstable',
                 about=f'{_brake(model)}{point_words(point, brake_pressure(model, point))}')


def _draw_shapes(options: argparse.Namespace, model: BrakeModel, point: OperatingPoint,
                 result: ComplexModes, numbers: Sequence[str]) -> None:
    from squeal_core.view.mode_shape import animate_shape, check_shapes, plot_shape, shape_view
    check_shapes(model)
    why = _mechanism(options.mode, model, point, result, numbers)
    view = shape_view(model, mode_vectors(model, point, why.mode.eigenvalue).right,
                      **_words(options, model, point, why, numbers))
    for path, moving in ((options.plot if options.plot_kind == 'shape' else None, False),
                         (options.animate, True)):
        if path and Path(path).suffix == '.html':
            from squeal_core.view.mode_shape_page import write_shape_page
            write_shape_page(view, path, moving=moving, overwrite=options.force)
        elif path:
            (animate_shape if moving else plot_shape)(view, path, overwrite=options.force)


def _mechanism(wanted: str | None, model: BrakeModel, point: OperatingPoint, result: ComplexModes,
               numbers: Sequence[str]) -> Mechanism:
    mode = _chosen(wanted, result, numbers)
    return mechanisms(model, point, [mode], top=3)[0]


def _chosen(wanted: str | None, result: ComplexModes, numbers: Sequence[str]) -> Mode:
    """Return the mode of a number, of those that carry it the least stable one."""
    if wanted is None:
        mode = result.worst_in(*SQUEAL_BAND)
        if mode is None:
            raise SquealError('--plot: no mode oscillates in {:g} to {:g} Hz at this point; '
                              'choose one with --mode'.format(*SQUEAL_BAND))
        return mode
    own = [mode for mode in result.modes
           if numbers[mode.index - 1] == wanted or wanted in numbers[mode.index - 1].split('/')]
    if not own:
        raise SquealError(f'--mode: is {short_repr(wanted)}; give a number of the column `mode`, '
                          f'1 to {len(result.modes)} (`squeal modes ... --all` lists them)')
    mode = max(own, key=lambda one: one.growth_rate)
    if mode.kind == 'rigid':
        raise SquealError(f'--mode: {wanted} is a rigid motion, an eigenvalue at zero; choose '
                          'a mode that oscillates or grows')
    return mode


def _words(options: argparse.Namespace, model: BrakeModel, point: OperatingPoint, why: Mechanism,
           numbers: Sequence[str]) -> dict[str, str]:
    from squeal_core.view.slide import number, point_words
    mode = why.mode
    parts = ', '.join(f'{share.name} {share.fraction:.0%}' for share in why.participation)
    return {'title': options.title or (
        f'Mode {numbers[mode.index - 1]}: {mode.frequency_hz:.0f} Hz, growth rate '
        f'{number(mode.growth_rate)} 1/s, damping ratio {number(100.0 * mode.damping_ratio)} %'),
        'about': (f'{why.label}: {parts}. {_brake(model)}'
                  f'{point_words(point, brake_pressure(model, point))}')}


def _brake(model: BrakeModel) -> str:
    name = str(model.provenance.get('brake', ''))[:60]
    return f'{name}: ' if name else ''

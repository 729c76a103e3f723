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

"""The `squeal` command: reads arguments, calls the library, prints; computes nothing itself."""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy
from squeal_ros import interrupts  # noqa: I100

import argparse  # noqa: I100
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
import os
import sys
from types import ModuleType
from typing import Any

from squeal_core.common.errors import in_one_line, SquealError
from squeal_core.common.version import __version__
from squeal_core.stability.eigensolution import SQUEAL_BAND
from squeal_ros.cli import (
    advise_options,
    calibrate_options,
    compare_options,
    drive_options,
    fleet_options,
    listen_options,
    point_commands as commands,
    replay_options,
    report_options,
    sensitivity_options,
    signals_options,
    simulate_options,
)
from squeal_ros.cli.command_parser import (
    add_force,
    add_model,
    add_point,
    add_range,
    add_sweep,
    add_without_rotation,
    BAD_INPUT,
    CommandParser,
    mode_numbers,
)
from squeal_ros.cli.mode_plots import add_plot_options

GOOD, BAD_ANSWER, INTERRUPTED = 0, 1, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; 0 good, 1 the answer is bad, 2 the input is bad."""
    try:
        # told to end it ends as by Ctrl-C: processes stopped, half-written files gone
        with interrupts.InterruptOnce():
            return _run(arguments)
    except KeyboardInterrupt:
        print('squeal: interrupted', file=sys.stderr)
        return INTERRUPTED


def _run(arguments: Sequence[str] | None) -> int:
    top = parser()
    first = (sys.argv[1:] if arguments is None else list(arguments))[:1]
    if first and first[0].startswith('-') and first[0] not in ('-h', '--help', '--version'):
        top.error(f'unrecognized arguments: {first[0]}')  # argparse would miss the command only
    options, unknown = top.parse_known_args(arguments)
    if unknown:
        options.parser.error(f'unrecognized arguments: {" ".join(unknown)}')
    run: Callable[[argparse.Namespace], int] = options.run
    try:
        code = run(options)
        sys.stdout.flush()
    except (SquealError, ImportError) as error:
        print(f'squeal: {in_one_line(error)}{_remedy(error)}', file=sys.stderr)
        return BAD_INPUT
    except OSError as error:
        _drop_output()
        if isinstance(error, BrokenPipeError):  # as in `squeal modes ... | head`
            return GOOD
        print(f'squeal: {error.filename or "standard output"}: {error.strerror or error}; check '
              'path, rights and space', file=sys.stderr)
        return BAD_INPUT
    return code


def _drop_output() -> None:
    """Discard output that could not be written: the interpreter would try again as it ends."""
    stream = sys.__stdout__
    if stream is not None and sys.stdout is stream:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _remedy(error: Exception) -> str:
    """Return how to install a missing package, where the error does not say it."""
    missing = (error.name or '') if isinstance(error, ModuleNotFoundError) else ''
    if not missing.startswith('rcl') and not missing.endswith(('_msgs', '_interfaces')):
        return ''
    return "; source the setup of ROS 2 Jazzy, or pip install -e '.[ros]' in the checkout"


def parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command."""
    top = CommandParser(
        prog='squeal', description='Squeal stability of disc brakes: models, points, drives.')
    top.add_argument('--version', action='version', version=f'squeal_ros {__version__}')
    sub = top.add_subparsers(required=True, metavar='COMMAND')
    command = partial(_add_command, sub)
    _build(sub.add_parser('build', help='a brake description -> a modal brake model'))
    _info(sub.add_parser('info', help='what a model file holds'))
    _modes(sub.add_parser('modes', help='complex modes at an operating point'))
    _map(sub.add_parser('map', help='stability over one or two parameters'))
    _locus(sub.add_parser('locus', help='modes followed over a parameter'))
    _critical(sub.add_parser('critical', help='where a parameter has a mode begin to grow'))
    _tabulate(sub.add_parser('tabulate', help='precompute look-up table and growth emulator'))
    command('sensitivity', 'what to change on a brake: effects per per cent', sensitivity_options)
    command('advise', 'quiet pressures, and a map of the risk to export', advise_options)
    command('compare', 'models, variants and tables side by side', compare_options)
    command('simulate', 'squeal in the time domain: sound and events', simulate_options)
    command('calibrate', 'fit the ensemble of brakes to measured squeal', calibrate_options)
    command('listen', 'squeal in a sound: events, level, prominence', listen_options)
    _verify(sub.add_parser('verify', help='rerun the paper: what is reproduced, what is not'))
    _settings(sub.add_parser('settings', help='print monitor settings for given brakes'))
    _policy(sub.add_parser('policy', help='print the SROS2 policy of the node'))
    command('replay', 'the monitor over one or many recordings', replay_options)
    command('fleet', 'the monitor over the recordings of a fleet, on many processors',
            fleet_options)
    command('signals', 'what a recording holds, and a file for --signals', signals_options)
    command('drive', 'play or record a drive cycle or a schedule', drive_options)
    command('report', 'one page of what replays found', report_options)
    _demo(sub.add_parser('demo', help='node, player and replay of a drive, end to end'))
    return top


def _add_command(sub: Any, name: str, about: str, options: ModuleType) -> None:
    """Add a command of the module NAME_commands, with the options of NAME_options."""
    p = sub.add_parser(name, help=about, description=options.DESCRIPTION)
    p.set_defaults(run=_from_module(f'{name}_commands', name))
    options.add_options(p)


def _build(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.build)
    p.add_argument('brake', metavar='BRAKE.yaml', help='brake description, or a shipped name')
    p.add_argument('-o', '--output', required=True, metavar='MODEL.npz')
    add_force(p)
    p.add_argument('--follower', action='store_true',
                   help='keep the in-plane follower force, which K09 leaves out')
    p.add_argument('--json', action='store_true')


def _info(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.info)
    add_model(p)
    p.add_argument('--json', action='store_true')


def _modes(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.modes)
    add_model(p)
    add_point(p, needs_speed=True)
    add_without_rotation(p)
    p.add_argument('--all', action='store_true', help='list stable modes too')
    p.add_argument('--json', action='store_true')
    add_plot_options(p)


def _map(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=_analysis('stability_map'))
    add_sweep(p, 'default: contact_stiffness from 1 to 200 %% of nominal')
    add_without_rotation(p)
    p.add_argument('--band', type=float, nargs=2, default=SQUEAL_BAND, metavar=('LOW', 'HIGH'),
                   help='Hz, of the least stable mode over several parameters')
    p.add_argument('--exact', action='store_true', help='solve every point in full')
    p.add_argument('--error', type=float, metavar='1/S',
                   help='of growth rates that are not (default: 0.1 1/s for kang2009)')


def _locus(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=_analysis('locus'))
    add_sweep(p, 'default: friction=0:0.8:81')
    p.add_argument('--modes', type=mode_numbers, default=[], metavar='25,26',
                   help='whose loci to plot: mode numbers, by frequency at mu = 0; default: '
                   'growth rates of all')
    p.add_argument('--plot-kind', choices=('lines', 'bubbles'), default='lines',
                   help='of --plot: lines (default), or the frequencies of all modes, unstable '
                   'ones as bubbles by damping ratio, coloured by mechanism')
    p.add_argument('--without-rotation', action='store_true',
                   help='the disc that does not rotate too: in the plot of --modes, and as '
                   'FILE_without_rotation')


def _verify(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=_analysis('verify'))
    p.add_argument('model', nargs='?', default='kang2009', metavar='MODEL')
    p.add_argument('--figures', metavar='FOLDER', help='write figures 8 to 16 as PNG')
    add_force(p)
    p.add_argument('--workers', type=int, default=0, metavar='N', help='processes (default: one)')
    p.add_argument('--json', action='store_true')


def _critical(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=_analysis('critical'))
    add_sweep(p, 'default: none, one point')
    p.add_argument('--parameter', default='friction', metavar='NAME', help='default friction')
    p.add_argument('--bounds', type=float, nargs=2, metavar=('LOW', 'HIGH'),
                   help='default: friction 0 to 1, else up to twice what it is')
    p.add_argument('--modes', type=mode_numbers, default=[], metavar='13,14',
                   help='mode numbers, by frequency at mu = 0; default, and always along a '
                   'number of the brake description: any in the band')
    p.add_argument('--band', type=float, nargs=2, default=SQUEAL_BAND, metavar=('LOW', 'HIGH'),
                   help='Hz, default {:g} {:g}'.format(*SQUEAL_BAND))
    add_without_rotation(p)


def _tabulate(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=_from_module('table_commands', 'tabulate'))
    add_model(p)
    p.add_argument('-o', '--output', metavar='TABLE.npz',
                   help="default: the user's cache, where the monitor finds it")
    add_force(p)
    add_range(p, '--rotor-speed', 'rad/s (default 0.5 to 120)')
    load = p.add_mutually_exclusive_group()
    add_range(load, '--pressure', 'Pa')
    add_range(load, '--preload', 'N, of one pad (default 100 to 20000)')
    add_range(p, '--friction', 'default 0.001 to 0.65')
    p.add_argument('--stiffness-factor', type=float, default=1.0, metavar='X',
                   help="on the model's contact stiffness (default 1)")
    growth = p.add_mutually_exclusive_group()
    growth.add_argument('--growth-only', action='store_true',
                        help='build the emulator of growth rates alone, TABLE.growth.npz; it '
                        'takes a minute or two')
    growth.add_argument('--no-growth', action='store_true', help='build the table alone')
    p.add_argument('--drive', metavar='CYCLE', help='only the cells in which the four brakes of '
                   'a vehicle operate in a drive cycle')
    p.add_argument('--vehicle', default='midsize', metavar='VEHICLE.yaml')
    p.add_argument('--duration', type=float, metavar='S', help='only the first seconds')
    p.add_argument('--tolerance', type=float, metavar='1/S',
                   help="of growth rates (default: 4.9e-7 of the model's largest angular "
                        'frequency; 0.1 1/s for kang2009)')
    p.add_argument('--workers', type=int, default=os.cpu_count() or 1, metavar='N',
                   help='processes (default: one for each core)')
    p.add_argument('--json', action='store_true')


def _analysis(name: str) -> Callable[[argparse.Namespace], int]:
    return _from_module('sweep_commands', name)


def _from_module(module: str, name: str) -> Callable[[argparse.Namespace], int]:
    """Return a command of a module of `squeal_ros.cli`, imported when it is run."""
    def run(options: argparse.Namespace) -> int:
        command: Callable[[argparse.Namespace], int] = getattr(
            import_module(f'squeal_ros.cli.{module}'), name)
        return command(options)
    return run


def _settings(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.settings)
    p.add_argument('brakes', nargs='*', metavar='BRAKE', help="names (default: a car's four)")


def _policy(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.policy)
    p.add_argument('--config', metavar='MONITOR.yaml', help='default: the shipped settings')
    p.add_argument('--namespace', default='/', help='of the node')


def _demo(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.demo)
    drive_options.add_cycle(p)
    p.add_argument('--speed-up', type=float, default=8.0, metavar='X', help='default 8')
    p.add_argument('--rate', type=float, default=1.0, metavar='HZ',
                   help='assessments a second of the drive (default 1)')
    p.add_argument('--config', metavar='MONITOR.yaml', help='default: the shipped settings')
    p.add_argument('--output', default='demo_output', metavar='FOLDER')
    add_force(p)

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

"""Commands of `squeal` on models: results on stdout, progress on stderr."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
import json
import math
from pathlib import Path
import sys
from typing import Any

import numpy as np
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common import resources
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.model_file import read_model
from squeal_core.monitor.settings import load_settings
from squeal_core.monitor.settings_document import settings_document
from squeal_core.risk.emulator_file import is_emulator, read_emulator_header
from squeal_core.stability.coupling import FrictionCoupling
from squeal_core.stability.eigensolution import complex_modes, Mode
from squeal_core.stability.eigenvectors import eigenvalue_conditions, EigenvalueCondition
from squeal_core.stability.mechanism import Mechanism, mechanisms, without_rotation
from squeal_core.stability.mode_tracking import identities
from squeal_core.stability.sensitivity import parameter_sensitivity
from squeal_core.surrogate.table_file import is_table, read_table_header
from squeal_ros.cli.arguments import check_output, operating_point, positive, shipped
from squeal_ros.cli.console import plain, report_progress, warn
from squeal_ros.cli.drive_signals import chosen_drive, signals_of
from squeal_ros.cli.listing import counts_in_words, point_in_words, rank
from squeal_ros.cli.mode_plots import check_plots, draw_plots
from squeal_ros.cli.model_info import model_lines
from squeal_ros.cli.point_checks import check_point
from squeal_ros.cli.table_info import (
    emulator_lines,
    model_emulator_lines,
    model_table_lines,
    table_lines,
)


def build(options: argparse.Namespace) -> int:
    """Build a modal brake model from a brake description."""
    from squeal_core.assembly.build import build_model

    path = shipped('brakes', options.brake, '.yaml')
    check_output('--output', options.output, force=options.force, inputs=(path,))
    brake = read_brake(path, warn=warn)
    model = build_model(brake, progress=report_progress, follower=options.follower)
    model.save(options.output, overwrite=options.force)
    for check in model.provenance['audit']:
        if not check['passed']:
            print(f'squeal: warning: {check["name"]} is {check["value"]:.3g}, limit '
                  f'{check["limit"]:g} ({check["meaning"]})', file=sys.stderr)
    if options.json:
        print(json.dumps(plain({'output': options.output, 'brake': brake.name,
                                'modes': model.size, 'audit': model.provenance['audit']})))
    else:
        print(f'{options.output}: {brake.name}, {model.size} modes')
    return 0


def info(options: argparse.Namespace) -> int:
    """Show the contents of a model file, or of the file of a table or of a growth emulator."""
    if is_emulator(options.model):
        print(json.dumps(plain(read_emulator_header(options.model))) if options.json
              else '\n'.join(emulator_lines(options.model)))
        return 0
    if is_table(options.model):
        print(json.dumps(plain(read_table_header(options.model))) if options.json
              else '\n'.join(table_lines(options.model)))
        return 0
    header, model = read_model(options.model, BrakeModel)
    if options.json:
        frequencies = (model.angular_frequencies / 2.0 / np.pi).tolist()
        print(json.dumps(plain({**header, 'frequencies_hz': frequencies})))
    else:
        for line in model_lines(header, model, options.model):
            print(line)
        for lines in (model_table_lines, model_emulator_lines):
            print('\n'.join(lines(model, options.model)))
    return 0


def modes(options: argparse.Namespace) -> int:
    """Show the complex modes at an operating point."""
    check_point(options)
    check_plots(options)
    model = BrakeModel.load(options.model)
    if options.without_rotation:
        model = without_rotation(model)
    point = operating_point(model, options)
    result = complex_modes(model, point)
    why = {item.mode.index: item for item in mechanisms(model, point, result.unstable)}
    numbers = [str(identity) for identity in identities(model, point)]
    coupled = [item.mode for item in why.values() if item.label == 'mode coupling']
    coupling = FrictionCoupling(model, point, result.modes) if coupled else None
    partners = {mode.index: numbers[other.index - 1] for mode in coupled
                if coupling and (other := coupling.partner(mode))}
    draw_plots(options, model, point, result, numbers)
    if options.json:
        worth = eigenvalue_conditions(model, point, result.modes)
        print(json.dumps(plain({
            'model': options.model, 'rotation': not options.without_rotation,
            'point': asdict(point), 'plot': options.plot, 'animation': options.animate,
            'modes': [{**_mode_json(mode, numbers[mode.index - 1], own),
                       **_mechanism_json(model, point, why.get(mode.index)),
                       'coupled_with': partners.get(mode.index)}
                      for mode, own in zip(result.modes, worth, strict=True)]})))
        return 0
    print(point_in_words(model, point))
    words = counts_in_words([(mode.kind, mode.frequency_hz) for mode in result.unstable])
    print(f'{len(result.unstable)} of {len(result.modes)} modes are unstable'
          f'{f": {words}" if words else ""}')
    shown = result.modes if options.all else sorted(
        result.unstable, key=lambda mode: rank(mode.kind, mode.frequency_hz, mode.growth_rate))
    _print_modes(shown, numbers, why, partners)
    written = [path for path in (options.plot, options.animate) if path]
    if written:
        print(f'written: {", ".join(written)}')
    return 0


def _print_modes(shown: Sequence[Mode], numbers: Sequence[str],
                 why: Mapping[int, Mechanism], partners: Mapping[int, str]) -> None:
    print(f'{"index":>5} {"mode":>6} {"kind":>10} {"Hz":>10} {"growth 1/s":>11} '
          f'{"damping ratio":>14}  mechanism: shares of kinetic energy'
          + (' (pad 1: top, pad 2: bottom)' if why else ''))
    for m in shown:
        print(f'{m.index:5d} {numbers[m.index - 1]:>6} {m.kind:>10} {m.frequency_hz:10.2f} '
              f'{m.growth_rate:+11.3f} {m.damping_ratio:+14.6f}  '
              f'{_in_brief(why.get(m.index), partners.get(m.index))}'.rstrip())


def settings(options: argparse.Namespace) -> int:
    """Print a settings file with every key explained."""
    print(settings_document(tuple(options.brakes)), end='')
    return 0


def policy(options: argparse.Namespace) -> int:
    """Print the SROS2 policy of the node with these settings."""
    from squeal_ros.node.sros2_policy import policy_document
    chosen = load_settings(options.config or resources.config_folder() / 'monitor.yaml')
    print(policy_document(chosen, options.namespace), end='')
    return 0


def demo(options: argparse.Namespace) -> int:
    """Run node, player and replay together."""
    from squeal_core.view.drive_plot import plot_drive
    from squeal_core.view.table import drive_console, DriveDisplay, events_table
    from squeal_ros.cli import demo as demos

    rate, speed_up = positive('--rate', options.rate), positive('--speed-up', options.speed_up)
    cycle, vehicle = chosen_drive(options)
    config = Path(options.config or demos.default_config())
    driven = load_settings(config)
    chosen = replace(driven, rate=rate)
    if not options.config:
        chosen = replace(chosen, model=demos.MODEL)
    model = BrakeModel.load(chosen.model)
    signals = signals_of(cycle, vehicle, model, rate=10.0, duration=options.duration)
    files = demos.DemoFiles(folder=Path(options.output))
    files.prepare(force=options.force)
    console = drive_console()
    console.print(f'{cycle.name}: {signals.time[-1]:.0f} s of driving at {speed_up:g} x real '
                  f'time, {rate:g} assessments a second of the drive; squeal_monitor runs as '
                  'its own process')
    if rate < driven.rate:
        console.print(f'a vehicle has {driven.rate:g} a second; the demo has fewer (--rate), as '
                      'its drive runs faster: a note on short squeals is of that')
    with demos.own_domain() as domain:
        console.print(demos.how_to_listen(domain))
        live = demos.run_live(
            signals, config, files, DriveDisplay(console, cycle.name, warning=chosen.risk_warning),
            settings=chosen, speed_up=speed_up, domain=domain)
    report, events = demos.replay_inputs(files, chosen, model)
    for line in report.lines():
        console.print(line, markup=False)
    console.print(f'ticks done {live.ticks_done}, lost {live.ticks_lost}')
    console.print(demos.compare(files).in_words)
    if report.events_known:
        console.print(events_table(events))
    else:
        console.print(*report.event_lines(), markup=False)
    plot_drive(files.replayed_rows, events, files.plot,
               title=f'{cycle.name}, model {chosen.model}', wheel_radius=vehicle.wheel_radius,
               squeal_band_hz=(chosen.squeal_band_low_hz, chosen.squeal_band_high_hz),
               risk_warning=chosen.risk_warning)
    for what, path in files.described():
        console.print(f'{what}: {path}')
    return 0 if live.ticks_done and report.good else 1


def _in_brief(why: Mechanism | None, partner: str | None) -> str:
    if why is None:
        return ''
    coupled = f' with {partner}' if partner else ''
    parts = ', '.join(f'{share.name} {share.fraction:.0%}' for share in why.participation[:3])
    return f'{why.label}{coupled}: {parts}'


def _mode_json(mode: Mode, identity: str, worth: EigenvalueCondition) -> dict[str, Any]:
    """Return a mode as `--json` prints it, with the condition of its eigenvalue."""
    return {'index': mode.index, 'identity': identity, 'kind': mode.kind,
            'frequency_hz': mode.frequency_hz, 'growth_rate': mode.growth_rate,
            'damping_ratio': mode.damping_ratio, 'backward_error': worth.backward_error,
            'condition': worth.condition, 'error_bound': worth.error}


def _mechanism_json(model: BrakeModel, point: OperatingPoint,
                    why: Mechanism | None) -> dict[str, Any]:
    """Return the mechanism of an unstable mode and its sensitivities; of other modes None each."""
    if why is None:
        return dict.fromkeys(('mechanism', 'participation', 'contributions', 'without',
                              'sensitivity'))
    moves = parameter_sensitivity(model, point, why.mode.eigenvalue)
    return {'mechanism': why.label,
            'participation': {s.name: s.fraction for s in why.participation},
            'contributions': dict(why.contributions), 'without': dict(why.without),
            'sensitivity': {name: {'growth_rate': slope.real,
                                   'frequency_hz': slope.imag / (2.0 * math.pi)}
                            for name, slope in moves.items()}}

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

"""Settings of the monitor with the brakes and inputs of a file of signals in place of theirs."""

from dataclasses import replace
from typing import Any

from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.axles import axle_partners
from squeal_core.monitor.brake_settings import BrakeSettings, check_friction, InputSettings
from squeal_core.monitor.setting_specs import input_keys, Signal
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.recordings.signals.signals_file import Signals, SignalsError, SignalSource

COLUMN = 'column'  # the type of an input that no topic feeds


def settings_with_signals(settings: MonitorSettings, signals: Signals) -> MonitorSettings:
    """
    Return settings of the brakes in a file of signals, each with the inputs that it names.

    What the file does not say of an input is as in the settings, where they have a brake of that
    name, else as `squeal settings` has it.

    Parameters
    ----------
    settings : MonitorSettings
        All but brakes and inputs is theirs.
    signals : Signals
        As `Signals.of` returns it: of columns or of topics.

    Raises
    ------
    SignalsError
        For a value out of its range, or axles of the settings that these brakes do not have.

    """
    before = {brake.name: brake.inputs for brake in settings.brakes}
    inputs: dict[str, dict[Signal, InputSettings]] = {}
    for source in signals.sources:
        known = before.get(source.brake, {}).get(source.signal)
        inputs.setdefault(source.brake, {})[source.signal] = _input(source, known)
    brakes = tuple(BrakeSettings(name, result, signals.frictions.get(name, 0.0))
                   for name, result in inputs.items())
    for brake in brakes:
        _check_friction(signals, brake, settings)
    try:
        axle_partners(list(inputs), settings.axles)
    except ConfigurationError as error:
        raise SignalsError(
            signals.path, f'names the brakes {", ".join(inputs)}, and the settings other axles '
            f'({error})', 'name the brakes as the settings do') from None
    return replace(settings, brakes=brakes)


def _check_friction(signals: Signals, brake: BrakeSettings, settings: MonitorSettings) -> None:
    try:
        check_friction(brake, settings.validated_friction_low, settings.validated_friction_high)
    except ConfigurationError as error:
        raise SignalsError(signals.path, f'{error.where} {error.what}', error.remedy) from None


def _input(source: SignalSource, known: InputSettings | None) -> InputSettings:
    specs = {spec.name.rpartition('.')[2]: spec
             for spec in input_keys(source.brake, source.signal)
             if not spec.name.endswith('.constant')}
    values: dict[str, Any] = {name: getattr(known, name) if known else spec.default
                              for name, spec in specs.items()}
    try:
        values |= {name: specs[name].read(value) for name, value in source.passed_on.items()}
    except ConfigurationError as error:
        raise SignalsError(source.where, f'{str(error.where).rpartition(".")[2]} {error.what}',
                           error.remedy) from None
    values |= {'topic': source.name, 'scale': source.scale, 'offset': source.offset}
    if source.kind == 'column':
        values |= {'type': COLUMN, 'field': '', 'stamp': 'header'}
    else:
        values |= {name: getattr(source, name) for name in ('type', 'field', 'stamp')
                   if getattr(source, name)}
    if not values['minimum'] < values['maximum']:
        raise SignalsError(source.where, f'maximum is {values["maximum"]:g} and minimum '
                           f'{values["minimum"]:g}', 'make it the larger')
    return InputSettings(**values)

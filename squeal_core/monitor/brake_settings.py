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

"""Settings of one brake: its inputs, or a constant friction, checked."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.setting_specs import input_keys, Signal, SIGNALS


@dataclass(frozen=True, kw_only=True)
class InputSettings:
    """Source of a signal, and limits of the values that are believed."""

    topic: str
    type: str  # noqa: A003
    field: str
    scale: float
    offset: float
    max_age: float
    minimum: float
    maximum: float
    stamp: str = 'header'
    stuck_after: float = 0.0
    movement: float = 1e-9
    reference: str = 'gauge'


@dataclass(frozen=True)
class BrakeSettings:
    """
    One brake.

    Parameters
    ----------
    name : str
    inputs : mapping
        An input without a topic is absent.
    constant_friction : float
        mu [-] where neither friction nor temperature is an input; else 0.

    """

    name: str
    inputs: Mapping[Signal, InputSettings]
    constant_friction: float = 0.0


def read_brake_settings(brake: str, parameters: Mapping[str, Any],
                        validated_friction: tuple[float, float]) -> BrakeSettings:
    """
    Return the settings of a brake, of flat parameters with defaults filled in.

    Raises
    ------
    ConfigurationError
        Naming the key, its value and the remedy.

    """
    inputs: dict[Signal, InputSettings] = {}
    constant: Any = 0.0
    for signal in SIGNALS:
        keys = input_keys(brake, signal)
        values = {key.name.rpartition('.')[2]: key.read(parameters.get(key.name, key.default))
                  for key in keys}
        constant = values.pop('constant', constant)
        if not values['topic']:
            continue
        inputs[signal] = InputSettings(**values)  # type: ignore[arg-type]
        _check_numbers(f'{brake}.{signal}', inputs[signal])
    for signal in ('rotor_speed', 'pressure'):
        if signal not in inputs:
            raise ConfigurationError(f'{brake}.{signal}.topic', "is ''", 'name a topic')
    result = BrakeSettings(brake, inputs, constant)
    check_friction(result, *validated_friction)
    return result


def _check_numbers(where: str, result: InputSettings) -> None:
    if result.scale == 0.0:
        raise ConfigurationError(f'{where}.scale', 'is 0', 'give another number')
    if not result.minimum < result.maximum:
        raise ConfigurationError(f'{where}.maximum', f'is {result.maximum:g} and the minimum '
                                 f'{result.minimum:g}', 'make it the larger')


def check_friction(brake: BrakeSettings, low: float, high: float) -> None:
    """Refuse a brake without any friction, with two, or with one beyond the validated range."""
    constant, inputs = brake.constant_friction, brake.inputs
    used = [signal for signal in ('friction', 'temperature') if signal in inputs]
    if not used and not constant:
        raise ConfigurationError(
            f'{brake.name}.friction.topic', "is '' and so is temperature.topic",
            'name one of them, or give friction.constant: docs/howto/missing_sensors.md')
    if used and constant:
        raise ConfigurationError(
            f'{brake.name}.friction.constant', f'is {constant:g}, and {used[0]} has a topic',
            f"leave it out, or set {' and '.join(f'{signal}.topic' for signal in used)} to ''")
    if constant and not low <= constant <= high:
        raise ConfigurationError(
            f'{brake.name}.friction.constant', f'is {constant:g}', f'give {low:g} to {high:g}, or '
            'change validated_friction_low and validated_friction_high')

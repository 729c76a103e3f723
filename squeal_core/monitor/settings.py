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

"""Settings of the monitor, read from ROS parameters or from their YAML file, and checked."""

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
import math
from pathlib import Path
from typing import Any

from squeal_core.common.errors import ConfigurationError, did_you_mean, short_repr
from squeal_core.common.yaml_reader import read_yaml
from squeal_core.monitor.axles import axle_partners
from squeal_core.monitor.brake_settings import BrakeSettings, read_brake_settings
from squeal_core.monitor.setting_specs import input_keys, MONITOR_KEYS, SettingSpec, SIGNALS
from squeal_core.risk.ensemble import EnsemblePrior

NODE_NAME = 'squeal_monitor'
MAX_BRAKES = 64  # of one node
MAX_NAME = 100  # letters of a brake's name


@dataclass(frozen=True, kw_only=True)
class MonitorSettings:
    """Checked settings of the monitor; fields as `MONITOR_KEYS`, SI units."""

    brakes: tuple[BrakeSettings, ...]
    model: str
    autostart: bool
    rate: float
    diagnostics_rate: float
    release_pressure: float
    minimum_rotor_speed: float
    squeal_band_low_hz: float
    squeal_band_high_hz: float
    growth_threshold: float
    risk_warning: float
    risk_hysteresis: float
    risk_hold: float
    stamp_tolerance: float
    validated_rotor_speed_low: float
    validated_rotor_speed_high: float
    validated_preload_low: float
    validated_preload_high: float
    validated_friction_low: float
    validated_friction_high: float
    bar_suspected_below: float
    reference_check: bool
    ambient_pressure: float
    publisher_tolerance: float
    wheel_acceleration_peak: float
    wheel_acceleration_mean: float
    stuck_changes: float
    axles: tuple[str, ...]
    contradicting_pressure: float
    axle_pressure_ratio: float
    rear_pressure_share: float
    unbraked_deceleration: float
    deceleration_per_pressure: float
    pressure_slew: float
    wheel_speed_tolerance: float
    friction_ratio: float
    contradiction_time: float
    slip_time: float
    single_brake_time: float
    lock_time: float
    instability_damping_ratio: float
    audible_build_up: float
    audible_build_up_deviation: float
    noise_floor_nm: float
    damping_deviation: float
    contact_stiffness_deviation: float
    friction_bias_deviation: float
    friction_slope_deviation: float
    friction_scatter: float
    damping_scatter: float
    ensemble_size: float
    risk_rate: float
    growth_emulator: str
    calibration: str
    table: str
    audit_interval: float
    margin_confirm_interval: float
    advice_hold: float
    advice_front_share_low: float
    advice_front_share_high: float
    rear_force_ratio: float
    clock_timeout: float
    mode_shapes: bool
    mode_shape_size: float
    mode_shape_frame: str

    @property
    def period(self) -> int:
        """Time between assessments [ns]."""
        return round(1e9 / self.rate)

    @property
    def risk_interval(self) -> int:
        """Time between evaluations of the risk [ns]."""
        return round(1e9 / self.risk_rate)


def band_of(settings: MonitorSettings) -> tuple[float, float]:
    """Return the ends of the squeal band [Hz]."""
    return settings.squeal_band_low_hz, settings.squeal_band_high_hz


def ensemble_prior(settings: MonitorSettings) -> EnsemblePrior:
    """Return the prior of an uncalibrated ensemble of brakes."""
    return EnsemblePrior(
        damping=settings.damping_deviation, contact_stiffness=settings.contact_stiffness_deviation,
        friction=settings.friction_bias_deviation, slope=settings.friction_slope_deviation,
        audible_build_up=settings.audible_build_up,
        audible_build_up_deviation=settings.audible_build_up_deviation,
        friction_scatter=settings.friction_scatter, damping_scatter=settings.damping_scatter,
        count=round(settings.ensemble_size))


def pressure_references(settings: MonitorSettings) -> str:
    """Return, in words, which pressures are taken as gauge and which as absolute."""
    brakes: dict[str, list[str]] = {}
    for brake in settings.brakes:
        brakes.setdefault(brake.inputs['pressure'].reference, []).append(brake.name)
    if len(brakes) == 1:
        return f'pressures are taken as {next(iter(brakes))} (key pressure.reference)'
    return 'pressures are taken as ' + ', '.join(
        f'{reference} ({", ".join(names)})' for reference, names in brakes.items())


def settings_keys(brakes: tuple[str, ...]) -> Iterator[SettingSpec]:
    """Yield every key that the settings of these brakes have."""
    yield from MONITOR_KEYS
    for brake in brakes:
        for signal in SIGNALS:
            yield from input_keys(brake, signal)


def read_settings(parameters: Mapping[str, Any]) -> MonitorSettings:
    """
    Check flat parameters (`front_left.pressure.topic`) and fill in defaults.

    Raises
    ------
    ConfigurationError
        Naming the key, its value and the remedy.

    """
    top = {key.name: key.read(parameters.get(key.name, key.default)) for key in MONITOR_KEYS}
    names = top.pop('brakes')
    assert isinstance(names, tuple)
    check_names(names)
    known = {key.name for key in settings_keys(names)}
    for name, value in parameters.items():
        if name not in known:
            raise ConfigurationError(
                name[:80], f'unknown key (value {short_repr(value)})',
                f'see config/monitor.yaml for the keys{did_you_mean(name, known)}')
    for name, unit in (('squeal_band_{}_hz', 'Hz'), ('validated_rotor_speed_{}', 'rad/s'),
                       ('validated_preload_{}', 'N'), ('validated_friction_{}', '-'),
                       ('advice_front_share_{}', '-')):
        low, high = top[name.format('low')], top[name.format('high')]
        if not low < high:  # type: ignore[operator]
            raise ConfigurationError(name.format('high'), f'is {high} and the low end {low} '
                                     f'{unit}', 'make it the larger')
    size = top['ensemble_size']
    if math.log2(size) % 1.0:  # type: ignore[arg-type]
        raise ConfigurationError('ensemble_size', f'is {size:g}', 'give a power of 2, as 64')
    axles = top['axles']
    assert isinstance(axles, tuple)
    axle_partners(names, axles)
    friction = top['validated_friction_low'], top['validated_friction_high']
    brakes = tuple(read_brake_settings(name, parameters, friction)  # type: ignore[arg-type]
                   for name in names)
    return MonitorSettings(brakes=brakes, **top)  # type: ignore[arg-type]


def flatten(nested: Mapping[str, Any], prefix: str = '') -> dict[str, Any]:
    """Return {'a.b': value} of {'a': {'b': value}}, as ROS parameters are named."""
    flat: dict[str, Any] = {}
    for key, value in nested.items():
        if isinstance(value, Mapping):
            flat.update(flatten(value, f'{prefix}{key}.'))
        else:
            flat[f'{prefix}{key}'] = value
    return flat


def load_settings(path: str | Path) -> MonitorSettings:
    """
    Read the settings in a ROS parameter file: those for /** and for any squeal_monitor.

    Examples
    --------
    >>> from squeal_core import load_settings
    >>> from squeal_core.common.resources import config_folder
    >>> load_settings(config_folder() / 'monitor.yaml').rate
    10.0

    """
    content = read_yaml(path, ConfigurationError, ros=True)
    parameters: dict[str, Any] = {}
    for section in parameter_sections(content):
        parameters.update(flatten(section))
    if not parameters:
        raise ConfigurationError(str(path), f'has no ros__parameters for {NODE_NAME}',
                                 'see config/monitor.yaml')
    return read_settings({name: value for name, value in parameters.items()
                          if not is_built_in(name)})


def is_built_in(name: str) -> bool:
    """Return whether a parameter belongs to ROS itself."""
    return (name in ('use_sim_time', 'start_type_description_service')
            or name.startswith('qos_overrides.'))


def parameter_sections(content: Any, names: Container[str] = (NODE_NAME,),
                       node: str = '') -> Iterator[Mapping[str, Any]]:
    """Yield the parameters in a file that a node of these names would take, in any namespace."""
    for key, value in content.items() if isinstance(content, Mapping) else ():
        if key == 'ros__parameters':
            if (node in ('**', '*') or node in names) and isinstance(value, Mapping):
                yield value
        else:
            yield from parameter_sections(value, names, str(key).rpartition('/')[2])


def check_names(names: tuple[str, ...]) -> None:
    """Refuse names of brakes that topics and parameters cannot have, and too many of them."""
    if len(names) > MAX_BRAKES:
        raise ConfigurationError('brakes', f'has {len(names)} names',
                                 f'name at most {MAX_BRAKES} brakes for one node')
    for name in names:
        if not (name.isidentifier() and name.isascii() and len(name) <= MAX_NAME):
            raise ConfigurationError('brakes', f'has {short_repr(name)}',
                                     'use letters, digits and _')
    if len(set(names)) != len(names) or not names:
        raise ConfigurationError('brakes', f'is {short_repr(list(names))}', 'name each brake once')

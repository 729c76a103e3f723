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

"""The settings of the monitor: each with default, range, unit and meaning."""

from collections.abc import Mapping
from dataclasses import dataclass
import math
from typing import Any, Literal, TypeAlias

from squeal_core.brake.operating_point import MINIMUM_ROTOR_SPEED, RELEASE_PRESSURE
from squeal_core.common.errors import ConfigurationError, did_you_mean, short_repr
from squeal_core.stability.eigensolution import SQUEAL_BAND

Signal: TypeAlias = Literal['rotor_speed', 'pressure', 'friction', 'temperature']
SIGNALS: tuple[Signal, ...] = ('rotor_speed', 'pressure', 'friction', 'temperature')
Value: TypeAlias = bool | float | str | tuple[str, ...]
# when a running node takes a new value: at the next tick, at the next configure, never
Change: TypeAlias = Literal['tick', 'configure', 'start']


@dataclass(frozen=True)
class SettingSpec:
    """One setting: its name, default, range, unit and meaning."""

    name: str
    default: Value
    unit: str
    meaning: str
    minimum: float = -math.inf
    maximum: float = math.inf
    change: Change = 'tick'
    choices: tuple[str, ...] = ()

    def read(self, value: Any) -> Value:
        """Return a value of the default's type, or raise ConfigurationError."""
        if isinstance(self.default, tuple):
            if isinstance(value, list | tuple) and all(isinstance(v, str) for v in value):
                return tuple(value)
            raise self.error(value, 'give a list of names')
        if isinstance(self.default, bool | str):
            if isinstance(value, type(self.default)):
                if self.choices and value not in self.choices:
                    raise self.error(value, f'give one of {", ".join(self.choices)}'
                                            f'{did_you_mean(value, self.choices)}')
                return value
            raise self.error(value, f'give a {type(self.default).__name__}')
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(value, 'give a number')
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not (math.isfinite(number) and self.minimum <= number <= self.maximum):
            span = 'finite number' if self.minimum == -math.inf == -self.maximum else (
                f'number from {self.minimum:g} to {self.maximum:g}')
            raise self.error(value, f'give a {span}')
        return number

    def error(self, value: Any, remedy: str) -> ConfigurationError:
        return ConfigurationError(self.name, f'is {short_repr(value)} [{self.unit}]', remedy)


MONITOR_KEYS = (
    SettingSpec('brakes', ('front_left', 'front_right', 'rear_left', 'rear_right'), '-',
                'names of the brakes; each becomes a part of topic and parameter names',
                change='start'),
    SettingSpec('model', 'kang2009', '-', 'path of a model file, or the name of a shipped model',
                change='configure'),
    SettingSpec('autostart', True, '-', 'configure and activate by itself', change='start'),
    SettingSpec('rate', 10.0, 'Hz', 'assessments a second',
                0.1, 1000.0),
    SettingSpec('diagnostics_rate', 1.0, 'Hz',
                'diagnostics a second, besides those on a change of state', 0.01, 1000.0),
    SettingSpec('release_pressure', RELEASE_PRESSURE, 'Pa',
                'below it a brake counts as released: risk 0', 0.0, 1e7),
    SettingSpec('minimum_rotor_speed', MINIMUM_ROTOR_SPEED, 'rad/s',
                'below it the disc counts as not sliding: no number', 1e-3, 100.0),
    SettingSpec('squeal_band_low_hz', SQUEAL_BAND[0], 'Hz',
                'least frequency that counts as squeal', 0.0, 1e5),
    SettingSpec('squeal_band_high_hz', SQUEAL_BAND[1], 'Hz',
                'largest frequency that counts as squeal', 1.0, 1e5),
    SettingSpec('growth_threshold', 0.01, '1/s',
                'growth rate above which a mode counts as unstable', 1e-6, 1000.0,
                change='configure'),
    SettingSpec('risk_warning', 0.5, '-', 'squeal risk from which the diagnostic says WARN', 0.01,
                1.0),
    SettingSpec('risk_hysteresis', 0.1, '-', 'a warning ends this far below risk_warning', 0.0,
                1.0),
    SettingSpec('risk_hold', 0.5, 's', 'and not before the risk was there for so long', 0.0,
                3600.0),
    SettingSpec('stamp_tolerance', 0.5, 's',
                'a sample stamped further ahead of the next tick is refused', 0.0, 3600.0),
    SettingSpec('validated_rotor_speed_low', 0.5, 'rad/s',
                'range in which the model was validated; beyond it no number', 0.0, 1e4),
    SettingSpec('validated_rotor_speed_high', 200.0, 'rad/s', 'its upper end', 0.0, 1e4),
    SettingSpec('validated_preload_low', 50.0, 'N', 'likewise, preload of a pad', 0.0, 1e7),
    SettingSpec('validated_preload_high', 4e4, 'N', 'its upper end', 0.0, 1e7),
    SettingSpec('validated_friction_low', 0.05, '-', 'likewise, friction coefficient', 0.0, 10.0),
    SettingSpec('validated_friction_high', 0.9, '-', 'its upper end', 0.0, 10.0),
    SettingSpec('bar_suspected_below', 500.0, 'Pa',
                'a pressure that stays between 0.5 and this looks like bar given as Pa; 0: '
                'not looked for',
                0.0, 1e5),
    SettingSpec('reference_check', True, '-',
                'look for an absolute pressure given as gauge: it rests at 1 bar, never at zero'),
    SettingSpec('ambient_pressure', 101325.0, 'Pa',
                'of the air; subtracted from a pressure whose reference is absolute', 5e4, 1.1e5),
    SettingSpec('publisher_tolerance', 0.05, '-',
                'relative difference from which publishers of one input contradict each other; 0: '
                'not looked for', 0.0, 10.0),
    SettingSpec('wheel_acceleration_peak', 500.0, 'rad/s^2',
                'a rotor speed that changes faster leaps, as rpm given as rad/s would; 0: '
                'not looked for',
                0.0, 1e6),
    SettingSpec('wheel_acceleration_mean', 40.0, 'rad/s^2',
                'the same over a second: faster than a vehicle', 1.0, 1e6),
    SettingSpec('stuck_changes', 20.0, '-',
                'changes that an input must have shown, and that the others show, to call it '
                'stuck',
                0.0, 1e6),
    SettingSpec('axles', ('auto',), '-',
                'brakes that share an axle, to check one against the other: '
                'auto, by their names; none; or one left+right an axle'),
    SettingSpec('contradicting_pressure', 1.5e5, 'Pa',
                'a brake that reads released is doubted when its axle partner reads this much '
                'and the vehicle brakes; 0: pressures are not compared',
                0.0, 1e7),
    SettingSpec('axle_pressure_ratio', 0.7, '-',
                'less than this fraction of the pressure of its axle '
                'partner (and 1 bar) is doubted; 0: only a released brake', 0.0, 0.9),
    SettingSpec('rear_pressure_share', 0.0, '-',
                'usual pressure of the rear brakes over that of the '
                'front ones, which are the first of brakes; 0: learned', 0.0, 10.0),
    SettingSpec('unbraked_deceleration', 12.0, 'rad/s^2', 'wheels that slow more than engine, '
                'regeneration and hills can do (12 is 4 m/s^2 on a 0.33 m wheel) contradict low '
                'pressures; 0: not checked', 0.0, 1e3),
    SettingSpec('deceleration_per_pressure', 10.0, 'rad/s^2 per MPa',
                'what the largest pressure adds to that at most; 10 is 0.33 m/s^2 a bar', 0.0,
                1e4),
    SettingSpec('pressure_slew', 1e8, 'Pa/s',
                'a pressure that keeps leaping away and back faster is '
                'doubted, and one that alternates faster than ABS (18 Hz); 0: not checked', 0.0,
                1e12),
    SettingSpec('wheel_speed_tolerance', 0.13, '-',
                'by which a wheel speed may differ from the others, '
                'beyond what a turn does (a spare wheel: 0.11); 0: not checked', 0.0, 1.0),
    SettingSpec('friction_ratio', 0.6, '-',
                'a friction below this fraction of that of the axle partner '
                'is doubted, of the middle one of other axles 0.75 of it; 0: not checked', 0.0,
                0.95),
    SettingSpec('contradiction_time', 0.5, 's', 'how long a contradiction lasts before it is told',
                0.0, 60.0),
    SettingSpec('slip_time', 2.0, 's',
                'the same while wheels slip or turn unlike (ABS, bends), and for fractions', 0.0,
                60.0),
    SettingSpec('single_brake_time', 5.0, 's', 'the same while no other axle brakes on both sides '
                '(ESP, torque vectoring), and for wheels that may spin', 0.0, 600.0),
    SettingSpec('lock_time', 3.0, 's', 'the same for a wheel at rest whose brake reads pressure',
                0.0, 60.0),
    SettingSpec('instability_damping_ratio', 0.0, '-',
                'a mode counts as unstable in instability_probability from this damping ratio '
                'below zero on (zeta < -this; industry: 0.0025 to 0.005)', 0.0, 0.1),
    SettingSpec('audible_build_up', 5.5, 'nepers',
                'build-up above the noise floor from which a tone counts as squeal', 0.1, 20.0,
                change='configure'),
    SettingSpec('audible_build_up_deviation', 2.0, 'nepers', 'its standard deviation', 0.0, 10.0,
                change='configure'),
    SettingSpec('noise_floor_nm', 1.0, 'nm', 'amplitude of a mode at the contact by noise alone, '
                'from which its build-up counts', 1e-3, 10.0),
    SettingSpec('damping_deviation', 0.3, '-',
                'standard deviation of ln damping, from brake to brake of the model', 0.0, 2.0,
                change='configure'),
    SettingSpec('contact_stiffness_deviation', 0.1, '-',
                'likewise, of ln contact stiffness', 0.0, 2.0, change='configure'),
    SettingSpec('friction_bias_deviation', 0.03, '-',
                'likewise, of the true friction coefficient about the input', 0.0, 0.5,
                change='configure'),
    SettingSpec('friction_slope_deviation', 0.3, '-',
                'likewise, of the factor on the slope of friction over speed', 0.0, 2.0,
                change='configure'),
    SettingSpec('friction_scatter', 0.02, '-', 'standard deviation of the friction coefficient '
                'from one brake application to the next', 0.0, 0.5, change='configure'),
    SettingSpec('damping_scatter', 0.15, '-', 'likewise, of ln damping', 0.0, 2.0,
                change='configure'),
    SettingSpec('ensemble_size', 64.0, '-', 'brakes of which the risk is the weighted mean, a '
                'power of 2', 16.0, 4096.0, change='configure'),
    SettingSpec('risk_rate', 20.0, 'Hz', 'evaluations of the risk a second, at most one a tick; '
                'in between it is held', 0.1, 1000.0),
    SettingSpec('growth_emulator', '', '-', 'path of an emulator of growth that `squeal tabulate '
                '--growth-only` wrote; empty: the one that is shipped or cached for the model; '
                '"none": no squeal risk', change='configure'),
    SettingSpec('calibration', '', '-', 'path of a calibration that `squeal calibrate` wrote, '
                'which takes the place of the standard deviations above; empty: none',
                change='configure'),
    SettingSpec('table', '', '-', 'path of a table that `squeal tabulate` wrote; empty: the one '
                'that is shipped or cached for the model; "none": no table', change='configure'),
    SettingSpec('audit_interval', 3000.0, '-',
                'of so many answers from the table, and of so many from the emulator, one is '
                'compared with a full solution; 0: none', 0.0, 1e9),
    SettingSpec('margin_confirm_interval', 10.0, 's',
                'between full solutions that confirm the friction margin of a brake; 0: none',
                0.0, 3600.0),
    SettingSpec('advice_hold', 3.0, 's', 'for which advised conditions are held: advice is by the '
                'risk of squeal meanwhile', 0.1, 600.0),
    SettingSpec('advice_front_share_low', 0.5, '-',
                'least share of the brake force on the front axle that is advised', 0.01, 0.99),
    SettingSpec('advice_front_share_high', 0.9, '-', 'its upper end', 0.01, 0.99),
    SettingSpec('rear_force_ratio', 1.0, '-',
                'force of a rear brake over that of a front one at equal pressure and friction',
                0.01, 100.0),
    SettingSpec('clock_timeout', 1.0, 's',
                'a /clock that stands still for longer has stopped: nothing is known', 0.1,
                3600.0),
    SettingSpec('mode_shapes', False, '-',
                'publish the worst mode as markers, once a second at most', change='configure'),
    SettingSpec('mode_shape_size', 0.01, 'm', 'largest displacement that is drawn', 1e-4, 1.0),
    SettingSpec('mode_shape_frame', '<brake>', '-',
                'frame of the markers, z along the axis; <brake> stands for the name'),
)

LARGEST_FRICTION = 1.5
_INPUTS: dict[Signal, tuple[str, str, str, float, float, str]] = {
    'rotor_speed': ('joint_states', 'sensor_msgs/msg/JointState',
                    'velocity[name={brake}_wheel_joint]', -400.0, 400.0, 'rad/s'),
    'pressure': ('{brake}/brake_pressure', 'sensor_msgs/msg/FluidPressure', 'fluid_pressure',
                 -1.05e5, 3e7, 'Pa'),  # a gauge reads down to minus an atmosphere
    'friction': ('{brake}/friction', 'std_msgs/msg/Float64', 'data', 0.01, LARGEST_FRICTION, '-'),
    'temperature': ('', 'sensor_msgs/msg/Temperature', 'temperature', 200.0, 1500.0, 'K'),
}
UNITS: Mapping[str, str] = {signal: entry[-1] for signal, entry in _INPUTS.items()}
# a real speed or pressure flickers; a friction or temperature may rest for a while
_STUCK_AFTER: dict[Signal, float] = {
    'rotor_speed': 2.0, 'pressure': 5.0, 'friction': 10.0, 'temperature': 10.0}
_MOVEMENT: dict[Signal, float] = {
    'rotor_speed': 0.004, 'pressure': 1e3, 'friction': 1e-3, 'temperature': 0.05}


def input_keys(brake: str, signal: Signal) -> tuple[SettingSpec, ...]:
    """Return the settings of one input of one brake."""
    topic, type_name, path, low, high, unit = _INPUTS[signal]
    offset = 273.15 if signal == 'temperature' else 0.0
    least = 1e-3 if signal in ('friction', 'temperature') else -math.inf  # none at or below zero
    at = f'{brake}.{signal}'
    reference = (SettingSpec(f'{at}.reference', 'gauge', '-', '"gauge", or "absolute" as '
                             'sensor_msgs/FluidPressure is by its definition: ambient_pressure is '
                             'subtracted then', change='configure', choices=('gauge', 'absolute')),
                 ) if signal == 'pressure' else ()
    constant = (SettingSpec(f'{at}.constant', 0.0, '-', 'friction coefficient where neither '
                            'friction nor temperature has a topic; 0: none', 0.0, high),
                ) if signal == 'friction' else ()
    return (
        SettingSpec(f'{at}.topic', topic.format(brake=brake), '-',
                    'topic; empty: this input is not used', change='configure'),
        SettingSpec(f'{at}.type', type_name, '-', 'message type', change='configure'),
        SettingSpec(f'{at}.field', path.format(brake=brake), '-',
                    'where in the message the value is', change='configure'),
        SettingSpec(f'{at}.stamp', 'header', '-',
                    'when a value holds: "header", at the stamp of the '
                    'message where it has one, or "receipt"', change='configure',
                    choices=('header', 'receipt')),
        SettingSpec(f'{at}.scale', 1.0, f'{unit} per message unit',
                    'value = scale * field + offset'),
        SettingSpec(f'{at}.offset', offset, unit, 'value = scale * field + offset'),
        *reference, *constant,
        SettingSpec(f'{at}.max_age', 0.5, 's', 'older than this an input is stale', 1e-3, 3600.0),
        SettingSpec(f'{at}.minimum', low, unit, 'a smaller value is invalid', least),
        SettingSpec(f'{at}.maximum', high, unit, 'a larger value is invalid', least),
        SettingSpec(f'{at}.stuck_after', _STUCK_AFTER[signal], 's',
                    'exactly constant for longer while the disc slides under load is stuck; 0: '
                    'never',
                    0.0, 3600.0),
        SettingSpec(f'{at}.movement', _MOVEMENT[signal], unit,
                    'a live value moves by as much meanwhile; one in larger steps may rest '
                    'longer, in proportion', 1e-9, 1e9),
    )

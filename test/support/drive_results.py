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

"""Results of `squeal replay`, written without a replay: any length, rate and share not known."""

from collections.abc import Sequence
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common import resources
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.history import AssessmentRecord
from squeal_core.monitor.results.record_tables import write_records
from squeal_core.monitor.results.result_files import ResultPaths
from squeal_core.monitor.results.squeal_events import SquealEvent

BRAKES = ('front_left', 'front_right', 'rear_left', 'rear_right')
START = 1_700_000_000.0  # s
CYCLE, BRAKING = 15.0, 8.0  # s: period of the brake applications, and length of each
_MODEL = 'kang2009_damped'


class SyntheticDrive:
    """
    Brakings from 75 rad/s every 15 s, each with a pressure, friction and temperature of its own.

    Parameters
    ----------
    seconds, rate : float
        Length [s] and ticks a second.
    brakes : sequence of str
    known : bool
        Whether any risk is known.
    name : str
        Of the recording.
    seed : int
        Of pressures and frictions.
    start : float
        Of the clock [s].

    """

    def __init__(self, seconds: float = 120.0, rate: float = 10.0,
                 brakes: Sequence[str] = BRAKES, *, known: bool = True, name: str = 'drive',
                 seed: int = 1, start: float = START) -> None:
        self.brakes, self.known, self.name, self.rate = brakes, known, name, rate
        self.start, self.end = start, start + seconds
        self._time = np.arange(round(seconds * rate)) / rate
        self._count = math.ceil(seconds / CYCLE)
        self._rng = np.random.default_rng(seed)

    def write(self, folder: Path) -> Path:
        """Write the files of a result folder, but for the bag."""
        folder.mkdir(parents=True)
        paths = ResultPaths.in_folder(folder)
        columns = [self._columns(number) for number in range(len(self.brakes))]
        with paths.table.open('w', encoding='utf-8') as file:
            file.write(','.join(AssessmentRecord._fields) + '\n')
            for rows in zip(*(self._lines(brake, own) for brake, own in
                              zip(self.brakes, columns, strict=True)), strict=True):
                file.writelines(rows)
        applications = [one for brake, own in zip(self.brakes, columns, strict=True)
                        for one in self._applications(brake, own)]
        applications.sort(key=lambda one: (one.start_s, one.brake))
        write_records(paths.applications, ApplicationRecord, applications)
        write_records(paths.events, SquealEvent, [
            _event(one) for one in applications if one.alarm])
        paths.summary.write_text(json.dumps(self._summary()))
        return folder

    def _columns(self, number: int) -> dict[str, Any]:
        """Return the arrays of one brake; NaN where not known."""
        t, phase = self._time, self._time % CYCLE
        which = (t // CYCLE).astype(int)
        load, mu = (self._rng.uniform(*ends, self._count)[which]
                    for ends in ((5e5, 40e5), (0.32, 0.46)))
        braking = phase < BRAKING
        shift = 1.0 if number < 2 else 0.7
        pressure = np.where(braking, load * shift * np.minimum(1.0, 2.0 * phase), 0.0)
        speed = np.where(braking, 75.0 - 8.0 * phase, 11.0 + 9.0 * (phase - BRAKING))
        friction = mu + 0.01 * np.sin(0.4 * t + number)
        growth = 500.0 * (friction - 0.42) + 10.0 * pressure / 4e6 - 0.3 * speed + 12.0
        build_up = np.where(braking, np.clip(0.4 * growth * phase, 0.3, 9.9), 0.0)
        risk = 1.0 / (1.0 + np.exp(5.5 - build_up))
        margin = 0.42 - friction + (0.3 * speed - 12.0 - 10.0 * pressure / 4e6) / 500.0
        unknown = braking & ((which % 7 == 3) if self.known else True)
        out: dict[str, Any] = {
            'braking': braking, 'unknown': unknown, 'which': which, 'speed': speed,
            'pressure': pressure, 'friction': friction,
            'temperature': 380.0 + 40.0 * np.sin(t / 300.0) + 5.0 * number}
        for name, values in (('growth', growth), ('margin', margin)):
            out[name] = np.where(braking & ~unknown, values, np.nan)
        out['build_up'], out['risk'] = (np.where(unknown, np.nan, values)
                                        for values in (build_up, np.where(braking, risk, 0.0)))
        out['frequency'] = np.where(which % 3 == 0, 1655.0 + 40.0 * number, 3210.0 + 15.0 * number)
        return out

    def _lines(self, brake: str, own: dict[str, Any]) -> Any:
        brake = '"' + brake.replace('"', '""') + '"' if '"' in brake or ',' in brake else brake
        states = np.where(own['unknown'], 'stale', np.where(own['braking'], 'steady', 'released'))
        for i, time in enumerate(self._time + self.start):
            growth, f = float(own['growth'][i]), float(own['frequency'][i])
            modes = (f'{f!r} 5686.5', f'{growth!r} 0.5') if growth > 0.0 else ('', '')
            reason = '"rotor_speed is 1.2 s old, ""stale"""' if own['unknown'][i] else (
                '"squeal risk 0.1, build-up"')
            numbers = [float(own[name][i]) for name in ('speed', 'pressure', 'friction', 'risk')]
            more = (numbers[3], float(own['build_up'][i]), math.inf, growth,
                    -growth / (2.0 * math.pi * f), f, float(own['margin'][i]))
            yield (f'{float(time)!r},{brake},{states[i]},' + ','.join(map(repr, (*numbers, *more)))
                   + f',{modes[0]},{modes[1]},{reason},{float(own["temperature"][i])!r},0.02,0,13,'
                   + ('13 39' if modes[0] else '') + '\n')

    def _applications(self, brake: str, own: dict[str, Any]) -> Any:
        for which in range(self._count):
            at = np.flatnonzero((own['which'] == which) & own['braking'])
            known = not own['unknown'][at].any()
            growth = own['growth'][at]
            worst = at[growth.argmax()] if known else at[0]
            peak = float(own['risk'][at].max()) if known else math.nan
            nan = math.nan

            def of(name: str, place: Any = worst, known: bool = known) -> float:
                return float(own[name][place]) if known else math.nan

            yield ApplicationRecord(
                brake=brake, start_s=float(self._time[at[0]] + self.start),
                end_s=float(self._time[at[-1]] + self.start), known_share=float(known),
                peak_risk=peak, mean_risk=float(own['risk'][at].mean()) if known else nan,
                build_up_nepers=float(own['build_up'][at].max()) if known else nan,
                growth_rate_1_s=of('growth'), damping_ratio=-of('growth') / 2e4,
                frequency_hz=of('frequency'), mode_number=13 if known else 0,
                alarm=bool(peak > 0.5) if known else None,
                rotor_speed_rad_s=float(own['speed'][at[0]]),
                rotor_speed_end_rad_s=float(own['speed'][at[-1]]),
                pressure_pa=float(own['pressure'][at].mean()),
                pressure_max_pa=float(own['pressure'][at].max()),
                friction=float(own['friction'][at].mean()),
                temperature_k=float(own['temperature'][at[0]]))

    def _summary(self) -> dict[str, Any]:
        path = resources.find('models', _MODEL, '.npz')
        share = 0.8 if self.known else 0.0
        braking = len(self.brakes) * self._count * BRAKING
        reason = {'brake': self.brakes[0], 'state': 'stale', 'ticks': 80, 'braking_ticks': 80,
                  'first_at_s': self.start, 'text': 'rotor_speed is 1.2 s old',
                  'remedy': 'check that its source ran'}
        return {
            'format': 1, 'partial': False, 'rate_hz': self.rate,
            'recording': {'name': self.name, 'path': f'/data/{self.name}.mcap', 'kind': 'rosbag2',
                          'sha256': 'ab' * 32, 'bytes': 12_345_678, 'start_s': self.start,
                          'end_s': self.end},
            'software': {'squeal_ros': '1.0', 'python': '3.12', 'numpy': '2', 'scipy': '1.14'},
            'model': {'name': _MODEL, 'path': str(path),
                      'sha256': hashlib.sha256(path.read_bytes()).hexdigest()},
            'table': None, 'emulator': None, 'calibration': None,
            'settings': {'sha256': 'cd' * 32, 'yaml': json.dumps({'rate': self.rate})},
            'report': {
                'risk_known_share': share, 'risk_known_s': share * braking,
                'never_known': [] if self.known else list(self.brakes), 'incomplete_share': 0.0,
                'assessed_share': share, 'braking_s': braking, 'assessed_s': share * braking,
                'never_assessed': [] if self.known else list(self.brakes),
                'ticks': len(self._time), 'ticks_by_state': {}, 'top_reason': reason,
                'silence_s': 0.0, 'findings': [], 'notes': [], 'events': None,
                'brakes': {brake: {
                    'risk_known_share': share, 'assessed_share': share,
                    'braking_s': braking / len(self.brakes),
                    'assessed_s': share * braking / len(self.brakes), 'mean_risk': None,
                    'peak_risk': None, 'ticks_by_state': {}, 'reasons': [reason]}
                           for brake in self.brakes}},
            'inputs': [{'brake': brake, 'signal': signal, 'source': f'/{brake}/{signal}',
                        'unit': unit, 'messages': 1000, 'rate_hz': 20.0, 'gaps': 2,
                        'longest_gap_s': 1.2, 'stale_s': 8.0,
                        'invalid_s': {'stuck': 1.5} if signal == 'pressure' else {}}
                       for brake in self.brakes for signal, unit in (
                           ('rotor_speed', 'rad/s'), ('pressure', 'Pa'), ('friction', '-'))]}


def _event(one: ApplicationRecord) -> SquealEvent:
    return SquealEvent(
        brake=one.brake, start_s=one.start_s + 2.0, end_s=one.end_s,
        clock_time='2023-11-14T22:13:20Z', mode_number=one.mode_number,
        frequency_hz=one.frequency_hz, growth_rate_1_s=one.growth_rate_1_s,
        damping_ratio=one.damping_ratio, mechanism='mode coupling', peak_risk=one.peak_risk,
        build_up_nepers=one.build_up_nepers, rotor_speed_rad_s=one.rotor_speed_end_rad_s,
        pressure_pa=one.pressure_pa, friction=one.friction, temperature_k=one.temperature_k)

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

"""The squeal risk of a brake over a drive, from signals and without a recording."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
import math

from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.assessment import PreparedTick
from squeal_core.monitor.inputs.reading import Sample
from squeal_core.monitor.results.drive_summary import DriveSummary
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_evaluator import VehicleEvaluator
from squeal_core.monitor.vehicle_monitor import VehicleInputs
from squeal_core.vehicle.vehicle_model import BrakeSignals

_BLOCK = 256  # ticks that are evaluated at once
_ORIGIN = 1_000_000_000  # ns
_SIGNALS: tuple[Signal, ...] = ('rotor_speed', 'pressure', 'friction')


@dataclass(frozen=True)
class DriveRisk:
    """
    Squeal risk of all brakes of a vehicle over a drive.

    Parameters
    ----------
    mean_risk, peak_risk : float
        While braking, where it is known [-]; NaN: it never is.
    known_share : float
        Part of the braking time with a known risk; NaN: there was no braking.
    braking_s, alarm_s : float
        Braking time, and the part of it with a risk of `risk_warning` or more, of all brakes
        together [s].
    unknown : str
        Why it is not known, where it never is.

    """

    mean_risk: float = math.nan
    peak_risk: float = math.nan
    known_share: float = math.nan
    braking_s: float = math.nan
    alarm_s: float = math.nan
    unknown: str = ''


def drive_risk(model: BrakeModel, signals: BrakeSignals, settings: MonitorSettings,
               progress: Callable[[int, int], None] = lambda done, total: None) -> DriveRisk:
    """
    Return the risk as the monitor would have given it.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    signals : BrakeSignals
        Of the drive.
    settings : MonitorSettings
        Of brakes of these names, with a friction input each.
    progress : callable
        Told how many ticks are done, and of how many.

    """
    evaluator, summary = VehicleEvaluator(model, settings), DriveSummary(settings)
    if evaluator.risk.unknown:
        return DriveRisk(unknown=evaluator.risk.unknown)
    ticks = _prepared(VehicleInputs(settings, model), signals, settings.period)
    total, alarms = int(signals.time[-1] * 1e9) // settings.period + 1, 0
    while block := list(islice(ticks, _BLOCK)):
        for result in evaluator.complete(block):
            summary.add(result)
            alarms += sum(one.state == 'steady' and one.risk >= settings.risk_warning
                          for one in result)
        progress(min(summary.ticks, total), total)
    brakes = summary.brakes.values()
    known = sum(brake.risks for brake in brakes)
    return DriveRisk(
        mean_risk=sum(brake.total_risk for brake in brakes) / known if known else math.nan,
        peak_risk=max((brake.peak_risk for brake in brakes if brake.risks), default=math.nan),
        known_share=summary.risk_share, braking_s=summary.braking_time,
        alarm_s=alarms * settings.period * 1e-9,
        unknown='' if known else _why_unknown(summary))


def _why_unknown(summary: DriveSummary) -> str:
    """Return the most frequent reason for which no tick has a risk."""
    if not summary.braking_time:
        return 'the brakes are not applied in this drive'
    reasons = sum((brake.unknown_risks for brake in summary.brakes.values()), Counter[str]())
    return next((text for text, _ in reasons.most_common(1)), 'no tick could be assessed')


def _prepared(inputs: VehicleInputs, signals: BrakeSignals,
              period: int) -> Iterator[PreparedTick]:
    """Pass each sample to the inputs at its time, and yield the ticks in between."""
    tick = -(-_ORIGIN // period)
    for row, elapsed in enumerate(signals.time.tolist()):
        stamp = _ORIGIN + round(1e9 * elapsed)
        while tick * period < stamp:
            yield inputs.prepare(tick * period)
            tick += 1
        for column, brake in enumerate(signals.brakes):
            for signal in _SIGNALS:
                inputs.receive(brake, signal, Sample(stamp, float(
                    getattr(signals, signal)[row, column])))
    yield inputs.prepare(tick * period)

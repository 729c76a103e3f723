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

"""Output of `squeal sensitivity`: a table a mode, the strongest parameter first; or JSON."""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import asdict
import math
from typing import Any, TypeAlias

from squeal_core.studies.design_sensitivity import (
    ModeEffect,
    OPERATING,
    ParameterEffect,
    SensitivityStudy,
)
from squeal_core.studies.target_modes import TargetMode
from squeal_ros.cli.listing import point_in_words

Units: TypeAlias = dict[str, tuple[float, str]]
"""Value and unit of each parameter."""
_HEADINGS = (f'{"one per cent more of":34} {"now":>14} {"growth 1/s":>11} {"error":>8} {"Hz":>8} '
             f'{"critical mu":>11} {"risk %":>7}  growth falls with; side effect')


def affine_only(name: str) -> str:
    """Return the note on what a model without a description cannot give."""
    return (f'{name} has no description of its brake: only what it is affine in can be varied '
            '(contact, damping, friction law, supports, stiffness of whole parts); for dimensions '
            'and densities give BRAKE.yaml, or a model that squeal build made')


def sensitivity_lines(study: SensitivityStudy, effects: Sequence[ParameterEffect], units: Units,
                      duration: float) -> Iterator[str]:
    """Yield the tables."""
    risks = study.risks()
    for place, target in enumerate(study.targets):
        yield from _heading(study, target, risks[place] if risks else math.nan, duration)
        yield _HEADINGS
        for effect in ranked(effects, place):
            yield _line(effect, place, target, *units[effect.parameter])
        yield ''
    for effect in effects:
        if effect.reason:
            yield f'not known: {effect.parameter}: {effect.reason}'


def _heading(study: SensitivityStudy, target: TargetMode, risk: float,
             duration: float) -> Iterator[str]:
    yield (f'mode {target.identity}, {target.frequency_hz:.0f} Hz, growth rate '
           f'{target.growth_rate:+.2f} 1/s')
    yield f'at {point_in_words(study.variants.model, target.point)}'
    critical = (f'{target.critical_friction:.4f}' if not math.isnan(target.critical_friction)
                else 'none, unstable down to 0' if target.growth_rate > 0.0
                else 'none, stable up to 1')
    known = '' if math.isnan(risk) else (
        f'; squeal risk of {duration:g} s of braking there {100.0 * risk:.1f} % (prior ensemble)')
    yield f'critical friction {critical}{known}'


def ranked(effects: Sequence[ParameterEffect], place: int) -> list[ParameterEffect]:
    """Return effects, the strongest on a mode's growth rate first, unreliable ones last."""
    return sorted((effect for effect in effects if not effect.reason), key=lambda effect: (
        not effect.modes[place].reliable, -abs(effect.modes[place].growth_rate)))


def _line(effect: ParameterEffect, place: int, target: TargetMode, value: float,
          unit: str) -> str:
    own = effect.modes[place]
    if not own.reliable:
        return (f'{effect.parameter:34} not known: the derivative is {own.growth_rate:+.3g} 1/s, '
                f'at -1 and +1 % the growth rate changes by {own.at_minus:+.3g} and '
                f'{own.at_plus:+.3g}')
    now = 'as given' if math.isnan(value) else f'{value:.5g} {unit}'.rstrip()
    critical = '' if math.isnan(own.critical_friction) else f'{own.critical_friction:+.5f}'
    risk = f'{100.0 * effect.risk[place]:+.2f}' if effect.risk else ''
    return (f'{effect.parameter:34} {now:>14} {own.growth_rate:+11.4f} {own.error:8.1g} '
            f'{own.frequency_hz:+8.2f} {critical:>11} {risk:>7}  {advice(own, target)}').rstrip()


def advice(own: ModeEffect, target: TargetMode) -> str:
    """Return the change that lowers the growth rate, and the mode it brings nearest to growing."""
    way = -math.copysign(1.0, own.growth_rate)
    text = 'less' if way < 0.0 else 'more'
    result = side_effect(own, target)
    if result is None:
        return text
    identity, frequency, growth, change = result
    return f'{text}; mode {identity} ({frequency:.0f} Hz, {growth:+.0f}) {change:+.2f}'


def side_effect(own: ModeEffect, target: TargetMode) -> tuple[str, float, float, float] | None:
    """
    Return the other mode that is brought to growing soonest by what lowers the target's growth.

    Its identity, frequency [Hz], growth rate and its change per per cent that way [1/s]; of modes
    that grow already the one that rises the most; None where none rises.
    """
    way = -math.copysign(1.0, own.growth_rate)
    rising = [(max(-root.real, 0.0) / (way * slope), -way * slope, identity, root, way * slope)
              for (identity, root), slope in zip(target.others, own.others, strict=True)
              if way * slope > 0.0]
    if not rising:
        return None
    _, _, identity, root, change = min(rising, key=lambda row: row[:2])
    return str(identity), root.imag / math.tau, root.real, change


def sensitivity_json(study: SensitivityStudy, effects: Sequence[ParameterEffect], units: Units,
                     note: str, options: argparse.Namespace) -> dict[str, Any]:
    """Return the output of `--json`."""
    risks = study.risks()
    return {
        'model': str(options.model), 'note': note, 'per': '1 % of the parameter',
        'braking_s': options.braking, 'plot': options.plot,
        'modes': [{
            'identity': str(target.identity), 'frequency_hz': target.frequency_hz,
            'growth_rate': target.growth_rate, 'point': asdict(target.point),
            'critical_friction': target.critical_friction,
            'squeal_risk': risks[place] if risks else None,
            'others': [{'identity': str(identity), 'frequency_hz': root.imag / math.tau,
                        'growth_rate': root.real} for identity, root in target.others],
        } for place, target in enumerate(study.targets)],
        'parameters': [{
            'parameter': effect.parameter, 'value': units[effect.parameter][0],
            'unit': units[effect.parameter][1],
            'of': 'operating point' if effect.parameter in OPERATING else 'brake',
            'method': method(study, effect.parameter), 'reason': effect.reason,
            'modes': [{**asdict(own), 'reliable': own.reliable,
                       'side_effect': _side_json(own, target)}
                      for own, target in zip(effect.modes, study.targets, strict=False)],
            'squeal_risk': list(effect.risk)} for effect in effects]}


def _side_json(own: ModeEffect, target: TargetMode) -> dict[str, Any] | None:
    result = side_effect(own, target)
    return None if result is None else dict(zip(
        ('identity', 'frequency_hz', 'growth_rate', 'change'), result, strict=True))


def method(study: SensitivityStudy, parameter: str) -> str:
    """Return the method of a derivative: 'affine' or 'rebuilt'."""
    if parameter in OPERATING or study.variants.affine(parameter):
        return 'affine'
    return 'rebuilt'

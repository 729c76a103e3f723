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

"""Report of a calibration: prior against posterior, and what it cannot tell apart."""

from typing import NamedTuple

import numpy as np
from scipy.special import ndtri
from squeal_core.calibration.calibrate import Calibration, ENOUGH_EVENTS
from squeal_core.calibration.candidates import BrakeCandidates, PARAMETERS
from squeal_core.common.arrays import FloatArray

_POINTS = 1024  # of the prior, for its mean and standard deviation
_UNIDENTIFIED = 0.1  # shrinkage below which nothing was learnt of a parameter alone
_MOVED = 0.8  # standard deviation of the best known combination, the prior's being 1
_LEAST_COEFFICIENT = 0.2
_RIDGE = ('ln_damping', 'friction_bias', 'audible_build_up')
_LEAST_EFFECTIVE = 64.0
_OF_FACTORS = {'ln_damping': 'damping', 'ln_contact_stiffness': 'contact stiffness'}
WORDS = {'ln_damping': 'ln damping', 'ln_contact_stiffness': 'ln contact stiffness',
         'friction_bias': 'friction bias', 'slope_scale': 'slope scale',
         'audible_build_up': 'N* [nepers]', 'friction_scatter': 'friction scatter',
         'damping_scatter': 'ln damping scatter'}


class ParameterRow(NamedTuple):
    """
    A parameter before and after calibration.

    Attributes
    ----------
    name : str
    prior_mean, prior_deviation, mean, deviation : float
        In its own unit.
    shrinkage : float
        1 minus the ratio of the standard deviations; 0: nothing was learnt of it alone.

    """

    name: str
    prior_mean: float
    prior_deviation: float
    mean: float
    deviation: float
    shrinkage: float


def parameter_rows(result: Calibration) -> list[ParameterRow]:
    """Return prior and posterior of each parameter."""
    points = (np.arange(_POINTS) + 0.5) / _POINTS
    before = BrakeCandidates.of_standard(result.prior, np.tile(
        ndtri(points)[:, None], len(PARAMETERS)))
    after = BrakeCandidates.of_standard(result.prior, result.sample.values)
    rows = []
    for name in PARAMETERS:
        prior, posterior = getattr(before, name), getattr(after, name)
        mean, deviation = float(result.sample.weights @ posterior), 0.0
        deviation = float(np.sqrt(result.sample.weights @ (posterior - mean)**2))
        own = float(prior.std())
        rows.append(ParameterRow(name, float(prior.mean()), own, mean, deviation,
                                 1.0 - deviation / own if own else 0.0))
    return rows


def factor_in_words(row: ParameterRow) -> str:
    """Return a factor, given by its logarithm, in % and words; '' for other parameters."""
    percent = round(100.0 * float(np.expm1(row.mean)))
    if row.name not in _OF_FACTORS or not percent:
        return ''
    return f'  {abs(percent)} % {"less" if percent < 0 else "more"} {_OF_FACTORS[row.name]}'


def remarks(result: Calibration) -> list[str]:
    """Return remarks for the reader: how far the data went, and what they leave open."""
    if not result.likelihood_power:
        return ['no event was fitted: the ensemble is the prior, not calibrated; record squeal'
                if not result.heard else 'data and model contradict each other: no draw of the '
                'ensemble explains them, and it is the prior, not calibrated; check the events']
    lines = []
    if result.power < 1.0:
        lines.append(
            f'{result.heard} events, fewer than {ENOUGH_EVENTS}: the likelihood counts '
            f'{result.power:.0%}, and the ensemble stays near the prior; record more squeal')
    if result.likelihood_power < result.power or \
            result.sample.effective_size < _LEAST_EFFECTIVE:
        lines.append(
            f'effective sample size {result.sample.effective_size:.0f} at '
            f'{result.likelihood_power:.0%} of the likelihood: too small to trust; data and '
            'model contradict each other, or labels are wrong')
    lines += _identified(result)
    return lines


def _identified(result: Calibration) -> list[str]:
    covariance = result.sample.covariance
    deviations = np.sqrt(np.diag(covariance))
    known, directions = np.linalg.eigh(covariance)
    width = np.sqrt(known[0])
    if width > _MOVED:
        return ['no combination of the parameters is known better than before']
    best, damping = directions[:, 0], PARAMETERS.index('ln_damping')
    is_damping = abs(best[damping]) >= _LEAST_COEFFICIENT
    best *= np.sign(best[damping if is_damping else np.abs(best).argmax()])
    name = 'effective damping = ' if is_damping else ''
    lines = [f'known best: {name}{_combination(best)} (in standard deviations of the prior), to '
             f'{width:.2f} of its prior standard deviation']
    pairs = [(a, b, covariance[i, j] / (deviations[i] * deviations[j]))
             for i, a in enumerate(PARAMETERS) for j, b in enumerate(PARAMETERS)
             if i < j and a in _RIDGE and b in _RIDGE]
    lines.append('damping, friction bias and N* lie on a ridge, correlations: ' + ', '.join(
        f'{WORDS[a]} and {WORDS[b]} {value:+.2f}' for a, b, value in pairs))
    open_ = [WORDS[name] for name, value in zip(PARAMETERS, deviations, strict=True)
             if value > 1.0 - _UNIDENTIFIED]
    if open_:
        lines.append(f'not identified alone, as wide as before: {", ".join(open_)}')
    return lines


def _combination(direction: FloatArray) -> str:
    parts = [f'{value:+.2f} {WORDS[name].partition(" [")[0]}'
             for name, value in zip(PARAMETERS, direction, strict=True)
             if abs(value) >= _LEAST_COEFFICIENT]
    return ' '.join(parts)


def report_lines(result: Calibration) -> list[str]:
    """Return the table of prior and posterior, the rounds and the remarks as text."""
    lines = [f'{"":22}{"prior":>9}{"sd":>8}{"posterior":>11}{"sd":>8}{"shrinkage":>11}']
    lines += [f'{WORDS[row.name]:22}{row.prior_mean:9.3f}{row.prior_deviation:8.3f}'
              f'{row.mean:11.3f}{row.deviation:8.3f}{row.shrinkage:11.0%}{factor_in_words(row)}'
              for row in parameter_rows(result)]
    lines.append(f'{len(result.sample.rounds)} rounds, {result.sample.rounds[-1].draws} draws, '
                 f'effective sample size {result.sample.effective_size:.0f}')
    return lines + remarks(result)

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

"""Likelihood of observations: hits, misses and pitches, with errors of ears and labels."""

from collections.abc import Sequence
import math

import numpy as np
from scipy.special import logsumexp
from squeal_core.calibration.applications import Observation
from squeal_core.calibration.hearing_model import HearingModel
from squeal_core.calibration.squeal_probability import SquealProbabilities
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.eigensolution import SQUEAL_BAND

_OTHER_PITCHES = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Probabilities, one as likely as another before, that a squeal's pitch is of no mode it has."""
_UNIFORM = 1.0 / math.log(SQUEAL_BAND[1] / SQUEAL_BAND[0])  # density over ln frequency


def log_likelihood(result: SquealProbabilities, observations: Sequence[Observation],
                   hearing: HearingModel) -> FloatArray:
    """
    Return the logarithm of the likelihood of observations in each candidate, (P,).

    Parameters
    ----------
    result : SquealProbabilities
        Of all applications.
    observations : sequence of Observation
        What was heard of them.
    hearing : HearingModel
        Rates of detection and errors.

    """
    heard = np.clip(hearing.heard(result.squeals), 1e-12, 1.0 - 1e-12)
    silent = [one.applications[0] for one in observations if not one.heard]
    total = np.log1p(-heard[:, silent]).sum(axis=1)
    pitches = np.zeros((len(_OTHER_PITCHES), len(heard)))
    for one in observations:
        if one.heard:
            places = list(one.applications)
            own = heard[:, places]
            total += np.log1p(-np.exp(np.log1p(-own).sum(axis=1)))
            if math.isfinite(one.frequency_hz):
                pitches += np.log(_pitch(result, places, one.frequency_hz, hearing)
                                  / own.sum(axis=1))
    return np.asarray(total + logsumexp(pitches, axis=0) - math.log(len(pitches)))


def _pitch(result: SquealProbabilities, places: list[int], frequency: float,
           hearing: HearingModel) -> FloatArray:
    """
    Return probability of an event times density of its pitch, summed over applications.

    One row for each probability that it is of no mode the model has. Any other says that its
    family exceeded N*. Which one of several that do is heard is not modelled: it may be the
    fastest, the first, or the one that stays after saturation.
    """
    off = np.log(frequency / result.frequency_hz[places]) / hearing.frequency_tolerance
    density = np.exp(-0.5 * off**2) / (math.sqrt(2.0 * math.pi) * hearing.frequency_tolerance)
    squeals = result.squeals[:, places]
    own = (result.by_family[:, places] * density).sum(axis=-1) - squeals * _UNIFORM
    right = (1.0 - 2.0 * hearing.label_error) * hearing.detection * own.sum(axis=-1)
    share = 1.0 - np.array(_OTHER_PITCHES)[:, None]
    return np.asarray(hearing.heard(squeals).sum(axis=-1) * _UNIFORM + share * right)

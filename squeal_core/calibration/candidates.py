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

"""Candidates of a calibration: persistent parameters of a brake, scatter by application."""

from dataclasses import dataclass, fields

import numpy as np
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.risk.ensemble import Ensemble, EnsemblePrior, MEMBERS, persistent

SCATTER_DEVIATION = 0.4  # of the logarithm of the scatters, about those of the prior


@dataclass(frozen=True, eq=False)
class BrakeCandidates:
    """
    P brakes that may be the measured one; arrays (P,).

    Parameters
    ----------
    ln_damping, ln_contact_stiffness, friction_bias, slope_scale, audible_build_up
        As of `Ensemble`.
    friction_scatter, damping_scatter
        Standard deviations from application to application of friction and ln damping.

    """

    ln_damping: FloatArray
    ln_contact_stiffness: FloatArray
    friction_bias: FloatArray
    slope_scale: FloatArray
    audible_build_up: FloatArray
    friction_scatter: FloatArray
    damping_scatter: FloatArray

    __repr__ = repr_with_shapes

    @classmethod
    def of_standard(cls, prior: EnsemblePrior, values: FloatArray) -> 'BrakeCandidates':
        """Return those at (P, 7) standard deviations from the prior's mean."""
        size = len(MEMBERS)
        scatter = np.exp(SCATTER_DEVIATION * values[:, size:])
        return cls(*persistent(prior, values[:, :size]), prior.friction_scatter * scatter[:, 0],
                   prior.damping_scatter * scatter[:, 1])

    @classmethod
    def of_ensemble(cls, ensemble: Ensemble) -> 'BrakeCandidates':
        """Return the members of an ensemble."""
        return cls(*(np.broadcast_to(getattr(ensemble, item.name), ensemble.weights.shape)
                     for item in fields(cls)))

    def ensemble(self, calibrated: str, likelihood_power: float = 1.0) -> Ensemble:
        """Return an ensemble of equal weights; its scatters are the means."""
        size = self.ln_damping.size
        return Ensemble(
            self.ln_damping, self.ln_contact_stiffness, self.friction_bias, self.slope_scale,
            self.audible_build_up, weights=np.ones(size),
            friction_scatter=float(self.friction_scatter.mean()),
            damping_scatter=float(self.damping_scatter.mean()), calibrated=calibrated,
            likelihood_power=likelihood_power)


PARAMETERS = tuple(item.name for item in fields(BrakeCandidates))

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

"""Checks of a freshly built model, each with its number: kept in its file, shown by `info`."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
import math
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.matrix_names import OPERATORS, SUPPORTS
from squeal_core.modes.modal_basis import ModalBasis, Quadrature
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Mode, SQUEAL_BAND
from squeal_core.stability.eigenvectors import mode_vectors

SPEEDS = (5.0, 20.0)  # rad/s, at which eigenvalues are looked at
_LEAST_MAC = 0.9  # under it interpolated shapes are other shapes
_FRICTION = 0.42
_PRELOAD = 2000.0  # N
_SHARES = {0.6: 10.0, 0.8: 5.0}  # of the modes -> what a growth rate may change [1/s]


@dataclass(frozen=True)
class Check:
    """One check: its name, its number, the limit it should keep, and its meaning."""

    name: str
    value: float
    limit: float
    meaning: str
    below: bool = True

    @property
    def passed(self) -> bool:
        """Return whether the value is on the right side of its limit."""
        return self.value <= self.limit if self.below else self.value >= self.limit

    def to_json(self) -> dict[str, Any]:
        return {**asdict(self), 'passed': self.passed}


def model_checks(model: BrakeModel, disc: ModalBasis, disc_circle: Quadrature,
                 refined: Callable[[], dict[str, FloatArray]],
                 interpolated: Iterable[tuple[str, float]] = ()) -> tuple[Check, ...]:
    """
    Return the checks of a model.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    disc : ModalBasis
        Dimensions and material.
    disc_circle : Quadrature
        Points on a circle of the rotor, evenly spaced, to count nodal diameters on.
    refined : callable
        Gives the contact arrays again, from a finer quadrature.
    interpolated : iterable of (component, least MAC)
        Of bases that were interpolated from nodes.

    """
    return (*_symmetry(model), _doublets(disc, disc_circle),
            *(Check(f'interpolation of {name}', mac, 0.99, 'least MAC of interpolated with given '
                    'shapes', below=False) for name, mac in interpolated),
            _quadrature(model, refined()), *_truncation(model), *_contact_damping(model),
            _backward_error(model))


def refuse_wrong(checks: Iterable[Check]) -> None:
    """Raise ModelError where a failed check means that the model is wrong, not just coarse."""
    for check in checks:
        if check.passed:
            continue
        if check.name.startswith(('symmetry', 'definiteness', 'backward')) or (
                check.name.startswith('interpolation') and check.value < _LEAST_MAC):
            raise ModelError(f'audit: {check.name} is {check.value:.3g} ({check.meaning}), limit '
                             f'{check.limit:g}; the model would be wrong: check meshes and units')


def _symmetry(model: BrakeModel) -> Iterable[Check]:
    for name in OPERATORS:
        array = getattr(model, name)
        if array is None or name in ('friction_couple', 'follower'):
            continue
        size = float(np.abs(array).max()) or 1.0
        sign = -1.0 if name == 'gyroscopic' else 1.0
        yield Check(f'symmetry of {name}', float(np.abs(array - sign * array.T).max() / size),
                    1e-9, 'skew' if sign < 0 else 'symmetric, relative to its largest entry')
        if sign > 0:
            yield Check(f'definiteness of {name}',
                        float(max(0.0, -np.linalg.eigvalsh(array).min()) / size), 1e-9,
                        'largest negative eigenvalue, relative')


def nodal_diameters(disc: ModalBasis, circle: Quadrature) -> list[int]:
    """Return the leading harmonic of each mode around a circle."""
    s = disc.sample(circle)
    power = sum(np.abs(np.fft.rfft(part, axis=1))**2
                for part in (s.radial, s.tangential, s.normal))
    return [int(n) for n in np.argmax(power, axis=1)]


def _doublets(disc: ModalBasis, circle: Quadrature) -> Check:
    """Count modes with n > 0 nodal diameters without their partner: they come in pairs."""
    w = disc.angular_frequencies
    alone = 0
    for n in set(nodal := nodal_diameters(disc, circle)) - {0}:
        own = [w[i] for i, m in enumerate(nodal) if m == n]
        while own:
            first = own.pop(0)
            if own and own[0] < first * 1.02:
                own.pop(0)
            else:
                alone += 1
    return Check('doublets without partner', float(alone), 0.0, 'a cut doublet would let results '
                 'depend on its orientation')


def _quadrature(model: BrakeModel, refined: dict[str, FloatArray]) -> Check:
    error = max(np.abs(getattr(model, name) - array).max() / (np.abs(array).max() or 1.0)
                for name, array in refined.items())
    return Check('contact quadrature', float(error), 5e-3,
                 'largest change of a contact array by a finer rule, relative')


def _points(model: BrakeModel) -> list[OperatingPoint]:
    return [OperatingPoint(
        rotor_speed=speed, friction=_FRICTION, contact_pressure=_PRELOAD / model.contact_area,
        contact_stiffness=model.nominal_contact_stiffness) for speed in SPEEDS]


def _truncation(model: BrakeModel) -> Iterable[Check]:
    """Yield checks of the growth rates that matter, with a fraction of the modes against all."""
    for share, limit in _SHARES.items():
        part, worst = truncated(model, share), 0.0
        for point in _points(model):
            modes = complex_modes(part, point).modes
            worst = max([worst, *(abs(mode.growth_rate - _nearest(modes, mode).growth_rate)
                                  for mode in _least_stable(complex_modes(model, point)))])
        yield Check(f'basis truncation to {share:.0%}', worst, limit, 'largest change of a growth '
                    'rate [1/s] of unstable modes, or of the least stable one where none is, at '
                    f'friction {_FRICTION:g}, {_PRELOAD:g} N, {SPEEDS[0]:g} and {SPEEDS[1]:g} '
                    'rad/s')


def _least_stable(result: ComplexModes) -> list[Mode]:
    """Return the modes that flutter, or the least stable one of the squeal band."""
    worst = result.worst_in(*SQUEAL_BAND)
    return [mode for mode in result.unstable if mode.kind == 'flutter'] or (
        [worst] if worst else [])


def _contact_damping(model: BrakeModel) -> Iterable[Check]:
    """Yield the loss factor of the layer's dashpots at the band's end: no lining's may be > 1."""
    if model.contact_retardation_time:
        end = SQUEAL_BAND[1]
        yield Check(f'contact loss factor at {end:.0f} Hz',
                    math.tau * end * model.contact_retardation_time, 1.0,
                    'of a viscous layer, in proportion to frequency')


def truncated(model: BrakeModel, share: float) -> BrakeModel:
    """Return the model with the lowest share of its modes, doublets whole."""
    order = np.argsort(model.angular_frequencies, kind='stable')
    count = max(1, round(share * model.size))
    w = model.angular_frequencies[order]
    while count < model.size and w[count] <= w[count - 1] * (1.0 + 5e-3):
        count += 1
    keep = np.sort(order[:count])
    arrays = {name: getattr(model, name)[np.ix_(keep, keep)] for name in (*OPERATORS, *SUPPORTS)
              if getattr(model, name) is not None}
    return BrakeModel(
        angular_frequencies=model.angular_frequencies[keep],
        damping_ratios=np.asarray(model.damping_ratios)[keep], contact_area=model.contact_area,
        contact_radius=model.contact_radius,
        nominal_contact_stiffness=model.nominal_contact_stiffness,
        contact_retardation_time=model.contact_retardation_time, **arrays)


def _nearest(modes: Sequence[Any], mode: Any) -> Any:
    return min(modes, key=lambda other: abs(other.eigenvalue - mode.eigenvalue))


def _backward_error(model: BrakeModel) -> Check:
    worst = max((mode_vectors(model, point, mode.eigenvalue).backward_error
                 for point in _points(model) for mode in complex_modes(model, point).unstable),
                default=0.0)
    return Check('backward error', worst, 1e-12, 'largest, of unstable eigenvalues')

"""Friction laws: the coefficient, its slope over sliding speed, and its table over temperature."""

from dataclasses import dataclass

import numpy as np

from squeal_core.arrays import FloatArray, readonly
from squeal_core.errors import SquealError


@dataclass(frozen=True)
class FrictionLaw:
    r"""Coefficient falling with sliding speed: mu_k + (mu_s - mu_k) exp(-alpha v).

    Parameters
    ----------
    static, kinetic : float
        mu_s and mu_k [-].
    decay : float
        alpha [s/m].

    Notes
    -----
    Source: K09 eqs (15), (A.8), (A.9).
    """

    static: float = 0.5
    kinetic: float = 0.32
    decay: float = 1.0

    def coefficient(self, sliding_speed: float) -> float:
        """Return mu at a sliding speed [m/s]."""
        fall = np.exp(-self.decay * abs(sliding_speed))
        return float(self.kinetic + (self.static - self.kinetic) * fall)

    def slope(self, sliding_speed: float) -> float:
        """Return d mu / d v [s/m] at a sliding speed [m/s]; negative for mu_s > mu_k."""
        fall = np.exp(-self.decay * abs(sliding_speed))
        return float(-self.decay * (self.static - self.kinetic) * fall)

    def slope_at(self, sliding_speed: float, measured: float) -> float:
        """Return the slope [s/m] when a measured mu replaces the law's: scaled in proportion."""
        return self.slope(sliding_speed) * measured / self.coefficient(sliding_speed)


@dataclass(frozen=True)
class FrictionTable:
    """Friction coefficient over disc temperature, linear between its points, flat beyond.

    Parameters
    ----------
    temperature : (M,) array
        Rising [K].
    friction : (M,) array
        mu [-].
    """

    temperature: FloatArray
    friction: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, 'temperature', readonly(self.temperature))
        object.__setattr__(self, 'friction', readonly(self.friction))
        if self.temperature.shape != self.friction.shape or self.temperature.ndim != 1:
            raise SquealError(
                f'friction table: {self.temperature.size} temperatures and {self.friction.size} '
                'friction coefficients; give as many of one as of the other')
        if self.temperature.size == 0 or np.any(np.diff(self.temperature) <= 0):
            raise SquealError(
                f'friction table: temperatures {self.temperature.tolist()} do not rise; sort them')
        if not np.all(self.friction > 0):
            raise SquealError(
                f'friction table: coefficients {self.friction.tolist()}; all must be positive')

    def __call__(self, temperature: FloatArray | float) -> FloatArray:
        """Return mu [-] at temperatures [K]."""
        return np.asarray(np.interp(temperature, self.temperature, self.friction))

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

"""Shares of applications with their uncertainty, over classes of a condition."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.common.arrays import FloatArray

Z = 1.959964  # of 95 % of a normal distribution


class Shares(NamedTuple):
    """
    Share of applications in each class, with 95 % intervals after Wilson.

    Parameters
    ----------
    edges : array (n + 1,)
    counts : array (n,)
        Applications of each class.
    share, low, high : arrays (n,)
        NaN for a class without applications.

    """

    edges: FloatArray
    counts: FloatArray
    share: FloatArray
    low: FloatArray
    high: FloatArray


def wilson(successes: ArrayLike, trials: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return share and the ends of its 95 % interval; NaN of no trials."""
    k, n = np.asarray(successes, float), np.asarray(trials, float)
    n = np.where(n > 0.0, n, np.nan)
    share = k / n
    centre = (share + Z**2 / (2.0 * n)) / (1.0 + Z**2 / n)
    half = Z / (1.0 + Z**2 / n) * np.sqrt(share * (1.0 - share) / n + Z**2 / (4.0 * n**2))
    return share, np.clip(centre - half, 0.0, share), np.clip(centre + half, share, 1.0)


def difference(first: tuple[int, int], second: tuple[int, int]) -> tuple[float, float, float]:
    """
    Return the second share minus the first, with the ends of its 95 % interval.

    By Newcombe's hybrid score method (Stat. Med. 17 (1998) 873-890, method 10).

    Parameters
    ----------
    first, second : (int, int)
        Successes and trials.

    """
    (p1, l1, u1), (p2, l2, u2) = (map(float, wilson(*one)) for one in (first, second))
    return (p2 - p1, p2 - p1 - math.hypot(p2 - l2, u1 - p1),
            p2 - p1 + math.hypot(u2 - p2, p1 - l1))


def shares(values: ArrayLike, successes: ArrayLike, edges: FloatArray, *,
           of_all: bool = False) -> Shares:
    """
    Return the share of successes in each class of a value.

    Parameters
    ----------
    values : array (k,)
        One an application.
    successes : boolean array (k,)
        Likewise.
    edges : array (n + 1,)
        Ends of the classes.
    of_all : bool
        Shares of all applications instead of those in the class.

    """
    values, hits = np.asarray(values, float), np.asarray(successes, bool)
    known = np.isfinite(values)
    counts = np.full(len(edges) - 1, len(values), float) if of_all else np.histogram(
        values[known], edges)[0].astype(float)
    return Shares(edges, counts, *wilson(np.histogram(values[known & hits], edges)[0], counts))


def classes(values: ArrayLike, width: float) -> FloatArray:
    """Return the edges of classes of a width that hold all values; at least one class."""
    known = np.asarray(values, float)
    known = known[np.isfinite(known)]
    low, high = (known.min(), known.max()) if known.size else (0.0, 0.0)
    first, last = math.floor(low / width), max(math.floor(high / width), math.floor(low / width))
    return width * np.arange(first, last + 2, dtype=float)


def exceedance(levels: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return levels, ascending, and the share of applications that reach each."""
    known = np.asarray(levels, float)
    known = np.sort(known[np.isfinite(known)])
    return known, 1.0 - np.arange(known.size) / max(known.size, 1)

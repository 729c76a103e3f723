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

from itertools import pairwise
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.common.arrays import FloatArray

Z = 1.959964  # of 95 % of a normal distribution


class Alarms(NamedTuple):
    """
    Known brake applications, and how many of them have predicted (or measured) squeal.

    Parameters
    ----------
    hits, known : int
    brakings : int
        Brakings of the vehicle that they are of: brakes that are applied at once are one.

    """

    hits: int
    known: int
    brakings: int

    @property
    def share(self) -> tuple[float, float, float]:
        """Share of the applications with squeal, and the ends of its 95 % interval."""
        share, low, high = map(float, share_of_brakings(*self))
        return share, low, high


class Shares(NamedTuple):
    """
    Share of applications in each class, with 95 % intervals of `share_of_brakings`.

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


def share_of_brakings(hits: ArrayLike, known: ArrayLike, brakings: ArrayLike
                      ) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Return the share of applications with squeal and the ends of its 95 % interval; NaN of none.

    The interval is Wilson's of as many trials as there were brakings of the vehicle. So brakes
    that are applied at once count as one trial: were they independent it would be narrower.
    """
    known, brakings = np.asarray(known, float), np.asarray(brakings, float)
    share = np.asarray(hits, float) / np.where(known > 0.0, known, np.nan)
    return wilson(share * brakings, brakings)


def difference(first: Alarms, second: Alarms) -> tuple[float, float, float]:
    """
    Return the second share minus the first, with the ends of its 95 % interval.

    By Newcombe's hybrid score method (Stat. Med. 17 (1998) 873-890, method 10), of the intervals
    of both shares.
    """
    (p1, l1, u1), (p2, l2, u2) = first.share, second.share
    return (p2 - p1, p2 - p1 - math.hypot(p2 - l2, u1 - p1),
            p2 - p1 + math.hypot(u2 - p2, p1 - l1))


def shares(values: ArrayLike, successes: ArrayLike, brakings: ArrayLike, edges: FloatArray, *,
           of_all: bool = False) -> Shares:
    """
    Return the share of successes in each class of a value.

    Parameters
    ----------
    values : array (k,)
        One an application.
    successes : boolean array (k,)
        Likewise.
    brakings : integer array (k,)
        Number of the braking of the vehicle that it is of.
    edges : array (n + 1,)
        Ends of the classes.
    of_all : bool
        Shares of all applications instead of those in the class.

    """
    values, hits = np.asarray(values, float), np.asarray(successes, bool)
    numbers = np.asarray(brakings)
    inside = [(values >= low) & (values < high) for low, high in pairwise(edges)]
    among = [np.ones(values.size, bool)] * len(inside) if of_all else inside
    counts = np.array([own.sum() for own in among], float)
    return Shares(edges, counts, *share_of_brakings(
        [(own & hits).sum() for own in inside], counts,
        [np.unique(numbers[own]).size for own in among]))


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

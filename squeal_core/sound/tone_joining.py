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

"""Pieces of tones -> tones: through gaps, beats, and frequencies that wobble within a window."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from squeal_core.sound.tone_tracker import Tone

GAP, _SAME = 0.25, 0.02  # s and fraction of the frequency, between two pieces of one tone
_BLOCK = 512  # windows in which tones are looked up
_WOBBLE, _LEAST_WOBBLE = 0.07, 210.0  # of the frequency, Hz, between pieces of an unsteady tone
_WEAKER = 10.0  # dB, likewise
_BESIDE = 3  # windows between them at most
_STRAIGHT, _DENSE, _FEW = 0.0015, 0.8, 7  # off a line; share of windows with it; windows


def unsteady_joined(pieces: Sequence[Tone]) -> list[Tone]:
    """
    Return tones of pieces that are there at once, near each other, and not both steady lines.

    A tone that wobbles, or is rough, has several lines in each window; of two steady ones both
    stay.
    """
    index = TimeIndex(sorted(pieces, key=lambda piece: -piece.peak_level))
    steady = {id(piece): _is_straight(piece) for piece in pieces}
    taken: set[int] = set()
    result = []
    for seed in index.tones:
        if id(seed) in taken:
            continue
        group, new = [seed], [seed]
        taken.add(id(seed))
        while new:
            one = new.pop()
            beside = [other for other in index.near(one, _BESIDE) if id(other) not in taken
                      and other.peak_level > seed.peak_level - _WEAKER
                      and abs(other.mean_frequency - seed.mean_frequency) < max(
                          _WOBBLE * seed.mean_frequency, _LEAST_WOBBLE)
                      and not (steady[id(other)] and any(steady[id(piece)] for piece in group))]
            taken.update(map(id, beside))
            group += beside
            new += beside
        result.append(_loudest_of(group))
    return result


def _is_straight(tone: Tone) -> bool:
    """Return whether a tone is in nearly all its windows, and glides evenly if at all."""
    if tone.frame.size < max(_FEW, _DENSE * (tone.last - tone.first + 1)):
        return False
    line = np.polynomial.Polynomial.fit(tone.frame, tone.frequency, 1)
    return bool((tone.frequency - line(tone.frame)).std() < _STRAIGHT * tone.mean_frequency)


def _loudest_of(pieces: Sequence[Tone]) -> Tone:
    """Return one tone of pieces: the loudest of them in each window."""
    if len(pieces) == 1:
        return pieces[0]
    whole = _one(sorted(pieces, key=lambda piece: -piece.peak_level))
    order = np.lexsort((-whole.level, whole.frame))
    _, first = np.unique(whole.frame[order], return_index=True)
    rows = order[first]
    return replace(whole, frame=whole.frame[rows], frequency=whole.frequency[rows],
                   level=whole.level[rows], prominence=whole.prominence[rows])


def joined(pieces: Sequence[Tone], gap: int) -> list[Tone]:
    """Return tones of pieces that follow each other at nearly one frequency, as through beats."""
    chains: list[list[Tone]] = []
    open_chains: list[list[Tone]] = []
    for piece in sorted(pieces, key=lambda piece: piece.first):
        open_chains = [chain for chain in open_chains if chain[-1].last + gap >= piece.first]
        near = [chain for chain in open_chains if chain[-1].last < piece.first and abs(
            chain[-1].frequency[-1] / piece.frequency[0] - 1.0) < _SAME]
        if near:
            min(near, key=lambda chain: abs(
                chain[-1].frequency[-1] - piece.frequency[0])).append(piece)
        else:
            chains.append([piece])
            open_chains.append(chains[-1])
    return [_one(chain) for chain in chains]


def _one(chain: Sequence[Tone]) -> Tone:
    if len(chain) == 1:
        return chain[0]
    frame, frequency, level, prominence = (
        np.concatenate([getattr(piece, name) for piece in chain])
        for name in ('frame', 'frequency', 'level', 'prominence'))
    loudest = max(chain, key=lambda piece: piece.peak_level)
    return Tone(frame, frequency, level, prominence, loudest.rated)


class TimeIndex:
    """Tones by the blocks of windows that they are in."""

    def __init__(self, tones: Sequence[Tone]) -> None:
        self.tones = tones
        self._blocks: dict[int, list[Tone]] = {}
        for tone in tones:
            for block in range(tone.first // _BLOCK, tone.last // _BLOCK + 1):
                self._blocks.setdefault(block, []).append(tone)

    def near(self, tone: Tone, reach: int) -> Iterator[Tone]:
        """Yield the tones, each once, at most so many windows from another one."""
        seen: set[int] = set()
        for block in range((tone.first - reach) // _BLOCK, (tone.last + reach) // _BLOCK + 1):
            for other in self._blocks.get(block, ()):
                if id(other) not in seen and other.last + reach >= tone.first \
                        and other.first - reach <= tone.last:
                    seen.add(id(other))
                    yield other

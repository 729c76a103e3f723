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

"""Brakes that share an axle, by the settings or by the names of the brakes."""

from collections.abc import Iterator, Mapping, Sequence
import re

from squeal_core.common.errors import ConfigurationError, short_repr

BY_NAME, NONE = 'auto', 'none'
_SIDES = {'left': 'right', 'links': 'rechts', 'l': 'r', 'lh': 'rh'}
_TOKEN = re.compile(r'[A-Z]?[a-z]+|[A-Z]+|\d+')


def axle_partners(brakes: Sequence[str], axles: Sequence[str]) -> dict[str, str]:
    """
    Return the brake on the other side of the axle, for each brake that has one.

    Parameters
    ----------
    brakes : sequence of str
        Names of the brakes.
    axles : sequence of str
        `['auto']`: by the names (front_left and front_right, FL and FR, wheel_1_l and wheel_1_r);
        `['none']`: no brakes are paired; else one `left+right` an axle.

    Raises
    ------
    ConfigurationError
        If there is none, an axle does not name two brakes, or a brake is named twice.

    """
    if list(axles) == [NONE]:
        return {}
    if list(axles) == [BY_NAME]:
        return _by_name(brakes)
    if not axles:
        raise ConfigurationError('axles', 'is []', "give ['none'] to pair no brakes, or leave it "
                                 'out to pair them by their names')
    partners: dict[str, str] = {}
    for axle in axles:
        left, plus, right = (part.strip() for part in axle.partition('+'))
        for name in (left, right):
            if not plus or name not in brakes or name in partners or left == right:
                raise ConfigurationError(
                    'axles', f'has {short_repr(axle)}',
                    "give ['auto'], ['none'] or entries such as "
                    f"'{brakes[0]}+{brakes[-1]}', each brake once")
        partners |= {left: right, right: left}
    return partners


def axle_shares(brakes: Sequence[str], partners: Mapping[str, str], ratio: float
                ) -> dict[str, float]:
    """
    Return the pressure of each brake of an axle over the mean of the other axles.

    Parameters
    ----------
    brakes : sequence of str
        Names of the brakes; the first that has a partner tells the front axle.
    partners : mapping
        As `axle_partners` returns it.
    ratio : float
        Pressure of each further axle over that of the front; 0: none is given, no shares.

    """
    paired = [name for name in brakes if name in partners]
    behind = len(paired) // 2 - 1  # axles
    if not ratio or behind < 1:
        return {}
    front = (paired[0], partners[paired[0]])
    rear = ratio * behind / (1.0 + (behind - 1) * ratio)
    return {name: 1.0 / ratio if name in front else rear for name in paired}


def in_words(partners: Mapping[str, str]) -> str:
    """Return the axles as the setting gives them."""
    return ', '.join(f'{left}+{right}' for left, right in partners.items()
                     if list(partners).index(left) < list(partners).index(right)) or 'none'


def _by_name(brakes: Sequence[str]) -> dict[str, str]:
    """Pair names that differ by their side only; a name with two candidates has no partner."""
    candidates: dict[str, set[str]] = {name: set() for name in brakes}
    known = {name.lower(): name for name in brakes}
    if len(known) < len(brakes):
        return {}
    for name in brakes:
        for mirrored in _mirrored(name):
            if (other := known.get(mirrored)) is not None:
                candidates[name].add(other)
                candidates[other].add(name)
    return {name: next(iter(others)) for name, others in candidates.items()
            if len(others) == 1 and candidates[next(iter(others))] == {name}}


def _mirrored(name: str) -> Iterator[str]:
    """Yield the lower-case names of the right side that a name of the left side may belong to."""
    for token in _TOKEN.finditer(name):
        for other in _other_side(token.group().lower()):
            yield (name[:token.start()] + other + name[token.end():]).lower()


def _other_side(token: str) -> Iterator[str]:
    """Yield 'right' for 'left', 'fr' for 'fl', 'rf' for 'lf' and the like."""
    if token in _SIDES:
        yield _SIDES[token]
    elif len(token) == 2 and token[1] == 'l':
        yield token[0] + 'r'
    elif len(token) == 2 and token[0] == 'l':
        yield 'r' + token[1]
    for left, right in (('left', 'right'), ('links', 'rechts')):
        if token != left and left in token:
            yield token.replace(left, right)

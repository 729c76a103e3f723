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

"""The short name of a mode: the component modes that lead in it, for labels of plots."""

import re

import numpy as np
from squeal_core.common.arrays import ComplexArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.mechanism import participation, Share

_AS_MUCH = 0.8  # of the larger share, from which on a second one is named, too
_PAD = re.compile(r'pad \d+ (.+)')


def short_name(model: BrakeModel, right: ComplexArray) -> str:
    """
    Return the component modes that lead in a mode: 'pads roll', 'disc (1,2)+(4,0)'.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model; without names of its component modes the name is empty.
    right : (N,) complex
        Mode, at the point that is drawn.

    Notes
    -----
    A second component is named where it has at least 80 % of the kinetic energy of the first.
    Pads count together where they share a motion as evenly as that.

    """
    if not model.names or not np.any(right):
        return ''
    first, *others = _pads_together(participation(model, right, top=model.size))
    if not others or others[0].fraction < _AS_MUCH * first.fraction:
        return first.name
    part, _, motion = others[0].name.rpartition(' ')
    same = part and first.name.rpartition(' ')[0] == part
    return f'{first.name}+{motion if same else others[0].name}'


def _pads_together(shares: tuple[Share, ...]) -> list[Share]:
    """Return shares from the largest on, those of pads that move alike as one."""
    result: list[Share] = []
    alike: dict[str, Share] = {}
    for share in shares:  # falling
        pad = _PAD.fullmatch(share.name)
        larger = alike.setdefault(pad[1], share) if pad else share
        if larger in result and share.fraction >= _AS_MUCH * larger.fraction:
            result[result.index(larger)] = Share(
                f'pads {pad[1]}' if pad else share.name, larger.fraction + share.fraction)
        else:
            result.append(share)
    return sorted(result, key=lambda share: -share.fraction)

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

"""Places that an event of measured squeal may name: brakes, axles and sides of a vehicle."""

from collections.abc import Sequence

from squeal_core.monitor.axles import axle_partners, BY_NAME

_SIDES = ('left', 'right')


def event_places(brakes: Sequence[str], axles: Sequence[str] = (BY_NAME,)
                 ) -> dict[str, tuple[str, ...]]:
    """
    Return the brakes of each place: themselves, axles by both ends or a common name, sides.

    Parameters
    ----------
    brakes : sequence of str
        Names.
    axles : sequence of str
        As of the settings of a monitor.

    Examples
    --------
    >>> event_places(['front_left', 'front_right'])['front']
    ('front_left', 'front_right')

    """
    places: dict[str, tuple[str, ...]] = {name: (name,) for name in brakes}
    for left, right in axle_partners(list(brakes), tuple(axles)).items():
        if brakes.index(left) < brakes.index(right):
            places[f'{left}+{right}'] = (left, right)
            shared = ''.join(a if a == b else '\0' for a, b in zip(left, right, strict=False))
            axle = shared.partition('\0')[0].rstrip('_- ')
            if axle and axle not in places:
                places[axle] = (left, right)
    for side in _SIDES:
        own = tuple(name for name in brakes if side in name.lower())
        if own and side not in places:
            places[side] = own
    return places

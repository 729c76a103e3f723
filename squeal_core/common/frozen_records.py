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

"""Fast construction of frozen dataclasses."""

from typing import Any, TypeVar

Record = TypeVar('Record')


def frozen_record(kind: type[Record], /, **values: Any) -> Record:
    """
    Return a frozen dataclass with these values, without its `__init__`.

    That sets one field by one call: those of an assessment take 7 us, and 0.5 us together.

    Parameters
    ----------
    kind : type
        Has no slots and checks nothing when it is made.
    values
        By the names of fields; one that is left out has its default, which is no factory.

    Examples
    --------
    >>> from squeal_core.brake.operating_point import SlidingConditions
    >>> frozen_record(SlidingConditions, rotor_speed=5.0, pressure=1e6, friction=0.4)
    SlidingConditions(rotor_speed=5.0, pressure=1000000.0, friction=0.4, contact_stiffness=None)

    """
    record = object.__new__(kind)
    vars(record).update(values)
    return record

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

"""
Work in steps: a generator that yields calls, and is sent what they return.

Whoever drives it makes the calls, where it likes. They are pure: it does not matter who makes
them, nor whether two do. What lies between them is brief.
"""

from collections.abc import Callable, Generator
from functools import partial
from typing import Any, TypeAlias, TypeVar

_Result = TypeVar('_Result')
Call: TypeAlias = Callable[[], Any]
Steps: TypeAlias = Generator[Call, Any, _Result]


def completed(steps: 'Steps[_Result]') -> _Result:
    """Make all the calls, here and now; return the result."""
    try:
        call = next(steps)
        while True:
            try:
                found = call()
            except Exception as error:
                call = steps.throw(error)
            else:
                call = steps.send(found)
    except StopIteration as end:
        result: _Result = end.value
        return result


def in_a_step(task: Callable[..., _Result]) -> 'Callable[..., Steps[_Result]]':
    """Turn a function into work of one step."""
    def steps(*arguments: Any, **options: Any) -> 'Steps[_Result]':
        found: _Result = yield partial(task, *arguments, **options)
        return found
    return steps

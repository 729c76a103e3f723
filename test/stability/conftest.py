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

"""Mechanisms of the shipped model, which several tests look at."""

from collections.abc import Callable
from functools import cache

import pytest
from squeal_core import BrakeModel
from squeal_core.stability.mechanism import Mechanism, mechanisms
from support.stability_models import kang_point, kang_point_by_law


@pytest.fixture(scope='session')
def of_k09(kang: BrakeModel) -> Callable[[float, bool], tuple[Mechanism, ...]]:
    """Return what gives the mechanisms at a speed, at constant friction or by the law, once."""
    @cache
    def found(speed: float, law: bool) -> tuple[Mechanism, ...]:
        return mechanisms(kang, kang_point_by_law(kang, speed) if law else kang_point(kang, speed))

    return found

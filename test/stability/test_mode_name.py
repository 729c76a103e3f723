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

"""The short name of a mode, by who takes part."""

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.stability.mode_name import short_name

NAMES = ('disc (2,0)c', 'disc (2,0)s', 'pad 1 roll', 'pad 1 pitch', 'disc (1,1)c', 'pad 2 roll')


@pytest.mark.parametrize(('energies', 'name'), [
    ((30, 30, 10, 10, 10, 10), 'disc (2,0)'),
    ((5, 5, 30, 10, 10, 25), 'pads roll'),
    ((5, 5, 30, 10, 10, 20), 'pad 1 roll'),  # not as evenly
    ((5, 5, 30, 26, 10, 5), 'pad 1 roll+pitch'),
    ((25, 22, 20, 0, 0, 20), 'disc (2,0)+pads roll'),
    ((25, 22, 15, 0, 40, 0), 'disc (2,0)+(1,1)c')])
def test_a_name_tells_who_leads_and_who_has_nearly_as_much(
        energies: tuple[float, ...], name: str) -> None:
    model = BrakeModel(angular_frequencies=[1e3, 1e3, 2e3, 3e3, 4e3, 2e3], names=NAMES)
    assert short_name(model, 2j * np.sqrt(energies)) == name


def test_a_model_without_names_names_nothing() -> None:
    assert short_name(BrakeModel(angular_frequencies=[1e3, 2e3]), np.array([0j, 1.0])) == ''

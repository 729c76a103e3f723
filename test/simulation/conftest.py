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


"""The contact points of the shipped model, for the tests of this folder."""

import pytest
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.operators import ContactFace
from squeal_core.simulation import contact_points


@pytest.fixture(scope='session')
def faces(kang: BrakeModel, solved_once: None) -> tuple[ContactFace, ContactFace]:
    """Return both faces with 128 points each."""
    return contact_points(kang)

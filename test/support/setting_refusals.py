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

"""Settings of one brake, and refusals of wrong ones."""

from typing import Any

import pytest
from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.settings import read_settings


def read(**changes: Any) -> Any:
    """Return settings of one brake `a`; `a__pressure__topic` stands for a.pressure.topic."""
    return read_settings({'brakes': ['a'],
                          **{key.replace('__', '.'): v for key, v in changes.items()}})


def refusal(parameters: Any, reader: Any = read_settings) -> str:
    """Return the refusal, which is one line that ends with a remedy."""
    with pytest.raises(ConfigurationError) as caught:
        reader(parameters)
    text = str(caught.value)
    assert len(text.splitlines()) == 1
    assert text.rpartition('; ')[2]
    return text

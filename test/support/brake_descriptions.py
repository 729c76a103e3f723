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

"""The shipped brake description, edited; what a refusal of it says."""

from collections.abc import Iterable
from copy import deepcopy
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

import pytest
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.common.errors import BrakeDescriptionError
import yaml

SHIPPED = Path(__file__).parents[2] / 'config' / 'brakes' / 'kang2009.yaml'
CONTENT = yaml.safe_load(SHIPPED.read_text(encoding='utf-8'))
OPTIONAL = ('title', 'caliper.efficiency')
DELETED = object()


def numeric_keys(mapping: dict[str, Any], prefix: str = '') -> list[str]:
    """Paths of all scalars of the shipped description that carry a source."""
    found = []
    for key, value in mapping.items():
        if isinstance(value, dict):
            found += ([f'{prefix}{key}'] if 'value' in value
                      else numeric_keys(value, f'{prefix}{key}.'))
    return found


NUMBERS = numeric_keys(CONTENT)


def place_of(sections: Iterable[str], content: dict[str, Any]) -> dict[str, Any]:
    return reduce(getitem, sections, content)


def edited(changes: dict[str, Any]) -> dict[str, Any]:
    """Return the shipped description with values at dotted paths replaced, added or deleted."""
    content = deepcopy(CONTENT)
    for path, value in changes.items():
        *sections, key = path.split('.')
        place = place_of(sections, content)
        place[key] = value
        if value is DELETED:
            del place[key]
    return content


def refusal(content: Any, read: Any = parse_brake) -> str:
    with pytest.raises(BrakeDescriptionError) as caught:
        read(content, warn=lambda _: None)
    text = str(caught.value)
    assert len(text.splitlines()) == 1
    assert text.rpartition('; ')[2]
    return text


def check(text: str, *parts: str) -> None:
    assert [part for part in parts if part not in text] == []

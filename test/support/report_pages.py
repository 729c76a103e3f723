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

"""Pages of `squeal report` and what is in them."""

import base64
import json
from pathlib import Path
import re
from typing import Any

import numpy as np
from squeal_core.view.report.page import report_page
from squeal_core.view.report.runs import load_runs


def page_of(*folders: Path) -> str:
    return report_page(load_runs(folders))


def figures_of(page: str) -> list[dict[str, Any]]:
    found = re.search(r'<script type="application/json" id="figures">(.*?)</script>', page)
    assert found
    return list(json.loads(found[1]))


def unpacked(array: dict[str, str]) -> Any:
    return np.frombuffer(base64.b64decode(array['bdata']), array['dtype'])

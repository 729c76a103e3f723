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

"""Archives taken apart and written again, damaged or not."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common.npz_archive import content_hash


def parts(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the header and the arrays of an archive."""
    with np.load(path) as file:
        return json.loads(str(file['header'])), {k: file[k] for k in file.files if k != 'header'}


def rewrite(path: Path, header: Any = None, arrays: Any = None, *,
            with_right_hash: bool = True) -> Path:
    """Write a file again with parts of its header or some arrays replaced."""
    old, kept = parts(path)
    header, arrays = {**old, **(header or {})}, {**kept, **(arrays or {})}
    if with_right_hash:
        header['hash'] = content_hash(header, arrays)
    np.savez(path, header=np.array(json.dumps(header)), **arrays)
    return path

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

"""Files and settings that the replay of a recording rests on; its model as the file is now."""

from functools import lru_cache
import hashlib
from pathlib import Path
from typing import Any

from squeal_core.common import resources
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.results.result_summary import file_hash, sources_of
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.recordings.signals.signals_file import Signals


def task_sources(model: BrakeModel, settings: MonitorSettings, signals: Signals | None,
                 types: str | Path | None) -> dict[str, Any]:
    """Return the sources of `sources_of`, and the files of signals and message types or None."""
    return {
        **sources_of(model, settings),
        'signals': signals and {'path': str(signals.path), 'sha256': signals.sha256},
        'types': {'path': str(types), 'sha256': _definitions_hash(Path(types))} if types else None}


def model_as_it_is(name: str) -> BrakeModel:
    """Return a model, read anew where its file has changed: workers of a cluster outlive it."""
    path = resources.find('models', name, '.npz')
    return _model(name, file_hash(path)[0] if path.is_file() else '')


@lru_cache(maxsize=1)
def _model(name: str, _: str) -> BrakeModel:
    return BrakeModel.load(name)


def _definitions_hash(folder: Path) -> str:
    """Return SHA-256 over the definitions of message types in a folder, by their paths in it."""
    from squeal_ros.recordings.bags.message_definitions import definition_files  # asks for rosbags

    digest = hashlib.sha256()
    for path in sorted(definition_files(folder)):
        digest.update(f'{path.relative_to(folder).as_posix()} {file_hash(path)[0]}\n'.encode())
    return digest.hexdigest()

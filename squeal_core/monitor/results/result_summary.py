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

"""Files and settings that a result rests on, with their hashes."""

from dataclasses import asdict
import hashlib
import json
from pathlib import Path
import platform
from typing import Any

import numpy as np
import scipy
from squeal_core.calibration.calibration_file import read_calibration
from squeal_core.common import resources
from squeal_core.common.json_values import plain
from squeal_core.common.version import __version__
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.risk_warnings import NONE
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_stability import NO_TABLE
from squeal_core.risk.emulator_file import find_emulator
from squeal_core.risk.ensemble import NOT_CALIBRATED, risk_basis
from squeal_core.surrogate.table_file import find_table

_CHUNK = 1 << 20  # bytes


def file_hash(path: str | Path) -> tuple[str, int]:
    """Return SHA-256 and size [bytes] of a file, or of the files in a folder by their names."""
    digest, size = hashlib.sha256(), 0
    at = Path(path)
    for part in sorted(at.iterdir()) if at.is_dir() else [at]:
        if part.is_file():
            with part.open('rb') as file:
                while data := file.read(_CHUNK):
                    digest.update(data)
                    size += len(data)
    return digest.hexdigest(), size


def sources_of(model: BrakeModel, settings: MonitorSettings) -> dict[str, Any]:
    """Return software, model, table, emulator, calibration and settings of a replay."""
    table, emulator = settings.table, settings.growth_emulator
    if not table and (result := find_table(model)):
        table = str(result[0])
    if not emulator and (own := find_emulator(model)):
        emulator = str(own[0])
    text = json.dumps(plain(asdict(settings)), indent=1)  # which is YAML too
    return {
        'software': {'squeal_ros': __version__, 'python': platform.python_version(),
                     'numpy': np.__version__, 'scipy': scipy.__version__},
        'model': {'name': settings.model,
                  **_file(resources.find('models', settings.model, '.npz'))},
        'table': _file(table) if table and table != NO_TABLE else None,
        'emulator': _file(emulator) if emulator and emulator != NONE else None,
        'calibration': _file(settings.calibration) if settings.calibration else None,
        'risk_basis': _basis(model, settings),
        'settings': {'sha256': hashlib.sha256(text.encode()).hexdigest(), 'yaml': text},
        'rate_hz': settings.rate}


def _basis(model: BrakeModel, settings: MonitorSettings) -> str:
    """Return the basis of the level of the squeal risk."""
    if not settings.calibration:
        return NOT_CALIBRATED
    ensemble = read_calibration(settings.calibration, model)
    return risk_basis(ensemble.calibrated, ensemble.likelihood_power)


def _file(path: str | Path) -> dict[str, str]:
    return {'path': str(path), 'sha256': file_hash(path)[0]}

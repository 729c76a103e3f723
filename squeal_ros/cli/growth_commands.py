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

"""The part of `squeal tabulate` that builds the growth emulator of a model."""

import argparse
from dataclasses import asdict
import json
from pathlib import Path

from squeal_core.common.output import make_folder
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.emulator_builder import build_growth_emulator
from squeal_core.risk.emulator_file import cached_emulator_path, emulator_path, write_emulator
from squeal_core.risk.growth_emulator import GrowthEmulator
from squeal_ros.cli.console import plain, ProgressBar


def tabulate_growth(model: BrakeModel, options: argparse.Namespace, *, quiet: bool = False) -> int:
    """Build the growth emulator, write it beside the table, and print its error."""
    path = emulator_path(options.output) if options.output else cached_emulator_path(model)
    emulator = build_emulator_file(path, model, workers=options.workers,
                                   overwrite=options.force or not options.output)
    error = emulator.error
    if options.json and not quiet:
        print(json.dumps(plain({
            'output': str(path), 'megabytes': path.stat().st_size / 1e6, 'error': asdict(error),
            'families': [asdict(family) for family in emulator.families]})))
    elif not options.json:
        print(f'{path}: {len(emulator.families)} families of modes; growth rates within '
              f'{error.rms:.2g} 1/s rms, {error.largest:.2g} 1/s at most, at {error.points} full '
              'solutions')
    return 0


def build_emulator_file(path: Path, model: BrakeModel, *, workers: int, overwrite: bool,
                        of: str = '') -> GrowthEmulator:
    """Build the growth emulator of a model and write it; progress says of which model."""
    make_folder(path.parent)
    with ProgressBar(f'full solutions{of}') as progress:
        emulator = build_growth_emulator(model, workers=workers, progress=progress.timed)
    write_emulator(path, emulator, model, overwrite=overwrite)
    return emulator

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
import time

from squeal_core.common.output import make_folder
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.emulator_builder import build_growth_emulator
from squeal_core.risk.emulator_file import cached_emulator_path, emulator_path, write_emulator
from squeal_ros.cli.console import plain, ProgressBar, time_left


def tabulate_growth(model: BrakeModel, options: argparse.Namespace, *, quiet: bool = False) -> int:
    """Build the growth emulator, write it beside the table, and say how good it is."""
    path = emulator_path(options.output) if options.output else cached_emulator_path(model)
    make_folder(path.parent)
    begun = time.monotonic()
    with ProgressBar('full solutions') as progress:
        emulator = build_growth_emulator(
            model, workers=options.workers, progress=lambda done, total: progress(
                done, total, time_left(begun, done, total)))
    write_emulator(path, emulator, model, overwrite=options.force or not options.output)
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

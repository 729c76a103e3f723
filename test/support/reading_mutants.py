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

"""
A process that reads damaged files: `reading_mutants.py KIND FIRST COUNT FOLDER`.

It may take 500 MB beyond what it holds when it starts, and prints as JSON what became of the
files. What is read after all is used once.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Callable  # noqa: I100
from dataclasses import dataclass, field
import json
import math
import os
from pathlib import Path
import random
import resource
import sys
import time
import traceback
from typing import Any
import warnings

from squeal_core import BrakeModel
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.brake.dimensions import Caliper, StiffnessTable
from squeal_core.brake.friction import FrictionLaw, FrictionTable
from squeal_core.common.errors import (
    BrakeDescriptionError,
    ModelFileError,
    SquealError,
    TableFileError,
)
from squeal_core.common.resources import find
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import Sample, VehicleMonitor
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_file import read_table, write_table
from squeal_core.surrogate.tabulated_solver import TabulatedSolver
from support.engine_models import point, random_model
from support.mutants import mutant_of_archive, mutant_of_text

LIMIT = 500_000_000  # bytes
LONGEST = 700  # characters of an error beyond its path
INPUTS = {'rotor_speed': 20.0, 'pressure': 7.84e5, 'friction': 0.42}


def small_model() -> BrakeModel:
    return random_model(
        4, caliper=Caliper(2.5e-3, 0.9), friction_law=FrictionLaw(0.55, 0.3, 0.3),
        friction_table=FrictionTable((293.0, 500.0), (0.4, 0.35)),
        stiffness_table=StiffnessTable((0.0, 1e6), (2e10, 4e10)),
        names=('a', 'b', 'c', 'Biegung ü'), provenance={'brake': 'small', 'audit': [
            {'name': 'x', 'passed': True}]})


@dataclass
class Kind:
    """Files of one kind: a whole one, how it is damaged, read and used."""

    whole: bytes
    mutate: Callable[[bytes, random.Random], bytes]
    read: Callable[[Path], Any]
    error: type[SquealError]
    use: Callable[[Any], None] = lambda found: None


def assess(model: BrakeModel) -> None:
    """Have a model that was read serve a monitor, or be refused by it in one line."""
    try:
        vehicle = VehicleMonitor(read_settings({'brakes': ['fl']}), model)
    except SquealError:
        return
    for signal, value in INPUTS.items():
        vehicle.receive('fl', signal, Sample(10**9, value))  # type: ignore[arg-type]
    found, = vehicle.assess(10**9)
    assert not found.is_valid or math.isnan(found.risk)  # a model without an emulator
    assert not found.is_valid or 0.0 <= found.instability_probability <= 1.0
    assert found.is_valid or found.reason


def kind_of(name: str, folder: Path) -> Kind:
    path = folder / 'whole'
    if name == 'brake':
        return Kind(find('brakes', 'kang2009', '.yaml').read_bytes(), mutant_of_text,
                    lambda path: read_brake(path, warn=lambda _: None), BrakeDescriptionError)
    model = small_model()
    if name == 'table':
        write_table(build_table(model, TableDomain.usual(
            model, rotor_speed=(18.0, 22.0), preload=(1000.0, 2000.0), friction=(0.4, 0.45))),
            model, path)
        return Kind(
            path.read_bytes(), mutant_of_archive, lambda file: read_table(file, model),
            TableFileError,
            lambda found: TabulatedSolver(model, found).solve(point()))
    if name == 'shipped model':
        return Kind(find('models', 'kang2009', '.npz').read_bytes(), mutant_of_archive,
                    BrakeModel.load, ModelFileError)
    model.save(path)
    return Kind(path.read_bytes(), mutant_of_archive, BrakeModel.load, ModelFileError, assess)


@dataclass
class Found:
    """What became of the mutants."""

    refused: int = 0
    read: int = 0
    failures: list[str] = field(default_factory=list)
    slowest: float = 0.0  # s of computing
    memory: int = 0  # bytes beyond those at the start

    def take(self, number: int, kind: Kind, path: Path) -> None:
        """Read one mutant, and use it."""
        start = time.process_time()
        try:
            held = kind.read(path)
        except kind.error as error:
            text = str(error).removeprefix(str(path))
            if '\n' in text or len(text) > LONGEST or 'MemoryError' in text:
                self.failures.append(f'{number}: {text[:400]}')
            self.refused += 1
        except BaseException:
            self.failures.append(f'{number}: {traceback.format_exc()[-900:]}')
        else:
            self.read += 1
            self.slowest = max(self.slowest, time.process_time() - start)
            try:
                kind.use(held)
            except BaseException:
                self.failures.append(f'{number} in use: {traceback.format_exc()[-900:]}')
            return
        self.slowest = max(self.slowest, time.process_time() - start)


def resident() -> int:
    """Return the most this process ever held [bytes]; getrusage would count its parent in."""
    status = Path('/proc/self/status').read_text()
    return 1024 * int(status.partition('VmHWM:')[2].split()[0])


def main(name: str, first: int, count: int, folder: Path) -> None:
    warnings.simplefilter('ignore')  # of numbers that overflow
    kind, found, path = kind_of(name, folder), Found(), folder / 'mutant'
    path.write_bytes(kind.whole)
    kind.use(kind.read(path))
    held = int(Path('/proc/self/statm').read_text().split()[0]) * os.sysconf('SC_PAGE_SIZE')
    before = resident()
    for number in range(first, first + count):
        # made without a limit, read within one
        resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        path.write_bytes(kind.mutate(kind.whole, random.Random(f'{name} {number}')))
        resource.setrlimit(resource.RLIMIT_AS, (held + LIMIT, resource.RLIM_INFINITY))
        found.take(number, kind, path)
    found.memory = resident() - before
    print(json.dumps({**vars(found), 'failures': found.failures[:20]}))


if __name__ == '__main__':
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]))

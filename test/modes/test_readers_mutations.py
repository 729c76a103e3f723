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
Truncated files and flipped bytes give one line or plausible modes: no noise, no crash, no wait.

Of what a reader returns, only that it can be used is asked: a flipped digit cannot be told.
"""

from pathlib import Path
import time
from typing import Any

import numpy as np
import pytest
from squeal_core.modes.nodal_modes import NodalModes
from squeal_core.modes.readers import read_modes, ReaderError
from support.processes import short_and_long
from support.reader_samples import options, SAMPLES, write_sample

CUTS, LINES = 24, 18
FEWER = {'op2': 16, 'nastran_h5': 8}  # pyNastran takes its time, HDF5 a process of its own


def outcome(path: Path, told: dict[str, Any]) -> ReaderError | NodalModes:
    """Return what a file gives, within seconds of computing; an error is one line."""
    start = time.process_time()  # not the clock: others may be at work
    try:
        found: ReaderError | NodalModes = read_modes(path, **told)
    except ReaderError as error:
        text = str(error)
        assert '\n' not in text
        assert text.startswith(str(path))
        assert len(text) < 400 + len(str(path))
        found = error
    assert time.process_time() - start < 3.0
    return found


@short_and_long('flips', 40, 1000)
@pytest.mark.parametrize('name', SAMPLES)
def test_flipped_bytes(name: str, flips: int, tmp_path: Path,
                       capfd: pytest.CaptureFixture[str]) -> None:
    path = write_sample(name, tmp_path)
    data, told = bytearray(path.read_bytes()), options(name)
    whole = outcome(path, told)
    assert isinstance(whole, NodalModes)
    random = np.random.default_rng(1)
    capfd.readouterr()
    refused = 0
    for _ in range(min(FEWER.get(name, flips), flips)):
        at, bit = int(random.integers(len(data))), 1 << int(random.integers(8))
        data[at] ^= bit
        path.write_bytes(data)
        data[at] ^= bit
        found = outcome(path, told)
        refused += isinstance(found, ReaderError)
        if isinstance(found, NodalModes):
            assert found.shapes.shape[1:] == (len(found.coordinates), 3)
            assert all(block.nodes.min() >= 0 and block.nodes.max() < len(found.coordinates)
                       for block in found.elements)
    assert capfd.readouterr() == ('', '')
    assert refused > 0


@pytest.mark.parametrize('name', SAMPLES)
def test_truncations(name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Nearly every cut is seen: a text may by chance end with a mode or a node."""
    path = write_sample(name, tmp_path)
    data, told = path.read_bytes(), options(name)
    random = np.random.default_rng(2)
    capfd.readouterr()
    cuts = [0, 1, 2, 10, *random.integers(len(data) - 2, size=FEWER.get(name, CUTS) // 2).tolist()]
    refused = 0
    for cut in cuts:
        path.write_bytes(data[:cut])
        refused += isinstance(outcome(path, told), ReaderError)
    assert capfd.readouterr() == ('', '')
    assert refused >= 0.9 * len(cuts)


@pytest.mark.parametrize('name', [name for name in SAMPLES if name not in ('op2', 'nastran_h5')])
def test_lines_lost_doubled_and_swapped(name: str, tmp_path: Path) -> None:
    path = write_sample(name, tmp_path)
    lines, told = path.read_bytes().split(b'\n'), options(name)
    random = np.random.default_rng(3)
    refused = 0
    for k in range(LINES):
        i, j = sorted(random.integers(len(lines), size=2).tolist())
        changed = [*lines]
        if k % 3 == 0:
            del changed[i]
        elif k % 3 == 1:
            changed.insert(j, lines[i])
        else:
            changed[i], changed[j] = changed[j], changed[i]
        path.write_bytes(b'\n'.join(changed))
        refused += isinstance(outcome(path, told), ReaderError)
    assert refused > LINES / 3

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

"""Decks for CalculiX, and its runs."""

from collections.abc import Sequence
from pathlib import Path
import shutil
import subprocess

import numpy as np
import pytest
from squeal_core.brake.dimensions import Material


def deck(where: np.ndarray, elements: np.ndarray, material: Material, modes: int,
         held: Sequence[int] = ()) -> str:
    """Input in mm, t, s (MPa and t/mm^3) of C3D20 elements by place of their nodes [mm]."""
    lines = ['*NODE, NSET=ALL']
    lines += [f'{k + 1}, ' + ', '.join(f'{c:.9e}' for c in p) for k, p in enumerate(where)]
    lines.append('*ELEMENT, TYPE=C3D20, ELSET=SOLID')
    for k, nodes in enumerate((elements + 1).tolist()):
        words = [str(n) for n in (k + 1, *nodes)]
        lines += [', '.join(words[:11]) + ',', ', '.join(words[11:])]
    if len(held):
        lines += ['*BOUNDARY', *(f'{node + 1}, 1, 3' for node in held)]
    return '\n'.join([
        *lines, '*MATERIAL, NAME=ONE', '*ELASTIC',
        f'{1e-6 * material.young_modulus:.9e}, {material.poisson_ratio}', '*DENSITY',
        f'{1e-12 * material.density:.9e}', '*SOLID SECTION, ELSET=SOLID, MATERIAL=ONE', '*STEP',
        '*FREQUENCY', str(modes), '*NODE FILE', 'U', '*END STEP', ''])


def solved(folder: Path, text: str) -> Path:
    """Return the .frd file that CalculiX writes for a deck."""
    ccx = shutil.which('ccx')
    if ccx is None:
        pytest.skip('CalculiX is not installed (Debian, Ubuntu: apt install calculix-ccx)')
    (folder / 'solid.inp').write_text(text)
    run = subprocess.run([ccx, '-i', 'solid'], cwd=folder, capture_output=True, text=True,
                         env={'OMP_NUM_THREADS': '1', 'PATH': '/usr/bin:/bin'})
    assert (folder / 'solid.frd').exists(), run.stdout[-500:]
    return folder / 'solid.frd'

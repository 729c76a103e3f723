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

"""Finite element models, solved once a test run: its processes share the eigensolutions."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import fcntl
from pathlib import Path
import pickle
from typing import Any

import pytest
from squeal_core.modes.fe import axisymmetric, mode_cache, solid


@contextmanager
def locked(folder: Path, key: str) -> Iterator[None]:
    """Let one process at a time solve what a key stands for."""
    folder.mkdir(exist_ok=True)
    with (folder / f'{key[:32]}.lock').open('w') as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def share(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """
    Keep in `folder` what the eigensolvers give.

    Keys are the product's own: mesh, element, material, clamp and count, every bit of them.
    """
    def remembered(cache: Any, key: str, shape: tuple[int, int],
                   compute: Callable[[], mode_cache.Solution]) -> mode_cache.Solution:
        if cache is not None:
            return mode_cache.remembered(cache, key, shape, compute)
        with locked(folder, key):
            return mode_cache.remembered(folder, key, shape, compute)

    plain = axisymmetric._lowest

    def lowest(basis: Any, material: Any, clamped: Any, count: int) -> Any:
        key = mode_cache.content_key(
            places=basis.mesh.p, cells=basis.mesh.t, clamped=clamped, count=count,
            element=f'{type(basis.elem.elem).__name__} {basis.N} {basis.dx.shape}',
            material=[material.young_modulus, material.density, material.poisson_ratio])
        path = folder / f'harmonics-{key[:32]}.pickle'
        with locked(folder, key):
            if not path.exists():
                path.write_bytes(pickle.dumps(plain(basis, material, clamped, count)))
            return pickle.loads(path.read_bytes())

    monkeypatch.setattr(solid, 'remembered', remembered)
    monkeypatch.setattr(axisymmetric, '_lowest', lowest)

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

"""Broken, foreign and misleading files: one line of what, which value, where, and remedy."""

from pathlib import Path
import re
import sys

import pytest
from squeal_core.common.errors import LocatedError, SquealError
from squeal_core.modes.readers import FORMATS, read_modes, ReaderError
from squeal_core.modes.readers import raw as limits
from support.reader_samples import FRD, options, PAD, refusal, SAMPLES, write_sample


def test_the_error_is_one_of_a_place() -> None:
    assert issubclass(ReaderError, LocatedError)
    assert issubclass(ReaderError, SquealError)


def test_files_that_are_not_there(tmp_path: Path) -> None:
    for suffix in ('.unv', '.uff', '.frd', '.h5', '.op2', '.csv', '.txt', '.rpt', '.lis', '.vtu'):
        assert re.match(r'(cannot be read|does not exist)', refusal(tmp_path / f'none{suffix}'))
    assert "has the suffix '.odb'; give format: one of unv, frd" in refusal(tmp_path / 'pad.odb')
    assert "has the suffix ''" in refusal(tmp_path / 'pad')


@pytest.mark.parametrize('form', FORMATS)
@pytest.mark.parametrize('content', [
    b'', b'\n\n', b'\0' * 4000, b'\x89PNG\r\n\x1a\n' * 100, b'<html><body>404</body></html>',
    b'1,2,3\n4,5,6\n', b'{"frequency_hz": [1.0]}', bytes(range(256)) * 8,
    'm\u00e4use\n'.encode('latin-1') * 40, b'-1' * 5000, b'    -1\n' * 500, b' -1\n' * 500])
def test_files_of_something_else(form: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / 'other.dat'
    path.write_bytes(content)
    refusal(path, format=form, modal_mass=1.0)


@pytest.mark.parametrize('name', SAMPLES)
def test_one_format_given_for_another(name: str, tmp_path: Path) -> None:
    path = write_sample(name, tmp_path)
    own = {'unv_2414': 'unv', 'pyuff': 'unv', 'op2': 'nastran_op2', 'ansys': 'listing',
           'abaqus': 'listing'}.get(name, name)
    for form in set(FORMATS) - {own, 'table' if own == 'listing' else own}:
        refusal(path, **{**options(name), 'format': form})
    read_modes(path, **options(name), format=own)


def test_folders(tmp_path: Path) -> None:
    for form in FORMATS:
        refusal(tmp_path, format=form)


def test_sizes_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in SAMPLES:
        if name == 'op2':
            continue
        path = write_sample(name, tmp_path)
        for limit, what in (('MAX_MODES', 'modes'), ('MAX_NODES', 'nodes'),
                            ('MAX_VALUES', 'values')):
            with monkeypatch.context() as patch:
                patch.setattr(limits, limit, 8)
                assert 'more than the 8 that are read; export fewer' in refusal(
                    path, **options(name)), what
    monkeypatch.setattr(limits, 'MAX_BYTES', 1000)
    assert 'has 53357 bytes, more than the 1000 that are read' in refusal(FRD, **PAD)


@pytest.mark.parametrize(('package', 'name', 'form', 'extra'), [
    ('h5py', 'nastran_h5', 'nastran_h5', 'readers'),
    ('pyNastran', 'frd', 'nastran_op2', 'nastran')])
def test_packages_that_are_not_there(package: str, name: str, form: str, extra: str,
                                     tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_sample(name, tmp_path)
    monkeypatch.setitem(sys.modules, package, None)
    for known in [k for k in sys.modules if k.startswith(f'{package}.')]:
        monkeypatch.delitem(sys.modules, known)
    text = refusal(path, format=form)
    assert f'cannot be read without {package}' in text
    assert text.endswith(f"; pip install -e '.[{extra}]' in the checkout")

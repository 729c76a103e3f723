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

"""The examples in the docstrings of what `squeal_core` exports run, and print what they say."""

import doctest
import inspect
from pathlib import Path

import pytest
import squeal_core

NAMES = ('BrakeModel', 'build_model', 'complex_modes', 'critical_value', 'load_settings',
         'OperatingPoint', 'read_brake', 'read_modes', 'sweep', 'VehicleMonitor')


def test_all_ten_are_exported() -> None:
    assert {*NAMES, 'SquealError', 'stability', '__version__'} == set(squeal_core.__all__)


@pytest.mark.parametrize('name', NAMES)
def test_examples(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if name == 'build_model':
        pytest.importorskip('skfem', reason='needs scikit-fem')
    monkeypatch.chdir(Path(__file__).parent / 'data' / 'readers')
    thing = getattr(squeal_core, name)
    examples = doctest.DocTestParser().get_doctest(
        inspect.getdoc(thing) or '', {}, name, inspect.getsourcefile(thing), 0)
    assert examples.examples
    found = doctest.DocTestRunner().run(examples)
    assert found.failed == 0

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

"""Fixtures that tests share: the shipped model, its brake, and the modes the model is made of."""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Iterator  # noqa: I100
import os
import signal
from typing import Any

from hypothesis import HealthCheck, settings
import pytest

from squeal_core import BrakeModel
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.brake.dimensions import Brake
from squeal_core.common.resources import config_folder

# a background job of a shell ignores Ctrl-C, and so would the processes that tests end by it
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# a busy machine is no fault of an example; CI is to find today what it found yesterday
settings.register_profile('squeal', deadline=None, derandomize=bool(os.environ.get('CI')),
                          suppress_health_check=[HealthCheck.too_slow])
settings.load_profile('squeal')


# whoever tries to skip for want of these in CI fails: there they are to be
_IN_CI = ('CalculiX', 'rclpy', 'rosbags', 'matplotlib', 'visualization_msgs', 'threadpoolctl',
          'meshio', '/proc', 'squeal_msgs', 'scikit-learn', 'plotly', 'Chromium', 'playwright',
          'dask')


def _is_missed(report: Any) -> bool:
    return bool(report.skipped and os.environ.get('CI') and not hasattr(report, 'wasxfail')
                and any(name in str(report.longrepr) for name in _IN_CI))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport() -> Iterator[None]:
    """Let a test fail that would skip for want of what CI has."""
    report = (yield).get_result()  # type: ignore[func-returns-value, attr-defined]
    if _is_missed(report):
        report.outcome, report.longrepr = 'failed', f'in CI: {report.longrepr}'


@pytest.hookimpl(hookwrapper=True)
def pytest_make_collect_report() -> Iterator[None]:
    """Likewise for a whole file."""
    report = (yield).get_result()  # type: ignore[func-returns-value, attr-defined]
    if _is_missed(report):
        report.outcome, report.longrepr = 'failed', f'in CI: {report.longrepr}'


@pytest.fixture(scope='session', autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """
    Keep tables and modes of the user's cache out of the tests, and the shipped tables.

    A monitor then solves in full unless a test gives it a table. Emulators of growth stay.
    """
    folder = tmp_path_factory.getbasetemp()
    shipped = tmp_path_factory.mktemp('tables')
    for path in (config_folder() / 'tables').glob('*.growth.npz'):
        (shipped / path.name).symlink_to(path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('XDG_CACHE_HOME', str(
            (folder.parent if 'PYTEST_XDIST_WORKER' in os.environ else folder) / 'cache'))
        patch.setenv('SQUEAL_TABLES', str(shipped))
        yield


@pytest.fixture(scope='module')
def own_domain() -> Iterator[None]:
    """Run the processes of a module in a ROS domain of their own."""
    from support.domains import own_environment

    with own_environment():
        yield


@pytest.fixture(scope='session')
def kang() -> BrakeModel:
    """Return the shipped model, N = 92."""
    return BrakeModel.load('kang2009')


@pytest.fixture(scope='session')
def brake() -> Brake:
    """Return the description that the shipped model was built from."""
    return read_brake(config_folder() / 'brakes' / 'kang2009.yaml')


@pytest.fixture(scope='session')
def solved_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Solve each finite element model once in this run, whichever process asks for it."""
    from support.solved_modes import share

    folder = tmp_path_factory.getbasetemp()
    if 'PYTEST_XDIST_WORKER' in os.environ:
        folder = folder.parent  # that of all workers
    with pytest.MonkeyPatch.context() as patch:
        share(folder / 'solved_modes', patch)
        yield


@pytest.fixture(scope='session')
def disc(brake: Brake, solved_once: None):  # type: ignore[no-untyped-def]
    """Modes of the disc, with the settings of the shipped model; takes seconds."""
    from squeal_core.modes.fe.axisymmetric import disc_modes
    return disc_modes(brake.disc, brake.disc_modes)


@pytest.fixture(scope='session')
def pad(brake: Brake, solved_once: None):  # type: ignore[no-untyped-def]
    """Modes of a pad, with the settings of the shipped model; takes seconds."""
    from squeal_core.modes.fe.solid import pad_modes
    return pad_modes(brake.pad, brake.contact, brake.pad_modes)

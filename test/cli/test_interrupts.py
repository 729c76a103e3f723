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

"""Interrupts within a process: the first one counts, later ones and dropped ones."""

import signal
import subprocess
import sys
from typing import Any

import pytest
from squeal_ros.interrupts import InterruptOnce


def strike() -> None:
    signal.raise_signal(signal.SIGINT)


def test_the_first_interrupts_and_the_cleaning_up_is_left_alone() -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM), sys.unraisablehook
    cleaned = []

    def work() -> None:
        try:
            strike()
        finally:
            strike()
            signal.raise_signal(signal.SIGTERM)
            cleaned.append(True)

    with pytest.raises(KeyboardInterrupt), InterruptOnce():
        work()
    assert cleaned
    assert before == (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM),
                      sys.unraisablehook)


def test_an_interrupt_that_python_drops_comes_again() -> None:
    class Dropping:

        def __del__(self) -> None:
            strike()

    def work() -> None:
        dropping: Any = Dropping()
        del dropping  # raises where nothing can be raised
        signal.pause()  # until it comes again

    with pytest.raises(KeyboardInterrupt), InterruptOnce():
        work()


def test_a_background_job_of_a_shell_stays_deaf() -> None:
    signal_before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with InterruptOnce():
            strike()
    finally:
        signal.signal(signal.SIGINT, signal_before)


@pytest.mark.parametrize(('code', 'words'), [(0, ''), (130, 'squeal: interrupted')])
def test_a_process_that_starts_ends_at_once(code: int, words: str) -> None:
    done = subprocess.run([sys.executable, '-c', (
        'import signal; from squeal_ros.interrupts import EndAtOnce;'
        f'EndAtOnce({code}, {words!r}); signal.raise_signal(signal.SIGINT); print("on")')],
        capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.strip()) == (code, '', words)

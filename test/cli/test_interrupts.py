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

"""Interrupts: the first, later ones and dropped ones; what is kept of a sweep cut short."""

import json
import os
from pathlib import Path
import pty
import re
import signal
import subprocess
import sys
from threading import Thread
import time
from typing import Any

import numpy as np
import pytest
from squeal_core.studies.sweep_file import load_sweep
from squeal_ros.cli.console import ProgressBar
from squeal_ros.cli.main import main
from squeal_ros.interrupts import InterruptOnce
from support.processes import process


def strike() -> None:
    signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize('first', [signal.SIGINT, signal.SIGTERM])
def test_the_first_interrupts_and_the_cleaning_up_is_left_alone(first: signal.Signals) -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM), sys.unraisablehook
    cleaned = []

    def work() -> None:
        try:
            signal.raise_signal(first)
        finally:
            strike()
            signal.raise_signal(signal.SIGTERM)
            cleaned.append(True)

    with pytest.raises(KeyboardInterrupt), InterruptOnce():
        work()
    assert cleaned
    assert before == (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM),
                      sys.unraisablehook)


@pytest.mark.parametrize('another', [False, True])
def test_an_interrupt_that_python_drops_comes_again(another: bool,
                                                    monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where another one comes while it is dropped."""
    if another:
        start = Thread.start
        monkeypatch.setattr(Thread, 'start', lambda thread: (strike(), start(thread)))

    class Dropping:

        def __del__(self) -> None:
            strike()

    def work() -> None:
        dropping: Any = Dropping()
        del dropping  # raises where nothing can be raised
        for _ in range(6000):  # until it comes again; `pause` would miss one just before
            time.sleep(0.01)

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


def test_an_interrupt_ends_both_sweeps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                       capsys: pytest.CaptureFixture[str]) -> None:
    """The one without rotation is not begun when the first was cut short."""
    calls: list[tuple[int, int]] = []

    def stop(self: ProgressBar, done: int, total: int) -> None:
        calls.append((done, total))
        if done == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(ProgressBar, '__call__', stop)
    path = tmp_path / 'a.npz'
    assert main(['locus', 'kang2009', '--over', 'friction=0:0.5:6', '--modes', '13', '--workers',
                 '1', '--without-rotation', '-o', str(path)]) == 1
    assert calls == [(1, 6), (2, 6)]
    assert load_sweep(path).done.tolist() == [True] * 2 + [False] * 4
    assert [p.name for p in tmp_path.iterdir()] == ['a.npz']


def test_ctrl_c_at_a_terminal_keeps_what_is_done(tmp_path: Path) -> None:
    """Sent once the bar shows a few points; the file is whole and holds them."""
    ours, theirs = pty.openpty()
    path = tmp_path / 'a.npz'  # of so many points faster than a text
    with process(['-m', 'squeal_ros.cli', 'map', 'kang2009', '--over', 'friction=0:0.8:5000',
                  '-o', path, '--json'], stdout=subprocess.PIPE, stderr=theirs, text=True,
                 start_new_session=True) as started:
        os.close(theirs)
        shown = b''
        while not re.search(rb'\] [5-9]\d* of 5000 points', shown):
            shown += os.read(ours, 4096)
        os.killpg(started.pid, signal.SIGINT)
        output, _ = started.communicate()
    os.close(ours)
    summary, record = json.loads(output), load_sweep(path)
    assert started.returncode == 1
    assert shown.startswith(b'\r[---')
    assert (summary['complete'], record.complete) == (False, False)
    assert 5 <= summary['done'] == record.done.sum() < 5000
    assert np.isfinite(record.eigenvalues[record.done]).all()

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

"""Works in steps: who makes these, what ticks are kept by, and what workers give way to."""

from collections.abc import Callable
from functools import partial
import threading
import time
from typing import Any

import pytest
from squeal_core.surrogate import workers
from squeal_core.surrogate.steps import completed, in_a_step, Steps
from squeal_core.surrogate.workers import Allowance, pause, Work, Worker

SOON = 600.0  # s, for what comes at once; a machine that others use may take its time


def adding(count: int, call: Callable[[int], int] = lambda i: i) -> 'Steps[int]':
    """Add up what so many steps return."""
    total = 0
    for i in range(count):
        total += yield partial(call, i)
    return total


def failing(error: Exception) -> 'Steps[None]':
    yield partial(int, 'no number') if isinstance(error, ValueError) else lambda: None
    raise error


def allowed(steps: int) -> Allowance:
    found = Allowance()
    found.renew(steps)
    return found


def done(worker: Worker, work: Work[Any]) -> Any:
    assert worker.granted(work, Allowance())
    return work.result()


@pytest.fixture(params=['at once', 'beside', 'never gets to run'])
def worker(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Any:
    found = Worker('test')
    if request.param == 'at once':
        monkeypatch.setattr(found, 'begin', partial(found.begin, beside=False))
    elif request.param != 'beside':
        monkeypatch.setattr(found, '_do', lambda work: None)
    yield found
    found.close()


def test_steps_are_made_whoever_makes_them(worker: Worker) -> None:
    assert completed(adding(5)) == 10
    assert done(worker, worker.begin(adding(5))) == 10
    assert done(worker, worker.begin(adding(0))) == 0
    assert done(worker, worker.begin(in_a_step(max)(3, 7))) == 7


@pytest.mark.parametrize('error', [ZeroDivisionError(), ValueError()])
def test_what_a_step_raises_is_the_works_result(worker: Worker, error: Exception) -> None:
    """Of a call, which the generator may catch, or of the generator."""
    with pytest.raises(type(error)):
        done(worker, worker.begin(failing(error)))
    with pytest.raises(type(error)):
        completed(failing(error))


def test_a_generator_may_catch_what_a_call_raises(worker: Worker) -> None:
    def careful() -> 'Steps[str]':
        try:
            yield lambda: 1 / 0
        except ZeroDivisionError as error:
            return str(error)
        return 'nothing raised'
    assert done(worker, worker.begin(careful())) == completed(careful()) == 'division by zero'


@pytest.mark.parametrize(('a_tick', 'ticks'), [(1, 6), (2, 3), (4, 2), (6, 1), (9, 1)])
def test_a_work_is_over_when_all_its_steps_are_granted(worker: Worker, a_tick: int,
                                                       ticks: int) -> None:
    """However much of it is done: six steps."""
    work = worker.begin(adding(6))
    over = [worker.granted(work, allowed(a_tick)) for _ in range(ticks)]
    assert over == [False] * (ticks - 1) + [True]
    assert work.result() == 15


def test_works_are_granted_in_their_order(worker: Worker) -> None:
    """The first gets what is granted to the second, until it is over."""
    first, second = worker.begin(adding(3)), worker.begin(adding(2))
    assert not worker.granted(second, allowed(4))
    assert worker.granted(first, allowed(0))
    assert worker.granted(second, allowed(1))
    assert (first.result(), second.result()) == (3, 1)


def test_nothing_waits_for_a_step_that_takes_long() -> None:
    """It is made a second time, and only its first result counts."""
    begun, end, calls = threading.Event(), threading.Event(), []

    def slow(i: int) -> int:
        calls.append(i)
        if threading.current_thread() is not threading.main_thread():
            begun.set()
            assert end.wait(SOON)
            return 100
        return 1

    beside = Worker('test')
    work = beside.begin(adding(3, slow))
    assert begun.wait(SOON)
    start = time.monotonic()
    assert beside.granted(work, allowed(3))
    assert time.monotonic() - start < SOON
    end.set()
    beside.close()
    assert work.result() == 3
    assert calls == [0, 0, 1, 2]


def test_a_worker_that_is_quick_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sooner than its steps are made twice, but once in a tick."""
    monkeypatch.setattr(workers, '_PATIENCE', SOON)
    beside, threads = Worker('test'), set()

    def noted(i: int) -> int:
        threads.add(threading.current_thread())
        time.sleep(0.01)
        return i

    work = beside.begin(adding(5, noted))
    assert beside.granted(work, allowed(5))
    assert threading.main_thread() not in threads
    beside.close()


def test_a_closed_worker_leaves_works_as_they_are() -> None:
    """It ends after the step it is at; what is begun afterwards is done."""
    begun, end, calls = threading.Event(), threading.Event(), []

    def slow(i: int) -> int:
        calls.append(i)
        begun.set()
        assert end.wait(SOON)
        return i

    beside = Worker('test')
    first, second = beside.begin(adding(3, slow)), beside.begin(adding(3, slow))
    assert begun.wait(SOON)
    closing = threading.Thread(target=beside.close)
    closing.start()
    while beside._line or not beside._ending.is_set():
        time.sleep(1e-3)
    end.set()
    closing.join(SOON)
    assert calls == [0]
    assert not first.finished
    assert not second.finished
    assert beside.granted(second, allowed(0))  # there is nothing to wait for
    assert done(beside, beside.begin(adding(4))) == 6
    beside.close()


def test_others_pause_while_urgent_work_is_under_way() -> None:
    urgent, patient = Worker('urgent', urgent=True), Worker('patient')
    begun, end, paused = threading.Event(), threading.Event(), threading.Event()

    def work() -> None:
        pause()  # not for itself
        begun.set()
        assert end.wait(SOON)

    def wait() -> None:
        paused.set()
        pause()

    first = urgent.begin(in_a_step(work)())
    assert begun.wait(SOON)
    second = patient.begin(in_a_step(wait)())
    assert not paused.wait(0.05)  # nor does it begin
    pause()  # not who does not give way: this thread
    assert not second.finished
    end.set()
    assert paused.wait(SOON)
    for worker, one in ((urgent, first), (patient, second)):
        done(worker, one)
        worker.close()
    broken = Worker('urgent', urgent=True)
    with pytest.raises(ZeroDivisionError):
        done(broken, broken.begin(failing(ZeroDivisionError())))
    broken.close()
    third = patient.begin(in_a_step(wait)())  # urgency ends with a work, however that ends
    done(patient, third)
    patient.close()

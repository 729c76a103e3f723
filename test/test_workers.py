"""Threads beside the work: what they give way to."""

from concurrent.futures import Future
import threading

import pytest

from squeal_core.workers import gives_way, pause, Worker

SOON = 10.0  # s, for what comes at once


def test_a_task_at_once_and_one_beside() -> None:
    worker = Worker('test')
    assert not worker.submit(False, gives_way).result()
    assert worker.submit(True, gives_way).result()
    worker.close()


def test_what_a_task_raises_is_in_its_future() -> None:
    worker = Worker('test', urgent=True)
    for beside in (False, True):
        with pytest.raises(ZeroDivisionError):
            worker.submit(beside, lambda: 1 / 0).result()
    worker.close()
    pause()  # urgency ends with a task, however that ends


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

    first: Future[None] = urgent.submit(True, work)
    assert begun.wait(SOON)
    second: Future[None] = patient.submit(True, wait)
    assert paused.wait(SOON)
    pause()  # not who does not give way: this thread
    assert not second.done()
    end.set()
    assert first.result(SOON) is None
    assert second.result(SOON) is None
    for worker in (urgent, patient):
        worker.close()

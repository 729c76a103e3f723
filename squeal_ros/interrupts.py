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
Handling of SIGINT and SIGTERM. Imports next to nothing: it is there before the rest.

While a process starts they end it at once. Then the node only notes them, and ends in good order;
while a command works the first one raises KeyboardInterrupt, and what that ends is not
interrupted again. At last they are ignored.
"""

from collections.abc import Callable
import os
import signal
import sys
import time
from types import CodeType, FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_AGAIN = 0.01  # s


class EndAtOnce:
    """
    End the process as soon as a signal comes, while it starts. Later only record it.

    Parameters
    ----------
    code : int
        Exit code.
    words : str
        Written to stderr.
    always : bool
        Also where a signal is ignored, as SIGINT by the background jobs of a shell.

    Attributes
    ----------
    came : bool
        Whether a signal came that was only noted.

    """

    def __init__(self, code: int, words: str = '', *, always: bool = False) -> None:
        self._code, self._words = code, words
        self._noting = self.came = False
        for number in _SIGNALS:
            if always or signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._end)

    def only_note(self) -> None:
        """Only set `came` at a signal from now on, and end nothing."""
        self._noting = True

    def _end(self, *_: object) -> None:
        if self._noting:
            self.came = True
            return
        if self._words:
            os.write(2, f'{self._words}\n'.encode())
        os._exit(self._code)


class InterruptOnce:
    """
    Raise KeyboardInterrupt at the first signal; later ones must not disturb the cleaning up.

    A context manager.
    """

    def __enter__(self) -> None:
        self._came = False
        self._waits: list[Callable[[], None]] = []  # for threads that send
        self._hook, sys.unraisablehook = sys.unraisablehook, self._unraisable
        # a shell starts its background jobs with SIGINT ignored, and so it stays
        self._before = {number: signal.signal(number, self._interrupt) for number in _SIGNALS
                        if signal.getsignal(number) is not signal.SIG_IGN}

    def __exit__(self, *_: object) -> None:
        self._came = True
        for wait in self._waits:
            wait()
        for number, handler in self._before.items():
            # a handler that ends a process while it starts is not for one that is done
            if not isinstance(getattr(handler, '__self__', None), EndAtOnce):
                signal.signal(number, handler)
        sys.unraisablehook = self._hook

    def _interrupt(self, _: int, frame: FrameType | None) -> None:
        if not self._came and not _within(self._unraisable.__code__, frame):
            self._came = True
            raise KeyboardInterrupt

    def _unraisable(self, what: 'sys.UnraisableHookArgs') -> None:
        """Interrupt again where Python had to drop the interrupt, as in a finaliser."""
        if what.exc_type is not KeyboardInterrupt:
            self._hook(what)
            return
        import threading
        self._came = False
        sender = threading.Thread(target=self._send, args=(threading.main_thread().ident,))
        self._waits.append(sender.join)
        sender.start()

    def _send(self, main: int) -> None:
        """Send a signal until it interrupts: while one is dropped it would be dropped, too."""
        while not self._came:
            signal.pthread_kill(main, signal.SIGTERM)
            time.sleep(_AGAIN)


def _within(code: CodeType, frame: FrameType | None) -> bool:
    """Return whether a function is among those that run: one that would drop an exception."""
    while frame is not None and frame.f_code is not code:
        frame = frame.f_back
    return frame is not None


class StopAtNext:
    """
    Stop the work in an orderly way at the first signal; the next one interrupts.

    A context manager, inside one of `InterruptOnce`.

    Parameters
    ----------
    stop : callable
        Of no arguments.

    """

    def __init__(self, stop: Callable[[], None]) -> None:
        self._stop = stop

    def __enter__(self) -> None:
        self._before = {number: signal.signal(number, self._first) for number in _SIGNALS
                        if signal.getsignal(number) is not signal.SIG_IGN}

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _first(self, *_: object) -> None:
        self.__exit__()
        self._stop()


def ignore() -> None:
    """Ignore signals from now on: all is done, and the interpreter ends."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)

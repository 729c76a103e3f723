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

"""Output of commands: progress on stderr where that is a terminal, and plain JSON."""

import sys
import time

from squeal_core.common.errors import in_one_line
from squeal_core.common.json_values import plain

_BETWEEN_LINES = 60.0  # s

__all__ = ['note', 'plain', 'ProgressBar', 'report_progress', 'time_left', 'warn']


def report_progress(text: str) -> None:
    """Print the present step, if stderr is a terminal."""
    if sys.stderr.isatty():
        print(f'{text} ...', file=sys.stderr)


def warn(text: str) -> None:
    """Print a warning on stderr; the command goes on."""
    print(f'squeal: warning: {in_one_line(text)}', file=sys.stderr)


def note(text: str) -> None:
    """Print a note on stderr."""
    print(f'squeal: {in_one_line(text)}', file=sys.stderr)


class ProgressBar:
    """
    A bar on stderr, or a line a minute where that is no terminal.

    Call it with what is done and of how many.
    """

    def __init__(self, what: str, *, width: int = 30) -> None:
        self._what, self._width = what, width
        self._shown = sys.stderr.isatty()
        self._drawn = ''
        self._begun = self._told = time.monotonic()

    def __enter__(self) -> 'ProgressBar':
        return self

    def __call__(self, done: int, total: int, rest: str = '') -> None:
        filled = self._width * done // total
        text = f'{done} of {total} {self._what}{rest:16}'
        if not self._shown:
            self._tell(text.rstrip())
        elif text != self._drawn:
            print(f'\r[{"#" * filled:-<{self._width}}] {text}', end='', file=sys.stderr,
                  flush=True)
            self._drawn = text

    def _tell(self, text: str) -> None:
        """Write a line, unless the last one is fresh: a log shows slow work from stuck, too."""
        now = time.monotonic()
        if now - self._told >= _BETWEEN_LINES:
            self._told = now
            print(text, file=sys.stderr, flush=True)

    def timed(self, done: int, total: int) -> None:
        """Show the progress, and the time left."""
        self(done, total, time_left(self._begun, done, total))

    def __exit__(self, *_: object) -> None:
        if self._drawn:
            print(file=sys.stderr)


def time_left(begun: float, done: int, total: int) -> str:
    """Return the time left in words, of work begun at a `time.monotonic`; empty before any."""
    if done <= 0:
        return ''
    left = (time.monotonic() - begun) / done * (total - done)
    return f', {left / 60.0:.0f} min left' if left >= 60.0 else f', {left:.0f} s left'

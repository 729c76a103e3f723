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

"""What commands tell of their progress where stderr is no terminal."""

import pytest
from squeal_ros.cli import console


def test_a_log_gets_a_line_now_and_then(monkeypatch: pytest.MonkeyPatch,
                                        capsys: pytest.CaptureFixture[str]) -> None:
    with console.ProgressBar('parts') as progress:
        progress(1, 3)  # sooner than a line is due
        monkeypatch.setattr(console, '_BETWEEN_LINES', 0.0)
        progress.timed(2, 3)
    text = capsys.readouterr().err
    assert text.startswith('2 of 3 parts, ')
    assert text.endswith(' left\n')
    assert '\r' not in text
    assert '1 of 3' not in text

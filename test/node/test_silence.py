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

"""Inputs that bring nothing are logged, the first time and then now and again."""

import pytest
from squeal_ros.node.silence import AGAIN, FIRST, Silence

SECOND = 1_000_000_000


def test_topics_that_never_brought_a_message() -> None:
    silence, said = Silence(), {}
    for second in range(130):  # one topic is heard all the time
        found = silence.due({'a': second, 'b': 0}, second * SECOND)
        if found:
            said[second] = found
    first, again = FIRST // SECOND, (FIRST + AGAIN) // SECOND
    assert said == {first: ('b',), again: ('b',), again + AGAIN // SECOND: ('b',)}


def test_inputs_that_all_fall_silent_and_one_that_may() -> None:
    silence = Silence()
    for second in range(20):  # friction came once: while the brake was applied
        assert silence.due({'speed': second, 'friction': 1}, second * SECOND) == ()
    said = [second for second in range(20, 40)
            if silence.due({'speed': 19, 'friction': 1}, second * SECOND)]
    assert said == [19 + FIRST // SECOND]
    silence.begin()  # active again
    assert silence.due({'speed': 19, 'friction': 1}, 40 * SECOND) == ()


def test_the_node_names_topics_of_a_similar_name(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip('rclpy', reason='needs rclpy')
    from support.node_runs import vehicle

    monkeypatch.setattr('squeal_ros.node.silence.FIRST', 0)
    with vehicle(bring_up=False, fl__pressure__topic='fl/brake_presure') as car:
        said: list[str] = []
        log = car.monitor.get_logger()
        monkeypatch.setattr(car.monitor, 'get_logger', lambda: log)
        monkeypatch.setattr(log, 'warning', lambda text, **_: said.append(text))
        car.monitor.bring_up()
        car.until(lambda: any('fl/brake_presure (nobody publishes it) (did you mean '
                              '/fl/brake_pressure?)' in text for text in said))

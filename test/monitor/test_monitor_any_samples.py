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

"""The monitor under any samples and ticks: the same again, and no number where none is due."""

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from support.brake_monitors import (
    ANY_LEAP,
    CERTAIN,
    check_unknown,
    feed,
    GOOD,
    LIMITS,
    monitor,
    NAN,
    SECOND,
    VALIDATED,
)

STEP = st.integers(1, SECOND)  # 0 would be no stamp
SAMPLE = st.sampled_from(list(GOOD)).flatmap(lambda name: st.tuples(
    st.just(name), STEP, st.floats(*LIMITS[name]) | st.floats()))
Events = list[tuple[Any, int, float]]


def play(events: Events, ticks: bool) -> list[str]:
    """Assessments at the ticks among the events, or only at the end of them."""
    watch, time, found = feed(monitor(**CERTAIN), 1, **GOOD), 1, []
    for kind, step, value in events:
        if kind == 'tick':
            time += step // 4
            found += [watch.assess(time)] if ticks else []
        else:
            feed(watch, time + step - SECOND // 2, **{kind: value})
    return [*map(repr, found), repr(last := watch.assess(time)),
            repr((last.state, last.inputs, last.friction, last.risk))]


@settings(max_examples=12, deadline=None)
@given(st.lists(SAMPLE | st.tuples(st.just('tick'), STEP, st.just(0.0)), max_size=30))
def test_same_samples_and_ticks_same_assessments(events: Events) -> None:
    """To the last bit; after other ticks the table is another, and so a number by its error."""
    assert play(events, ticks=True) == play(events, ticks=True)
    assert play(events, ticks=True)[-1] == play(events, ticks=False)[-1]


def expected_state(samples: Events, time: int) -> str:
    newest = {s[0]: s[1:] for s in sorted(samples, key=lambda s: s[1]) if s[1] <= time}
    fresh = {name: value for name, (stamp, value) in newest.items() if time - stamp <= SECOND // 2}
    if (VALIDATED['pressure'][0] <= fresh.get('pressure', NAN) < 5e4
            or abs(fresh.get('rotor_speed', NAN)) < 0.5):
        fresh['friction'] = GOOD['friction']  # whatever it is
    if any(not LIMITS[name][0] <= value <= LIMITS[name][1] for name, value in fresh.items()):
        return 'invalid'
    if len(fresh) < len(GOOD):
        return 'stale'
    if any(not VALIDATED[name][0] <= value <= VALIDATED[name][1]
           for name, value in fresh.items()):
        return 'outside validated range'
    if fresh['pressure'] < 5e4:
        return 'released'
    return 'steady' if abs(fresh['rotor_speed']) >= 0.5 else 'not sliding'


@settings(max_examples=80, deadline=None)
@given(st.lists(SAMPLE, max_size=9), STEP, st.integers(0, 3))
def test_no_number_unless_steady_or_released(samples: Events, time: int, before: int) -> None:
    samples = [*((name, 1, GOOD[name]) for name in list(GOOD)[:before]), *samples]
    watch = monitor(stamp_tolerance=1.0, **ANY_LEAP)
    for name, stamp, value in samples:
        feed(watch, stamp, **{name: value})
    found = watch.assess(time)
    assert found.state == expected_state(samples, time)
    if found.state in ('steady', 'released'):
        assert 0.0 <= found.instability_probability <= 1.0
    else:
        check_unknown(found, found.state, found.reason)

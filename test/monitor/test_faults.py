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

"""Every fault on every input, singly and in pairs: no number, the right cause, quick recovery."""

from collections.abc import Iterator
from functools import cache
import itertools
import re
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import Assessment, Sample, VehicleMonitor
from support.brake_monitors import CERTAIN, MODEL
from support.fault_times import (
    bad,
    BEGIN,
    BOTH,
    BY_TABLE,
    END,
    FAIR,
    MAX_AGE,
    MEASURED,
    START,
    STEP,
    STREAMS,
    STUCK,
)
from support.faults import braking, clock_back, Fault, FAULTS, SECOND, Stream
from support.processes import short_and_long


def car(signals: tuple[Signal, ...], **changes: Any) -> VehicleMonitor:
    topics = {f'a.{s}.topic': f'/{s}' if s in signals else '' for s in BOTH}
    stuck = {f'a.{s}.stuck_after': STUCK / SECOND for s in BOTH}
    return VehicleMonitor(read_settings({
        'brakes': ['a'], 'stuck_changes': 10, **CERTAIN, **topics, **stuck, **changes}), MODEL)


def play(stream: Stream, ticks: list[int], vehicle: VehicleMonitor) -> Iterator[Assessment]:
    """Receive what comes before each tick, or with it, and assess."""
    waiting = 0
    for tick in ticks:
        while waiting < len(stream) and stream[waiting].time <= tick:
            event = stream[waiting]
            vehicle.receive('a', event.signal, event.sample)
            waiting += 1
        yield vehicle.assess(tick)[0]


def check(found: Assessment, causes: list[tuple[Signal, Fault]]) -> None:
    """Check an assessment under faults that are past their limit: no number, and why."""
    assert not found.is_valid, found
    assert np.isnan([found.risk, found.growth_rate, found.worst_frequency_hz,
                     found.friction_margin]).all()
    assert (found.modes, found.point) == ((), None)
    for signal, fault in causes:
        said = [part for part in found.reason.split('; ') if part.startswith(f'{signal} ')]
        assert len(said) == 1, (found.reason, fault.name)
        assert re.fullmatch(rf'{signal} {fault.cause}.*', said[0]), (said, fault.name)


TICKS = list(range(BEGIN + SECOND, BEGIN + 7 * SECOND, 2 * STEP))


@cache
def without_fault(signals: tuple[Signal, ...]) -> list[Assessment]:
    return list(play(STREAMS[signals], TICKS, car(signals)))


@pytest.mark.parametrize('signals', [MEASURED, BY_TABLE], ids=['measured', 'by table'])
@pytest.mark.parametrize('name', FAULTS)
def test_one_fault(name: str, signals: tuple[Signal, ...]) -> None:
    fault, healthy, well = FAULTS[name], STREAMS[signals], without_fault(signals)
    assert {found.state for found in well} == {'steady'}
    for signal in signals:
        stream = fault.apply(healthy, signal, START, END)
        said = list(play(stream, TICKS, car(signals)))
        seen = 0
        for tick, found, sound in zip(TICKS, said, well, strict=True):
            if tick < START or tick >= END + MAX_AGE:  # recovered, with the very same numbers
                assert repr((found.growth_rate, found.inputs)) == repr(
                    (sound.growth_rate, sound.inputs))
            elif tick < END and bad(fault, signal, stream, tick):
                check(found, [(signal, fault)])
                seen += 1
        assert (seen > 3) == (fault.kind != 'harmless' and (name, signal) not in FAIR)


@pytest.mark.parametrize('signal', MEASURED)
@pytest.mark.parametrize('name', [f.name for f in FAULTS.values() if f.kind == 'harmless'])
def test_harmless(name: str, signal: Signal) -> None:
    stream = FAULTS[name].apply(STREAMS[MEASURED], signal, START, END)
    ticks = list(range(START, END, STEP))
    assert {found.state for found in play(stream, ticks, car(MEASURED))} == {'steady'}


def blind(first: tuple[Signal, Fault], second: tuple[Signal, Fault], tick: int) -> bool:
    """
    Tell whether the second fault hides the first.

    A stuck input is not told while it is not known whether the disc slides; friction is not
    needed while a pressure in bar, for the time that it takes to tell, reads as released.
    """
    signal, fault = second
    if first[0] in ('friction', 'temperature') and (signal, fault.name) == (
            'pressure', 'wrong unit') and tick < START + 3 * SECOND // 5:
        return True
    return (first[1].kind == 'stuck' and signal in ('rotor_speed', 'pressure')
            and fault.kind == 'value')


PAIRS: list[tuple[Signal, Signal]] = [
    *itertools.combinations(MEASURED, 2), ('rotor_speed', 'temperature'),
    ('pressure', 'temperature')]


@pytest.mark.parametrize('pair', PAIRS, ids=' and '.join)
@pytest.mark.parametrize('name', FAULTS)
@short_and_long('stride', 3, 1)
def test_two_faults(stride: int, name: str, pair: tuple[Signal, Signal]) -> None:
    """Any two faults together, each on any input; in the long form on any two inputs."""
    first = (list(FAULTS).index(name) + PAIRS.index(pair)) % stride
    signals = BY_TABLE if 'temperature' in pair else MEASURED
    ticks = [START - STEP, *range(START + STEP, END, 6 * STEP), END + MAX_AGE]
    for other in list(FAULTS.values())[first::stride]:
        faults = dict(zip(pair, (FAULTS[name], other), strict=True))
        stream = STREAMS[signals]
        for signal, fault in faults.items():
            stream = fault.apply(stream, signal, START, END)
        before, *during, after = play(stream, ticks, car(signals))
        assert (before.state, after.state) == ('steady', 'steady'), (faults, after)
        for tick, found in zip(ticks[1:-1], during, strict=True):
            past = [(s, f) for s, f in faults.items() if bad(f, s, stream, tick)]
            (one, two) = faults.items()
            told = [item for item, rest in ((one, two), (two, one))
                    if item in past and not blind(item, rest, tick)]
            if told:
                check(found, told)


@pytest.mark.parametrize('name', FAULTS)
def test_the_temperature_stands_in_while_friction_is_at_fault(name: str) -> None:
    fault = FAULTS[name]
    stream = fault.apply(STREAMS[BOTH], 'friction', START, END)
    ticks = list(range(START, END, 3 * STEP))
    for tick, found in zip(ticks, play(stream, ticks, car(BOTH)), strict=True):
        assert found.state == 'steady'
        if bad(fault, 'friction', stream, tick):
            assert found.friction_source == 'temperature'
            assert re.search(f'; friction by temperature, as friction {fault.cause}', found.reason)
        elif fault.kind == 'harmless':
            assert found.friction_source == 'measured'


@pytest.mark.parametrize('name', FAULTS)
def test_a_faulty_temperature_is_no_matter_while_friction_is_measured(name: str) -> None:
    stream = FAULTS[name].apply(STREAMS[BOTH], 'temperature', START, END)
    ticks = list(range(START, END, 4 * STEP))
    for found in play(stream, ticks, car(BOTH)):
        assert (found.state, found.friction_source) == ('steady', 'measured')
        assert 'temperature' not in found.reason


@pytest.mark.parametrize('by', [STEP, 3 * SECOND, 900 * SECOND])
def test_clock_back(by: int) -> None:
    """After a step of the clock nothing is known until samples of the new time come."""
    healthy = STREAMS[MEASURED]
    vehicle = car(MEASURED)
    stream = clock_back(healthy, START, by)
    change = next(i for i, e in enumerate(healthy) if e.time >= START)
    before, = play(stream[:change], [START - STEP], vehicle)
    assert before.state == 'steady'
    tick = START - STEP - by
    found, = vehicle.assess(tick)
    assert (found.state, found.is_valid, str(found.risk)) == ('stale', False, 'nan')
    assert found.reason.split('; ') == [
        f'{signal} not received since time went backwards' for signal in MEASURED]
    assert {r.status for r in found.inputs.values()} == {'time went backwards'}
    again, = play(stream[change:], [START - by], vehicle)
    assert again.state == 'steady'
    fresh, = play(stream[change:], [START - by], car(MEASURED))
    assert repr(again) == repr(fresh)


def test_a_frozen_vehicle_bus() -> None:
    """All inputs repeat for ever: nothing tells it from a bench, unless the settings say so."""
    stream = STREAMS[MEASURED]
    for signal in MEASURED:
        stream = FAULTS['stuck'].apply(stream, signal, START, END)
    ticks = [END - STEP, END + MAX_AGE]
    assert [f.state for f in play(stream, ticks, car(MEASURED))] == ['steady', 'steady']
    told, after = play(stream, ticks, car(MEASURED, stuck_changes=0))
    assert (told.state, after.state) == ('invalid', 'steady')


ANY_BITS = st.integers(0, 2**32 - 1)
STORM = 5000


def storm(seed: int) -> tuple[Any, Any, Any]:
    """Signals, stamps and values of a storm; any bits may be a value, any number a stamp."""
    random = np.random.default_rng(seed)
    near = random.normal(0.0, 1.0, STORM) * 10.0 ** random.integers(7, 12, STORM)
    stamps = BEGIN + np.cumsum(random.integers(0, SECOND // 100, STORM)) + near.astype(np.int64)
    wild = random.random(STORM) < 0.1
    stamps[wild] = random.integers(-2**63, 2**63 - 1, wild.sum())
    any_bits = random.integers(0, 2**64, STORM, dtype=np.uint64).view(np.float64)
    fair = random.choice([0.0, 0.2, 0.5, 1.0, 10.0, 60.0, 190.0, 400.0, 1e6, 4e6, 3e7], STORM)
    return (random.choice(MEASURED, STORM), stamps.tolist(),
            np.where(random.random(STORM) < 0.3, any_bits, fair).tolist())


@settings(max_examples=8, deadline=None)
@given(ANY_BITS, st.integers(1, 200))
def test_storm(seed: int, per_tick: int) -> None:
    """8 x 5,000 samples of any content: no exception, no number but from what is believable."""
    vehicle = car(MEASURED)
    brake = vehicle.brakes['a']
    time = BEGIN
    for count, (signal, stamp, value) in enumerate(zip(*storm(seed), strict=True)):
        brake.receive(signal, Sample(stamp, value))
        if count % per_tick == 0:
            time += (count * 7919 % 5 - 1) * STEP // 2  # now and then back
            check_sound(vehicle.assess(time)[0])
    assert all(len(one._samples) <= 4096 for one in brake._inputs.values())


def check_sound(found: Assessment) -> None:
    if not found.is_valid:
        assert np.isnan([found.risk, found.growth_rate]).all()
        assert found.reason
        return
    assert 0.0 <= found.instability_probability <= 1.0
    for signal, reading in found.inputs.items():
        if found.state == 'released' and signal == 'friction':
            continue  # it is not needed
        assert reading.status == 'good', (signal, reading)
        assert 0.0 <= reading.age <= 0.5
    values = {signal: reading.value for signal, reading in found.inputs.items()}
    assert abs(values['rotor_speed']) <= 200.0
    assert -1.05e5 <= values['pressure'] <= 1.6e7
    assert found.state == 'released' or 0.05 <= values['friction'] <= 0.9


def test_storms_meet_good_moments() -> None:
    """The storms above are no good if they never leave a moment in which something is known."""
    known = 0
    for seed in range(3):
        vehicle = car(MEASURED)
        for count, (signal, stamp, value) in enumerate(zip(*storm(seed), strict=True)):
            vehicle.receive('a', signal, Sample(stamp, value))
            if count % 20 == 0:
                known += vehicle.assess(BEGIN + count * SECOND // 200)[0].is_valid
    assert known > 10


@pytest.mark.parametrize('signals', [MEASURED, BY_TABLE], ids=['measured', 'by table'])
def test_a_stuck_input_is_told_by_the_defaults(signals: tuple[Signal, ...]) -> None:
    healthy = braking(20.0, rate=20.0, signals=signals)
    for signal in signals:
        topics = {f'a.{s}.topic': f'/{s}' if s in signals else '' for s in BOTH}
        vehicle = VehicleMonitor(read_settings({'brakes': ['a'], **topics}), MODEL)
        stream = FAULTS['stuck'].apply(healthy, signal, START, BEGIN + 14 * SECOND)
        limit = START + round(vehicle.settings.brakes[0].inputs[signal].stuck_after * SECOND)
        assert START < limit < BEGIN + 13 * SECOND
        before, told, after = play(
            stream, [limit - STEP, limit + 2 * STEP, BEGIN + 14 * SECOND + MAX_AGE], vehicle)
        assert (before.state, after.state) == ('steady', 'steady')
        check(told, [(signal, FAULTS['stuck'])])

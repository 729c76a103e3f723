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

"""Squeal events and the summary of a drive, from rows and assessments made by hand."""

from collections.abc import Iterator
import csv
from dataclasses import replace
import io
import math
from typing import Any

import numpy as np
import pytest
from squeal_core.monitor.assessment import Assessment, State
from squeal_core.monitor.inputs.reading import Reading, Status
from squeal_core.monitor.results.drive_applications import ApplicationDetector
from squeal_core.monitor.results.drive_summary import DriveSummary, worst_reason
from squeal_core.monitor.results.history import AssessmentRecord, CsvWriter
from squeal_core.monitor.results.squeal_events import squeal_events
from squeal_core.monitor.settings import MonitorSettings, read_settings
from squeal_core.view.drive_envelope import drive_envelope

SECOND = 1_000_000_000
NAN = math.nan


def settings(**values: Any) -> MonitorSettings:
    return read_settings({'brakes': ['fl', 'fr'], 'rate': 10.0, **values})


def row(time: float, risk: float, growth: float = 1.0, frequency: float = 2000.0,
        brake: str = 'fl') -> AssessmentRecord:
    return AssessmentRecord(time_s=time, brake=brake, state='steady', rotor_speed_rad_s=40.0,
                            pressure_pa=1e6, friction=0.4, squeal_risk=risk,
                            instability_probability=risk, build_up_nepers=NAN,
                            time_to_squeal_s=NAN, growth_rate_1_s=growth, damping_ratio=NAN,
                            worst_frequency_hz=frequency,
                            friction_margin=NAN, unstable_frequencies_hz=(),
                            unstable_growth_rates_1_s=(), reason='')


def test_an_event_has_the_figures_of_its_worst_row() -> None:
    """
    The largest risk, and the growth rate and frequency of the fastest growing mode.

    Neither is in the first or last row, and they are in different ones.
    """
    rows = [row(1.0, 0.6, 10.0, 1500.0), row(1.1, 0.9, 20.0, 1600.0), row(1.2, 0.7, 50.0, 1700.0),
            row(1.3, 0.8, -5.0, 1800.0), row(1.4, 0.55, NAN, NAN)]
    (event,) = squeal_events(rows, settings(risk_hold=0.0))
    assert (event.peak_risk, event.growth_rate_1_s, event.frequency_hz) == (0.9, 50.0, 1700.0)
    assert (event.brake, event.start_s, event.end_s) == ('fl', 1.0, 1.4)


def test_a_growth_rate_that_is_not_known_first_is_not_the_worst() -> None:
    (event,) = squeal_events([row(1.0, 0.6, NAN, NAN), row(1.1, 0.6, -3.0, 1700.0)], settings())
    assert (event.growth_rate_1_s, event.frequency_hz) == (-3.0, 1700.0)


def test_risk_warning_hysteresis_and_hold_decide() -> None:
    """As they decide the node's diagnostics: 0.3 raises nothing by default, and here it does."""
    risks = [0.1, 0.3, 0.25, 0.15, 0.05, 0.05, 0.05, 0.3, 0.0]
    rows = [row(0.1 * number, risk) for number, risk in enumerate(risks, start=1)]
    assert squeal_events(rows, settings()) == []

    def spans(**values: float) -> list[tuple[float, float]]:
        return [(round(e.start_s, 6), round(e.end_s, 6)) for e in squeal_events(
            rows, settings(risk_warning=0.3, **values))]

    assert spans(risk_hysteresis=0.0, risk_hold=0.0) == [(0.2, 0.2), (0.8, 0.8)]
    assert spans(risk_hysteresis=0.2, risk_hold=0.0) == [(0.2, 0.4), (0.8, 0.8)]
    assert spans(risk_hysteresis=0.2, risk_hold=0.2) == [(0.2, 0.5), (0.8, 0.9)]
    assert spans(risk_hysteresis=0.2, risk_hold=9.0) == [(0.2, 0.9)]


def test_events_of_brakes_and_of_a_clock_set_back_are_apart() -> None:
    rows = [row(5.0, 1.0), row(5.0, 1.0, brake='fr'), row(5.1, 0.0), row(5.1, 1.0, brake='fr'),
            row(2.0, 1.0), row(2.0, 1.0, brake='fr')]
    events = squeal_events(rows, settings(risk_hold=0.0))
    assert [(e.brake, e.start_s, e.end_s) for e in events] == [
        ('fl', 2.0, 2.0), ('fr', 2.0, 2.0), ('fl', 5.0, 5.0), ('fr', 5.0, 5.1)]


def assessment(state: State, *, pressure: float | Status = 1e6, speed: float | Status = 40.0,
               friction: float | Status = 0.4, reason: str = '') -> Assessment:
    """Return an assessment; an input is its value, or the status that it has instead."""
    readings = {name: Reading(given, 1.0, 9.0) if isinstance(given, str)
                else Reading('good', given, 0.0) for name, given in (
                    ('rotor_speed', speed), ('pressure', pressure), ('friction', friction))}
    return Assessment(brake='fl', time=0, state=state, reason=reason,
                      inputs=readings)  # type: ignore[arg-type]


def summary(*found: Assessment) -> DriveSummary:
    counted = DriveSummary(read_settings({'brakes': ['fl'], 'rate': 10.0}))
    for number, one in enumerate(found, start=10):
        counted.add([replace(one, time=number * SECOND // 10)])
    return counted


STEADY, RELEASED = assessment('steady'), assessment('released', pressure=0.0)


@pytest.mark.parametrize(('found', 'share', 'never'), [
    ([STEADY] * 3 + [RELEASED], 1.0, False),
    ([RELEASED] * 3, NAN, False),  # nothing to assess
    # known to slide under load
    ([RELEASED, assessment('stale', friction='stale')], 0.0, True),
    ([RELEASED, assessment('outside validated range', pressure='outside validated range',
                           speed=40.0)], NAN, False),  # Reading's value is 1 Pa
    # nothing known at all
    ([assessment('stale', pressure='never received', speed='never received')], 0.0, True),
    ([assessment('stale', pressure='stale')], 0.0, True),  # it turns, and that is all
    # enough is known to exclude braking
    ([assessment('stale', pressure=0.0, speed='stale')], NAN, False),
    ([assessment('invalid', pressure='invalid', speed=0.0)], NAN, False),
    # a start-up, and a lost message, of a brake that is released: too short for a brake
    ([*[assessment('stale', pressure='never received')] * 9, RELEASED], NAN, False),
    ([RELEASED, assessment('stale', pressure='stale'), RELEASED], 0.0, False),
    ([RELEASED, *[assessment('stale', pressure='stale')] * 11], 0.0, True),
    # all inputs good, and yet no number: they contradict something
    ([RELEASED, *[assessment('invalid', pressure=0.0)] * 11], 0.0, True),
    ([STEADY, *[assessment('stale', pressure='stale')] * 3], 0.25, False)])
def test_share_of_braking_that_was_assessed(found: list[Assessment], share: float,
                                            never: bool) -> None:
    counted = summary(*found)
    assert counted.share == pytest.approx(share, nan_ok=True)
    assert counted.never_assessed == (('fl',) if never else ())
    assert counted.states.total() == counted.ticks == len(found)


def test_reasons_are_told_by_their_words_and_ranked_by_braking() -> None:
    """Values and ages do not make another reason: memory is flat over a bag."""
    late = [assessment('stale', pressure=0.0, speed='stale', reason=f'rotor_speed is {n}.{n:02d} '
                       f's old: {n}e-{n} rad/s') for n in range(1, 60)]
    lost = [assessment('stale', pressure='stale', reason=f'pressure is {n} s old')
            for n in range(3)]
    counted = summary(*late, *lost)
    assert len(counted.brakes['fl'].reasons) == 2
    worst = worst_reason(counted.brakes.values())
    assert worst is not None
    assert (worst[0].text, worst[0].ticks, worst[0].braking) == ('pressure is 0 s old', 3, 3)
    assert worst[0].inputs == ('pressure',)
    many = summary(*(assessment('stale', pressure='stale', reason=chr(65 + n % 26) * (1 + n // 26))
                     for n in range(900)))
    assert len(many.brakes['fl'].reasons) <= 201


def test_silence_is_counted() -> None:
    counted = DriveSummary(settings())
    for tick in (10, 11, 42):
        counted.add([replace(STEADY, time=tick * SECOND // 10)])
    assert counted.silence == pytest.approx(3.0)


def test_ticks_of_which_nothing_is_known_count_where_the_brake_slides_on_after_them() -> None:
    detector = ApplicationDetector(settings())
    for tick in range(31):
        sliding = None if 10 <= tick < 15 else tick < 30
        detector.add(row(0.1 * tick, 0.2 if sliding else NAN), sliding, alarm=False)
    for tick in range(31, 50):  # these are of no application: it never slides again
        detector.add(row(0.1 * tick, 0.2 if tick < 40 else NAN),
                     True if tick < 40 else None, alarm=False)
    found = detector.applications
    assert [one.known_share for one in found] == [25 / 30, 1.0]
    assert [round(one.end_s, 6) for one in found] == [2.9, 3.9]


def drive(ticks: int) -> Iterator[AssessmentRecord]:
    """Return a brake whose risk is known at every other tick, with one mode at one tick."""
    for tick in range(ticks):
        one = row(0.5 * tick, float(tick % 7 == 3) if tick % 2 else NAN)
        mode = ((2503.0,), (7.0,)) if tick == 5 else ((), ())
        yield one._replace(pressure_pa=1e5 * tick, unstable_frequencies_hz=mode[0],
                           unstable_growth_rates_1_s=mode[1])


def test_a_short_drive_is_its_own_envelope() -> None:
    envelope = drive_envelope(lambda: drive(12))
    np.testing.assert_allclose(envelope.times, 0.5 * np.arange(12))
    own = envelope.brakes['fl']
    np.testing.assert_array_equal(own.pressure, np.repeat(1e5 * np.arange(12.0)[:, None], 2, 1))
    assert [math.isnan(risk) for risk in own.risk] == [True, False] * 6
    np.testing.assert_allclose(envelope.marks, [[2.5, 2500.0, 7.0]])


def test_a_long_drive_keeps_extremes_in_a_fixed_size() -> None:
    envelope = drive_envelope(lambda: drive(5000), most=50)
    own = envelope.brakes['fl']
    assert own.pressure.shape == (50, 2)
    assert (own.pressure.min(), own.pressure.max()) == (0.0, 1e5 * 4999)
    assert set(own.risk) == {1.0}
    np.testing.assert_allclose(envelope.marks[:, 1:], [[2500.0, 7.0]])
    assert drive_envelope(lambda: iter(())).brakes == {}


@pytest.mark.parametrize('reason', ['plain', 'a, b', 'say "a"', 'a\nb', 'a\rb', '', ' a', "it's"])
def test_rows_are_written_as_csv_writes_them(reason: str) -> None:
    """Quoted where csv quotes them."""
    record = row(1.5, 1.0 / 3.0, 1e-300, NAN)._replace(
        reason=reason, unstable_frequencies_hz=(1.0, 2.5), incomplete=True, mode_numbers=(25, 7))
    written, expected = io.StringIO(newline=''), io.StringIO(newline='')
    CsvWriter(written).write(record)
    texts = csv.writer(expected, lineterminator='\n')
    texts.writerow(record._fields)
    texts.writerow([' '.join(map(repr, value)) if isinstance(value, tuple) else int(value)
                    if isinstance(value, bool) else value for value in record])
    assert written.getvalue() == expected.getvalue()

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


"""The picture of a drive: its frequency axis fits the data, and alarms are marked."""

import math
from typing import Any

import pytest
from squeal_core.monitor.results.history import AssessmentRecord
from squeal_core.monitor.results.squeal_events import SquealEvent

pytest.importorskip('matplotlib', reason='needs matplotlib')

from squeal_core.view import drive_plot  # noqa: E402, I100

BAND = 1250.0, 16_000.0  # Hz


def row(time: float, brake: str, *hertz: float) -> AssessmentRecord:
    return AssessmentRecord(time, brake, 'steady', 10.0, 1e6, 0.4, 0.3, *[math.nan] * 7, hertz,
                            tuple(5.0 for _ in hertz), '')


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return what draws a drive and gives the panels of risk and frequencies."""
    figures: list[Any] = []
    monkeypatch.setattr(drive_plot, 'save_figure', lambda figure, *_, **__: figures.append(figure))

    def draw(rows: list[AssessmentRecord], events: list[SquealEvent]) -> tuple[Any, Any]:
        drive_plot.plot_drive(lambda: rows, events, 'a.png', title='', wheel_radius=0.3,
                              squeal_band_hz=BAND, risk_warning=0.6)
        return figures[-1].axes[2], figures[-1].axes[3]

    return draw


def test_the_frequency_axis_begins_below_the_lowest_mode(drawn: Any) -> None:
    """Beside the lowest and the highest are at most 10 % of what is between; none is magnified."""
    _, frequencies = drawn([row(0.0, 'fl', 1400.0, 3400.0), row(1.0, 'fl', 2400.0)], [])
    assert frequencies.get_ylim() == pytest.approx((1.2, 3.6))
    _, frequencies = drawn([row(0.0, 'fl', 2000.0), row(1.0, 'fl')], [])
    assert frequencies.get_ylim() == pytest.approx((1.9, 2.1))
    _, frequencies = drawn([row(0.0, 'fl'), row(1.0, 'fl')], [])
    assert frequencies.get_ylim() == pytest.approx((1.25, 16.0))


def test_alarms_are_marked_in_the_strip_of_their_brake(drawn: Any) -> None:
    rows = [row(time, brake) for time in (0.0, 1.0, 2.0, 3.0) for brake in ('fl', 'fr')]
    risk, _ = drawn(rows, [SquealEvent('fr', 1.0, 3.0), SquealEvent('fl', 2.0, 2.0)])
    (marks,) = [line for line in risk.lines if line.get_marker() == 'v']
    assert marks.get_xydata().tolist() == [[2.0, 1.0], [2.0, 0.0]]
    stretches = [path.vertices.tolist() for lines in risk.collections[2:]
                 for path in lines.get_paths()]
    assert stretches == [[[1.0, 1.4], [3.0, 1.4]], [[2.0, 0.4], [2.0, 0.4]]]
    assert risk.get_legend().get_texts()[0].get_text() == 'alarm, from risk 0.6: 2 times'
    risk, _ = drawn(rows, [])
    assert risk.get_legend().get_texts()[0].get_text() == 'no alarm (from risk 0.6)'

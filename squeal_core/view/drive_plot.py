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

"""Plot of a drive: speed, pressure, risk and unstable frequencies over time."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

try:
    import matplotlib
    from matplotlib.figure import Figure
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
import numpy as np
from squeal_core.common.wording import counted
from squeal_core.monitor.results.history import AssessmentRecord
from squeal_core.monitor.results.squeal_events import SquealEvent
from squeal_core.view.drive_envelope import drive_envelope, DriveEnvelope, outline
from squeal_core.view.saving import FigureTarget, save_figure

_HEADROOM = 0.1  # of the frequencies shown, above and below
_LEAST_HEADROOM = 0.05  # of the highest one: a single mode is not magnified beyond any error


def plot_drive(rows: Callable[[], Iterable[AssessmentRecord]], events: Sequence[SquealEvent],
               path: FigureTarget, *, title: str, wheel_radius: float,
               squeal_band_hz: tuple[float, float], risk_warning: float) -> None:
    """
    Draw a drive to a PNG file; of a long one the extremes in each pixel or so.

    Parameters
    ----------
    rows : callable
        Gives the rows anew at each call, in order of time.
    events : sequence of SquealEvent
        Alarms, on the time of the rows.
    path : path
        Where the file is.
    title : str
        Above the figure.
    wheel_radius : float
        To show rotor speed as vehicle speed [m].
    squeal_band_hz : (2,) floats
        Shaded in the frequency panel.
    risk_warning : float
        Risk from which the alarm is up.

    """
    envelope = drive_envelope(rows)
    matplotlib.rcParams['font.size'] = 11
    figure = Figure(figsize=(11.0, 8.5), layout='constrained')
    speed, pressure, risk, frequency = figure.subplots(
        4, 1, sharex=True, height_ratios=(1, 1, 1, 2.2))
    for number, (brake, own) in enumerate(envelope.brakes.items()):
        if number == 0:
            time, rotor = outline(envelope, own.rotor_speed)
            speed.plot(time, rotor * wheel_radius * 3.6, color='0.3', linewidth=1.2)
        time, pascal = outline(envelope, own.pressure)
        right = number % 2 == 1  # mostly the same as the left one: a thin line over a wide one
        pressure.plot(time, pascal / 1e5, color=f'C{number}', linewidth=1.0 if right else 3.0,
                      alpha=1.0 if right else 0.5, linestyle='--' if right else '-', label=brake)
    _risk_strips(figure, risk, envelope, risk_warning)
    _alarms(risk, list(envelope.brakes), events, risk_warning)
    _frequencies(figure, frequency, envelope, squeal_band_hz)
    frequency.axhspan(*(f / 1e3 for f in squeal_band_hz), color='0.95', zorder=0)
    speed.set(ylabel='vehicle speed\nkm/h', title=title)
    pressure.set(ylabel='brake pressure\nbar')
    pressure.legend(loc='lower right', bbox_to_anchor=(1.0, 0.97), ncols=len(envelope.brakes),
                    frameon=False)
    frequency.set(xlabel='time  s', ylabel='unstable modes  kHz\n(shaded: squeal band)')
    for panel in (speed, pressure, frequency):
        panel.grid(color='0.9')
        panel.margins(x=0.0)
    save_figure(figure, path, dpi=110)


def _risk_strips(figure: Any, axes: Any, envelope: DriveEnvelope, warning: float) -> None:
    """Draw one strip a brake, coloured by its largest risk, grey where none is known."""
    brakes = list(envelope.brakes)
    risk = np.array([own.risk for own in envelope.brakes.values()])
    axes.set_facecolor('0.8')
    strips = axes.pcolormesh(envelope.edges, np.arange(len(brakes) + 1) - 0.5, risk,
                             cmap='Reds', vmin=0.0, vmax=1.0)
    axes.set_yticks(range(len(brakes)), brakes)
    axes.set_ylabel('squeal risk\n(grey: not known)')
    axes.hlines(np.arange(1, len(brakes)) - 0.5, envelope.edges[0], envelope.edges[-1],
                color='1.0')
    axes.invert_yaxis()
    bar = figure.colorbar(strips, ax=axes, pad=0.01, aspect=8, ticks=(0.0, 0.5, 1.0))
    bar.ax.axhline(warning, color='black', linewidth=2.0)


def _alarms(axes: Any, brakes: Sequence[str], events: Sequence[SquealEvent],
            warning: float) -> None:
    """Underline alarms in the strips of their brakes; a mark shows short ones, too."""
    label = (f'alarm, from risk {warning:g}: {counted(len(events), "time")}' if events else
             f'no alarm (from risk {warning:g})')
    strips = [brakes.index(one.brake) for one in events]
    axes.plot([(one.start_s + one.end_s) / 2.0 for one in events], strips, 'v', color='black',
              markeredgecolor='white', markersize=9, clip_on=False, label=label)
    for one, strip in zip(events, strips, strict=True):
        axes.hlines(strip + 0.4, one.start_s, one.end_s, color='black', linewidth=3.0)
    axes.legend(loc='lower right', bbox_to_anchor=(1.0, 0.95), frameon=False)


def _frequencies(figure: Any, axes: Any, envelope: DriveEnvelope,
                 squeal_band_hz: tuple[float, float]) -> None:
    """Mark every unstable mode, coloured by its growth rate."""
    time, frequency, growth = envelope.marks.T
    if not time.size:
        axes.text(0.5, 0.5, 'no unstable mode', transform=axes.transAxes, ha='center')
        axes.set_ylim(*(f / 1e3 for f in squeal_band_hz))
        return
    marks = axes.scatter(time, frequency / 1e3, c=growth, s=18, cmap='viridis_r', vmin=0.0,
                         edgecolors='0.3', linewidths=0.3, zorder=2)
    low, high = frequency.min(), frequency.max()
    room = max(_HEADROOM * (high - low), _LEAST_HEADROOM * high)
    axes.set_ylim(max(low - room, 0.0) / 1e3, (high + room) / 1e3)
    figure.colorbar(marks, ax=axes, label='growth rate  1/s', pad=0.01, aspect=25)

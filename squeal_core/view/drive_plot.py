"""The picture of a drive: speed, pressure, risk and unstable frequencies over time."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

try:
    import matplotlib
    from matplotlib.figure import Figure
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
import numpy as np

from squeal_core.history import Row


def plot_drive(rows: Sequence[Row], path: str | Path, *, title: str, wheel_radius: float,
               squeal_band_hz: tuple[float, float]) -> None:
    """Draw a drive to a PNG file.

    Parameters
    ----------
    rows : sequence of Row
    path : path
    title : str
    wheel_radius : float
        To show rotor speed as vehicle speed [m].
    squeal_band_hz : (2,) floats
        Shaded in the frequency panel.
    """
    matplotlib.rcParams['font.size'] = 9
    figure = Figure(figsize=(11.0, 8.5), layout='constrained')
    speed, pressure, risk, frequency = figure.subplots(
        4, 1, sharex=True, height_ratios=(1, 1, 1, 2.2))
    brakes = list(dict.fromkeys(row.brake for row in rows))
    for number, brake in enumerate(brakes):
        own = [row for row in rows if row.brake == brake]
        time = [row.time_s for row in own]
        if number == 0:
            rotor = np.array([row.rotor_speed_rad_s for row in own])
            speed.plot(time, rotor * wheel_radius * 3.6, color='0.3', linewidth=1.2)
        pressure.plot(time, [row.pressure_pa / 1e5 for row in own], color=f'C{number}',
                      linewidth=1.0, linestyle='-' if number % 2 == 0 else ':', label=brake)
    _risk_strips(figure, risk, rows, brakes)
    _frequencies(figure, frequency, rows)
    frequency.axhspan(*(f / 1e3 for f in squeal_band_hz), color='0.95', zorder=0)
    speed.set(ylabel='vehicle speed\nkm/h', title=title)
    pressure.set(ylabel='brake pressure\nbar')
    pressure.legend(loc='lower right', bbox_to_anchor=(1.0, 0.97), ncols=len(brakes),
                    frameon=False)
    frequency.set(xlabel='time  s', ylabel='unstable modes  kHz\n(shaded: squeal band)')
    for panel in (speed, pressure, frequency):
        panel.grid(color='0.9')
        panel.margins(x=0.0)
    figure.savefig(path, dpi=110)


def _risk_strips(figure: Any, axes: Any, rows: Sequence[Row], brakes: Sequence[str]) -> None:
    """Draw one strip a brake, coloured by its risk, grey where it is not known."""
    times = np.unique([row.time_s for row in rows])
    risk = np.full((len(brakes), times.size), np.nan)
    for row in rows:
        risk[brakes.index(row.brake), np.searchsorted(times, row.time_s)] = row.squeal_risk
    step = np.diff(times).min(initial=np.inf) if times.size > 1 else 1.0
    axes.set_facecolor('0.8')
    strips = axes.pcolormesh(
        np.append(times, times[-1] + step), np.arange(len(brakes) + 1) - 0.5, risk,
        cmap='Reds', vmin=0.0, vmax=1.0)
    axes.set_yticks(range(len(brakes)), brakes)
    axes.set_ylabel('squeal risk\n(grey: not known)')
    axes.hlines(np.arange(1, len(brakes)) - 0.5, times[0], times[-1] + step, color='1.0')
    axes.invert_yaxis()
    figure.colorbar(strips, ax=axes, pad=0.01, aspect=8)


def _frequencies(figure: Any, axes: Any, rows: Sequence[Row]) -> None:
    """Mark every unstable mode, coloured by its growth rate."""
    points = [(row.time_s, frequency / 1e3, growth) for row in rows for frequency, growth in
              zip(row.unstable_frequencies_hz, row.unstable_growth_rates_1_s, strict=True)]
    if not points:
        axes.text(0.5, 0.5, 'no unstable mode', transform=axes.transAxes, ha='center')
        return
    time, frequency, growth = np.array(points).T
    marks = axes.scatter(time, frequency, c=growth, s=4, cmap='viridis_r', vmin=0.0, zorder=2)
    axes.set_ylim(0.0, 1.1 * frequency.max())
    figure.colorbar(marks, ax=axes, label='growth rate  1/s', pad=0.01, aspect=25)

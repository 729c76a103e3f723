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

"""Charts of sensitivities: a tornado of parameters, growth rates over the angle of masses."""

from collections.abc import Mapping, Sequence
import math
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.studies.design_sensitivity import ParameterEffect, SensitivityStudy
from squeal_core.studies.point_options import brake_pressure
from squeal_core.studies.split_doublet import SplitDoublet, SplitGrowth
from squeal_core.view.saving import FigureTarget
from squeal_core.view.slide import point_words, pressure_words, slide, stiffness_words, typeset
from squeal_core.view.study_labels import parameter_in_words

_MOST_BARS = 16
_MOST_MODES = 3
_SMALL = 12  # points, of what several panels have side by side
_LESS: dict[str, Any] = {'color': '0.85', 'edgecolor': '0.2', 'hatch': '////', 'linewidth': 0.7}
_MORE: dict[str, Any] = {'color': '#1b4f82', 'edgecolor': '0.1', 'linewidth': 0.7}


def plot_tornado(study: SensitivityStudy, effects: Sequence[ParameterEffect],
                 units: Mapping[str, tuple[float, str]], path: FigureTarget, *, title: str = '',
                 overwrite: bool = True) -> None:
    """
    Draw a panel a mode, and one for the squeal risk, the strongest parameter of the first on top.

    Parameters
    ----------
    study : SensitivityStudy
        Modes and operating points.
    effects : sequence of ParameterEffect
        Of its parameters; those not known are left out.
    units : mapping
        Value and unit of each parameter.
    path : path
        Where the file is.
    title : str
        Above the figure.
    overwrite : bool
        Whether an existing file may be replaced.

    """
    known = sorted((effect for effect in effects
                    if not effect.reason and effect.modes[0].reliable), key=lambda effect: -abs(
                        effect.modes[0].growth_rate))[:_MOST_BARS]
    count = min(len(study.targets), _MOST_MODES)
    places, risky = range(len(known)), bool(study.braking)
    heading = f'{title}: one per cent of each parameter'.removeprefix(': ')
    about = f'the {len(known)} strongest on the first mode' if len(known) < len(effects) else ''
    with slide(path, heading, about, overwrite=overwrite) as figure:
        panels = figure.subplots(1, count + risky, sharey=True, squeeze=False)[0]
        for place, (panel, target) in enumerate(zip(panels, study.targets[:count], strict=False)):
            _bars(panel, [(one.modes[place].at_minus, one.modes[place].at_plus)
                          for one in known])
            growth = typeset(f'{target.growth_rate:+.1f}')
            panel.set_title(f'mode {target.identity}, {target.frequency_hz:.0f} Hz\n'
                            f'growth rate {growth} 1/s\n{_at(study, target.point)}',
                            fontsize=11, loc='center')
            panel.set_xlabel('change of the\ngrowth rate  1/s', fontsize=_SMALL)
        if risky:
            _bars(panels[-1], [(-100.0 * one.risk[0], 100.0 * one.risk[0]) for one in known])
            panels[-1].set_title(f'squeal risk {100.0 * study.braking[0].risk:.0f} %\n'
                                 f'of {study.braking[0].duration:g} s of braking\n'
                                 f'{_at(study, study.targets[0].point)}',
                                 fontsize=11, loc='center')
            panels[-1].set_xlabel('change of the risk\npercentage points', fontsize=_SMALL)
        panels[0].set_yticks(list(places), [parameter_label(one.parameter, *units[one.parameter])
                                            for one in known])
        panels[0].invert_yaxis()
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles[:2], labels[:2], loc='outside lower center', ncols=2, frameon=False)


def _at(study: SensitivityStudy, point: OperatingPoint) -> str:
    load = pressure_words(point.contact_pressure, brake_pressure(study.variants.model, point))
    return f'{point.rotor_speed:.3g} rad/s, µ {abs(point.friction):.3f}\n{load}'


def _bars(panel: Any, sides: Sequence[tuple[float, float]]) -> None:
    places = range(len(sides))
    for column, label, look in ((0, '1 % less', _LESS), (1, '1 % more', _MORE)):
        panel.barh(places, [0.0 if math.isnan(side[column]) else side[column] for side in sides],
                   height=0.7, label=label, **look)
    panel.axvline(0.0, color='0.1', linewidth=1.0)
    panel.grid(axis='x', color='0.9')
    panel.tick_params(labelsize=_SMALL)
    panel.margins(x=0.06)


def parameter_label(parameter: str, value: float, unit: str) -> str:
    """Return a parameter in words with its value: 'disc: rotor thickness, 16 mm'."""
    words = parameter_in_words(parameter)[0]
    shown = (stiffness_words(value) if unit == 'N/m^3' else typeset(f'{value:.4g} {unit}'))
    return words if math.isnan(value) else f'{words}, {shown}'.rstrip()


def plot_over_angle(masses: SplitDoublet, growth: SplitGrowth, point: OperatingPoint,
                    path: FigureTarget, *, pressure: float | None = None, title: str = '',
                    overwrite: bool = True) -> None:
    """
    Draw growth rates over the angle of masses on the disc, those without masses as thin lines.

    Parameters
    ----------
    masses : SplitDoublet
        On the disc.
    growth : SplitGrowth
        What they do.
    point : OperatingPoint
        Where.
    path : path
        Where the file is.
    pressure : float, optional
        Of the brake at the point [Pa]; None: it has no caliper.
    title : str
        Above the figure.
    overwrite : bool
        Whether an existing file may be replaced.

    """
    others = sorted(growth.modes[1:], key=lambda mode: -np.nanmax(mode.over_angle))[:3]
    # over the whole period, whose end is its beginning
    angles = np.degrees(np.append(growth.angles, masses.period))
    heading = (f'{title}: {masses.count} masses of {1e3 * masses.mass:.3g} g, doublet of '
               f'{masses.diameters} nodal diameters split by {100.0 * masses.split:.2g} %')
    with slide(path, heading, f'{point_words(point, pressure)}; frozen angles',
               overwrite=overwrite) as figure:
        axes = figure.subplots()
        worst = growth.least_stable.over_angle
        axes.plot(angles, np.append(worst, worst[0]), color='0.8', linewidth=9.0,
                  label='least stable of the band')
        for mode, style, marker, grey in zip((growth.modes[0], *others), ('-', '--', '-.', ':'),
                                             'osd^', ('0.0', '0.25', '0.4', '0.5'), strict=False):
            axes.plot(angles, np.append(mode.over_angle, mode.over_angle[0]), style, color=grey,
                      marker=marker, markersize=6, linewidth=2.0,
                      label=f'mode {mode.identity}, {mode.frequency_hz:.0f} Hz: mean '
                      + typeset(f'{np.nanmean(mode.over_angle):+.1f}, without masses '
                                f'{mode.without:+.1f}'))
            axes.axhline(mode.without, linestyle=style, color=grey, linewidth=0.8)
        axes.axhline(0.0, color='0.0', linewidth=1.4)
        axes.set(xlabel='angle of the masses to the middle of the pads  °',
                 ylabel='growth rate  1/s  (thin: without masses)')
        axes.grid(color='0.9')
        axes.set_xlim(angles[0], angles[-1])
        figure.legend(loc='outside lower center', frameon=False, ncols=2)

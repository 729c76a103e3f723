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

"""Figures for a slide: size and fonts, and styles of mechanisms and brakes."""

from collections.abc import Iterator
from contextlib import contextmanager
import re
import textwrap
from typing import Any, NamedTuple

try:
    from matplotlib import rc_context
    from matplotlib.figure import Figure
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.view.saving import FigureTarget, save_figure

SIZE = (13.33, 7.5)  # in, of a slide of 16:9
DPI = 110
AMPLITUDES = 'viridis'  # colour map, which rises in lightness
GREY = '#666666'
COLOURS = ('#1b5e9b', '#c8432b', '#3b8a4a', '#8a5aa8', '#c98a1b', '#4aa3a8', '#7a6a5a', '#d0679a')
LINES = ('-', '--', '-.', ':')
MARKERS = 'os^DvPX*'
_STYLE = {'font.size': 14, 'axes.titlesize': 15, 'axes.labelsize': 15, 'legend.fontsize': 13,
          'figure.titlesize': 18, 'axes.spines.top': False, 'axes.spines.right': False,
          'axes.titlelocation': 'left', 'hatch.linewidth': 0.8, 'axes.axisbelow': True}
STIFFNESS = ('10⁹ N/m³', 1e9)  # unit of contact stiffness per area in plots, in N/m^3
_LINE, _MOST_LINES = 118, 3  # characters of a line below a title, and how many there are


class Look(NamedTuple):
    """Style of one of several series, distinct in black and white, too."""

    colour: str
    marker: str
    hatch: str
    dash: str = '-'


# of Okabe and Ito, to be told apart with any colour vision
_ORANGE, _BLUE, _GREEN, _PINK, _YELLOW, _SKY = (
    '#D55E00', '#0072B2', '#009E73', '#CC79A7', '#E69F00', '#56B4E9')
MECHANISMS = {
    'mode coupling': Look(_ORANGE, 'o', '//'), 'negative slope': Look(_BLUE, 's', '\\\\'),
    'gyroscopic': Look(_GREEN, '^', '..'), 'radial-dissipation induced': Look(_PINK, 'v', 'xx'),
    'follower force': Look(_YELLOW, 'P', '++'), 'contact damping': Look(_SKY, 'D', 'oo'),
    'divergence': Look('black', 'X', '**'), 'combined': Look(GREY, 'h', '--'),
    'stable': Look('#BBBBBB', '.', '')}
"""Of each label of `stability.mechanism`."""
SEVERAL = (Look(_BLUE, 'o', ''), Look(_ORANGE, 's', '//', '--'), Look(_GREEN, '^', '..', '-.'),
           Look(_PINK, 'D', 'xx', ':'), Look(_YELLOW, 'v', '\\\\'), Look(_SKY, 'P', '++', '--'))
"""Of brakes, or of lines, in their order."""


@contextmanager
def slide(path: FigureTarget, title: str, about: str, *,
          overwrite: bool = True) -> Iterator[Any]:
    """
    Yield the figure of a slide to draw in, which is saved when the context ends well.

    Parameters
    ----------
    path : path or binary file
        PNG, SVG or PDF.
    title, about : str
        Its first line, and the conditions below.
    overwrite : bool
        Whether an existing file may be replaced.

    """
    with rc_context(_STYLE):
        figure = slide_figure(title, about)
        yield figure
        save_figure(figure, path, dpi=DPI, overwrite=overwrite)


def slide_figure(title: str, about: str) -> Any:
    """Return the figure of a slide with its title."""
    figure = Figure(figsize=SIZE, layout='constrained')
    # broken after commas and the like: no number loses its unit
    kept = re.sub('(?<![,;.]) ', '\N{NO-BREAK SPACE}', about)
    lines = [line.replace('\N{NO-BREAK SPACE}', ' ')
             for line in textwrap.wrap(kept, _LINE, break_long_words=False, max_lines=_MOST_LINES,
                                       placeholder=' …')]
    figure.suptitle('\n'.join([title, *lines]), x=0.01, ha='left', fontsize=16)
    return figure


def slide_style() -> Any:
    """Return the context in which the figure of a slide is drawn."""
    return rc_context(_STYLE)


def point_words(point: OperatingPoint, brake_pressure: float | None = None) -> str:
    """Return an operating point in words; brake pressure [Pa] where the model has a caliper."""
    scale = f', damping x {point.damping_scale:g}' if point.damping_scale != 1.0 else ''
    slope = f', slope {point.friction_slope:.3g} s/m' if point.friction_slope else ''
    return (f'{point.rotor_speed:g} rad/s, friction {point.friction:.3g}{typeset(slope)}, '
            f'{pressure_words(point.contact_pressure, brake_pressure)}, contact stiffness '
            f'{stiffness_words(point.contact_stiffness)}{scale}')


def pressure_words(contact_pressure: float, brake_pressure: float | None = None) -> str:
    """Return a contact pressure p0 [Pa], after the brake pressure [Pa] where one is known."""
    contact = f'p₀ = {contact_pressure / 1e5:.3g} bar'
    return contact if brake_pressure is None else (
        f'brake pressure {brake_pressure / 1e5:.3g} bar ({contact})')


def stiffness_words(*ends: float) -> str:
    """Return a contact stiffness per area [N/m^3], or its two ends, with the unit."""
    unit, factor = STIFFNESS
    return f'{" to ".join(dict.fromkeys(f"{end / factor:.3g}" for end in ends))} × {unit}'


def number(value: float, digits: int = 3) -> str:
    """Return a number with its sign, and a minus as wide as the plus."""
    return typeset(f'{value:+.{digits}g}')


def typeset(text: str) -> str:
    """Return numbers and units as they are printed: a minus, m³ for m^3, ° for deg."""
    for plain, printed in (('-', '\N{MINUS SIGN}'), ('^2', '²'), ('^3', '³'), ('degC', '°C'),
                           ('deg', '°')):
        text = text.replace(plain, printed)
    return text

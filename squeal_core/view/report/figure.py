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

"""A figure of the page: traces and layout as plotly.js takes them, without the page's colours."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

Trace: TypeAlias = dict[str, Any]

LEGEND = {'orientation': 'h', 'y': 1.02, 'yanchor': 'bottom'}
"""Of figures: in a row above the axes."""


class Style(NamedTuple):
    """Style of one of several curves, distinct without its colour, too."""

    colour: str
    dash: str
    symbol: str


STYLES = tuple(Style(*one) for one in (
    ('#0072B2', 'solid', 'circle'), ('#D55E00', 'dash', 'square'),
    ('#009E73', 'dot', 'diamond'), ('#CC79A7', 'dashdot', 'triangle-up'),
    ('#E69F00', 'longdash', 'cross'), ('#56B4E9', 'longdashdot', 'x')))
"""Of Okabe and Ito, to be told apart with any colour vision; then they repeat."""
RISKS = 'Viridis'
"""Colour scale of risks and amplitudes, likewise."""
GREY = '#888888'
_MOST_IN_SVG = 2_000  # markers of a trace, beyond which WebGL draws them


def style(place: int) -> Style:
    return STYLES[place % len(STYLES)]


@dataclass(frozen=True, eq=False)
class Figure:
    """
    One figure.

    Parameters
    ----------
    name : str
        Its id in the page.
    title, caption : str
        Above and below it.
    traces : sequence of dict
        As in `data` of plotly.
    layout : mapping
        Likewise; colours of axes and text are the page's.
    height : int
        [px].
    unknown : str
        Why there is nothing to draw; it then stands in the figure's place.
    wide : bool
        Whether it takes the page's width.

    """

    name: str
    title: str
    caption: str = ''
    traces: Sequence[Trace] = ()
    layout: Mapping[str, Any] = field(default_factory=dict)
    height: int = 380
    unknown: str = ''
    wide: bool = False

    def as_plotly(self) -> dict[str, Any]:
        """Return the figure as the page's script draws it."""
        return {'id': self.name, 'data': list(self.traces),
                'layout': {'height': self.height, 'margin': {'l': 65, 'r': 20, 't': 20, 'b': 50},
                           **self.layout}}


def packed(values: ArrayLike, kind: str = 'f4') -> dict[str, str]:
    """Return an array as plotly.js reads it, base64 of its bytes."""
    array = np.ascontiguousarray(values, dtype=f'<{kind}')
    return {'dtype': kind, 'bdata': base64.b64encode(array.tobytes()).decode(),
            **({'shape': ','.join(map(str, array.shape))} if array.ndim > 1 else {})}


def fitted_range(values: ArrayLike) -> list[float]:
    """Return the range of an axis on which close values are distinct; 0 to 1 of none."""
    known = np.asarray(values, float).ravel()
    known = known[np.isfinite(known)]
    if not known.size:
        return [0.0, 1.0]
    low, high = float(known.min()), float(known.max())
    margin = max(0.06 * (high - low), 0.01 * abs(high))
    return [low - margin, high + margin]


def points(count: int) -> Trace:
    """Return the trace type for so many markers: a browser has only few places for WebGL."""
    return {'type': 'scattergl' if count > _MOST_IN_SVG else 'scatter', 'mode': 'markers'}


def boxes(across: ArrayLike, up: ArrayLike, **more: Any) -> Trace:
    """
    Return rectangles as one trace.

    Parameters
    ----------
    across, up : arrays (k, 2), or (2,) for all
        Their ends in x and y.
    **more
        Of the trace: axes, name, filling.

    """
    x, y = np.broadcast_arrays(np.atleast_2d(across), np.atleast_2d(up))
    gap = np.full(len(x), np.nan)
    return {'type': 'scatter', 'mode': 'lines', 'line': {'width': 0}, 'fill': 'toself',
            'x': packed(np.column_stack([x[:, 0], x[:, 0], x[:, 1], x[:, 1], gap]).ravel()),
            'y': packed(np.column_stack([y[:, 0], y[:, 1], y[:, 1], y[:, 0], gap]).ravel()),
            'hoverinfo': 'skip', 'showlegend': False, **more}


def hatched(colour: str) -> dict[str, Any]:
    """Return the filling of what is not known."""
    return {'fillpattern': {'shape': '/', 'fgcolor': colour, 'bgcolor': 'rgba(0,0,0,0)',
                            'size': 7, 'solidity': 0.25, 'fillmode': 'overlay'},
            'fillcolor': 'rgba(0,0,0,0)'}

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

"""The shape of one mode as a web page that holds all it needs: it turns, and may move."""

from collections.abc import Iterator
import json
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common.output import output_file
from squeal_core.model.surface_shapes import Patch
from squeal_core.view.mode_shape import cycle, DrawnSurface, RATE, ShapeView
from squeal_core.view.report.figure import packed, RISKS, Trace
from squeal_core.view.report.markup import label, markup

_HEAD = 'font: 16px sans-serif; margin: 6px 20px; overflow-wrap: anywhere'
_PLAY = {'frame': {'duration': 1000 // RATE, 'redraw': True}, 'transition': {'duration': 0},
         'mode': 'immediate', 'fromcurrent': False}
_SCRIPT = """
const figure = document.getElementById('{plot_id}'), how = HOW;
let playing = true, held = false;  // held while it is turned, which a frame would undo
const stop = () => Plotly.animate(figure, [null], how).catch(() => {});
const play = () => playing && !held && Plotly.animate(figure, null, how).then(play, () => {});
figure.on('plotly_buttonclicked', event => {
  playing = event.button.name === 'play';
  if (playing) play(); else stop();
});
figure.addEventListener('pointerdown', () => { held = true; stop(); }, true);
window.addEventListener('pointerup', () => { held = false; setTimeout(play, 50); });
play();
""".replace('HOW', json.dumps(_PLAY))


def write_shape_page(view: ShapeView, path: str | Path, *, moving: bool,
                     overwrite: bool = True) -> None:
    """
    Write the page.

    Parameters
    ----------
    view : ShapeView
        The mode.
    path : path
        HTML.
    moving : bool
        Whether it moves over its cycle; else it is at its extreme.
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    ImportError
        Where plotly is not installed.

    """
    page = shape_page(view, moving=moving)
    with output_file(path, overwrite=overwrite) as partial:
        partial.write_text(page, encoding='utf-8')


def shape_page(view: ShapeView, *, moving: bool) -> str:
    """Return the page of `write_shape_page`."""
    try:
        from plotly.io import to_html
    except ImportError as error:
        raise ImportError("pages need plotly: pip install -e '.[report]' in the checkout"
                          ) from error
    text: str = to_html(shape_figure(view, moving=moving), include_plotlyjs=True, validate=False,
                        default_height='85vh', post_script=_SCRIPT if moving else None,
                        auto_play=False, config={'displaylogo': False, 'responsive': True})
    title, about = markup(view.title), markup(view.about)
    return text.replace('<head>', f'<head><title>{title}</title>', 1).replace(
        '<body>', f'<body><h1 style="{_HEAD}">{title}</h1><p style="{_HEAD}">{about}; pads drawn '
        'apart. The drawing needs WebGL.</p>', 1)


def shape_figure(view: ShapeView, *, moving: bool) -> dict[str, Any]:
    """Return the figure for plotly.js: surfaces at the extreme, and the frames of a cycle."""
    figure: dict[str, Any] = {'data': [*_surfaces(view, 0.0), *map(_outline, view.surfaces)],
                              'layout': _layout(view, moving=moving)}
    if moving:
        kept = ('type', 'x', 'y', 'z', 'intensity')
        figure['frames'] = [{
            'name': str(place), 'traces': list(range(len(view.surfaces))),
            'data': [{key: trace[key] for key in kept} for trace in _surfaces(view, phase)]}
            for place, phase in enumerate(cycle().tolist())]
    return figure


def _surfaces(view: ShapeView, phase: float) -> Iterator[Trace]:
    for place, one in enumerate(view.surfaces):
        points, size = one.at(phase)
        x, y, z = 1e3 * points.reshape(-1, 3).T
        rows, columns = size.shape
        patch = Patch(one.name, rows, columns, one.closed)
        i, j, k = np.array(list(patch.triangles())).T
        yield {'type': 'mesh3d', 'name': label(one.name), 'x': packed(x), 'y': packed(y),
               'z': packed(z), 'intensity': packed(size.ravel() / view.drawn),
               'i': packed(i, 'i4'), 'j': packed(j, 'i4'), 'k': packed(k, 'i4'),
               'cmin': 0, 'cmax': 1, 'colorscale': RISKS, 'showscale': place == 0,
               'colorbar': {'title': {'text': 'displacement,<br>of the largest'}, 'len': 0.6,
                            'thickness': 16, 'tickvals': [0, 0.5, 1]},
               'hovertemplate': f'{label(one.name)}: %{{intensity:.2f}}<extra></extra>'}


def _outline(one: DrawnSurface) -> Trace:
    gap = np.full((1, 3), np.nan)
    x, y, z = 1e3 * np.concatenate([np.concatenate([edge, gap]) for edge in one.outline()]).T
    return {'type': 'scatter3d', 'mode': 'lines', 'x': packed(x), 'y': packed(y), 'z': packed(z),
            'line': {'color': '#666666', 'width': 2, 'dash': 'dash'}, 'hoverinfo': 'skip',
            'showlegend': False}


def _layout(view: ShapeView, *, moving: bool) -> dict[str, Any]:
    every = 1e3 * np.concatenate([one.points.reshape(-1, 3) for one in view.surfaces])
    ends = np.stack([every.min(axis=0), every.max(axis=0)], axis=1) + 1e3 * view.drawn * np.array(
        [-1.0, 1.0])
    axes: dict[str, Any] = {f'{name}axis': {'title': {'text': f'{name}  mm'},
                                            'range': own.tolist()}
                            for name, own in zip('xyz', ends, strict=True)}
    axes['zaxis'] |= {'title': {'text': 'pads drawn apart'}, 'showticklabels': False}
    names = [{'x': float(x), 'y': float(y), 'z': float(z), 'text': label(one.name),
              'showarrow': False, 'xanchor': 'left'}
             for one in view.surfaces if not one.closed
             for x, y, z in [1e3 * one.points[-1, -1]]]
    buttons = [{'label': word, 'name': word.lower(), 'method': 'skip'}
               for word in ('Play', 'Pause')]
    return {
        'font': {'size': 15}, 'margin': {'l': 0, 'r': 0, 't': 0, 'b': 0}, 'uirevision': 'kept',
        'scene': {**axes, 'aspectmode': 'data', 'annotations': names,
                  'camera': {'eye': {'x': 1.45, 'y': 1.0, 'z': 1.0},
                             'center': {'x': 0.0, 'y': 0.0, 'z': -0.12}}},
        **({'updatemenus': [{'type': 'buttons', 'direction': 'left', 'x': 0.02, 'y': 0.02,
                             'xanchor': 'left', 'yanchor': 'bottom', 'buttons': buttons}]}
           if moving else {})}

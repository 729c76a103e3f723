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

"""The worst mode of a run: its shape in three dimensions, and its mechanism."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
import hashlib
import math
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common import resources
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, Mode
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_core.stability.mechanism import Mechanism, mechanisms
from squeal_core.surrogate.table_file import model_hash
from squeal_core.view.contributions import ranked_terms
from squeal_core.view.report.figure import Figure, GREY, packed, RISKS, Trace
from squeal_core.view.report.markup import label

_DRAWN = 0.012  # m, largest displacement that is drawn
_SAME_MODE = 0.02  # relative difference of frequencies, up to which modes may be the same


@dataclass(frozen=True)
class WorstMode:
    """
    The worst mode at the conditions at which it grows fastest.

    Parameters
    ----------
    model : BrakeModel or None
    point : OperatingPoint or None
    mechanism : Mechanism or None
    conditions : str
        In words.
    unknown : str
        Why there is no mode.

    """

    model: BrakeModel | None = None
    point: OperatingPoint | None = None
    mechanism: Mechanism | None = None
    conditions: str = ''
    unknown: str = ''


def find_model(stated: Mapping[str, Any], beside: Path) -> BrakeModel:
    """
    Return the model of a result, found by its hash.

    Parameters
    ----------
    stated : mapping
        Name, path and SHA-256, as a result's summary has them.
    beside : Path
        Folder in which it is looked for, too.

    Raises
    ------
    SquealError
        Where no file with that hash is found.

    """
    path = Path(str(stated.get('path') or stated.get('name') or ''))
    name = str(stated.get('name') or path.stem)
    for place in dict.fromkeys([path, resources.find('models', name, '.npz'),
                                beside / path.name, Path(path.name)]):
        try:
            if not place.is_file():
                continue
            model = BrakeModel.load(str(place))
            if stated.get('sha256') in (hashlib.sha256(place.read_bytes()).hexdigest(),
                                        model_hash(model)):
                return model
        except (SquealError, OSError):
            continue
    raise SquealError(f'the model {name} with SHA-256 {str(stated.get("sha256"))[:12]}... is '
                      f'neither at {path} nor shipped nor in {beside}')


def worst_mode(stated: Mapping[str, Any], beside: Path,
               path: Mapping[str, FloatArray]) -> WorstMode:
    """
    Return the worst mode of the worst application.

    Parameters
    ----------
    stated : mapping
        The model, as a result's summary has it.
    beside : Path
        Folder of the result.
    path : mapping
        Arrays of the ticks of the application; empty: there is none.

    """
    growth = path.get('growth_rate_1_s', np.empty(0))
    if not np.isfinite(growth).any():
        return WorstMode(unknown='Not known: there is no brake application with a growth rate.')
    try:
        model = find_model(stated, beside)
    except SquealError as error:
        return WorstMode(unknown=f'Not known: {error}. Put the file there for shape and '
                                 'mechanism.')
    at = {name: float(values[np.nanargmax(growth)]) for name, values in path.items()}
    speed, pressure = at['rotor_speed_rad_s'], at['pressure_pa']
    point = model.operating_point(rotor_speed=speed, pressure=pressure, friction=at['friction'])
    mode = _nearest(complex_modes(model, point).modes, at)
    if mode is None:
        return WorstMode(unknown='Not known: the model has no mode near the '
                                 f'{at["worst_frequency_hz"]:.0f} Hz of the table.')
    words = (f'{speed:.1f} rad/s, {pressure / 1e5:.1f} bar, friction {at["friction"]:.3f} (the '
             f'monitor: {at["worst_frequency_hz"]:.0f} Hz, {at["growth_rate_1_s"]:+.2f} 1/s)')
    return WorstMode(model, point, mechanisms(model, point, [mode])[0], words)


def _nearest(modes: Sequence[Mode], at: Mapping[str, float]) -> Mode | None:
    """Return the mode whose eigenvalue is nearest to the one in the table."""
    frequency = at['worst_frequency_hz']
    stated = complex(at['growth_rate_1_s'], 2.0 * math.pi * frequency)
    best = min(modes, key=lambda mode: abs(mode.eigenvalue - stated), default=None)
    if best is None or abs(best.frequency_hz - frequency) > _SAME_MODE * frequency:
        return None
    return best


def shape_figure(result: WorstMode, name: str, of: str = '') -> Figure:
    """Return the shape of the mode at its extreme."""
    about: dict[str, Any] = {'name': name, 'title': f'Shape of the worst mode{of}'}
    if result.model is None or result.point is None or result.mechanism is None:
        return Figure(**about, unknown=result.unknown)
    surface, mode = result.model.surface, result.mechanism.mode
    if surface is None:
        return Figure(**about, unknown='Not known: the model file holds no surface; build it '
                                       'again with this version.')
    vectors = mode_vectors(result.model, result.point, mode.eigenvalue)
    points, amplitude = surface.displaced(vectors.right, _DRAWN)
    return Figure(**about, height=480, traces=list(_meshes(surface, points, amplitude)), caption=(
        f'Mode {mode.index}, {mode.frequency_hz:.0f} Hz, at its extreme, far enlarged; coloured '
        'by displacement over its largest. x, y and z are in mm. Drag to turn it.'), layout={
            'scene': {**{f'{axis}axis': {'title': {'text': f'{axis}  mm'}, 'nticks': 4}
                         for axis in 'xyz'},
                      'aspectmode': 'data', 'camera': {'eye': {'x': 2.1, 'y': 2.1, 'z': 1.8}}},
            'margin': {'l': 0, 'r': 0, 't': 10, 'b': 0}})


def _meshes(surface: Any, points: FloatArray, amplitude: FloatArray) -> Iterator[Trace]:
    first = 0
    for patch in surface.patches:
        own = slice(first, first + patch.size)
        i, j, k = np.array(list(patch.triangles())).T
        x, y, z = 1e3 * points[own].T
        yield {
            'type': 'mesh3d', 'name': label(patch.name), 'x': packed(x), 'y': packed(y),
            'z': packed(z), 'i': packed(i, 'i4'), 'j': packed(j, 'i4'), 'k': packed(k, 'i4'),
            'intensity': packed(amplitude[own]), 'cmin': 0, 'cmax': 1, 'colorscale': RISKS,
            'showscale': first == 0, 'opacity': 1.0, 'flatshading': True,
            'colorbar': {'title': {'text': 'displacement<br>over largest'}, 'thickness': 12,
                         'len': 0.6},
            'hovertemplate': f'{label(patch.name)}: %{{intensity:.2f}}<extra></extra>'}
        first = own.stop


def mechanism_figure(result: WorstMode, name: str, of: str = '') -> Figure:
    """Return the contributions of terms to the growth rate, as bars that sum to it."""
    about: dict[str, Any] = {'name': name, 'title': f'Mechanism of the worst mode{of}'}
    if result.mechanism is None:
        return Figure(**about, unknown=result.unknown)
    terms = ranked_terms(result.mechanism.contributions)
    total = result.mechanism.mode.growth_rate
    names = [*(name.replace('_', ' ') for name in terms), 'growth rate']
    values = [*terms.values(), total]
    return Figure(**about, height=480, caption=(
        f'At {result.conditions}: {result.mechanism.label}; {result.mechanism.reason}. Each bar '
        'begins where the one above it ends; together they are the growth rate.'), traces=[{
            'type': 'waterfall', 'orientation': 'h', 'y': names, 'x': values,
            'measure': ['relative'] * len(terms) + ['total'], 'textposition': 'auto',
            'text': [f'{value:+.2f}' for value in values], 'cliponaxis': False,
            'increasing': {'marker': {'color': '#D55E00'}},
            'decreasing': {'marker': {'color': '#0072B2'}},
            'totals': {'marker': {'color': GREY}},
            'connector': {'line': {'color': GREY, 'width': 1}},
            'hovertemplate': '%{y}: %{text} 1/s<extra></extra>'}], layout={
                'xaxis': {'title': {'text': 'contribution to the growth rate  1/s'}},
                'yaxis': {'autorange': 'reversed', 'automargin': True}, 'showlegend': False})

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

"""Labels of the axes of a study, and of what was not swept."""

import textwrap
from typing import Any

from squeal_core.common.arrays import FloatArray
from squeal_core.common.ranges import SYMBOLS
from squeal_core.studies.point_options import DEFAULT_PRELOAD
from squeal_core.studies.study_record import Study
from squeal_core.surrogate.grid_columns import IMPOSSIBLE
from squeal_core.view.slide import STIFFNESS, stiffness_words, typeset

_UNITS = {'rotor_speed': ('rotor speed', 'rad/s', 1.0),
          'friction': ('friction coefficient', '', 1.0),
          'friction_slope': ('friction slope', 's/m', 1.0),
          'contact_pressure': ('contact pressure', 'bar', 1e5),
          'contact_stiffness': ('contact stiffness', *STIFFNESS),
          'damping_scale': ('damping scale', '', 1.0), 'preload': ('preload', 'kN', 1e3),
          'pressure': ('brake pressure', 'bar', 1e5)}
_LONGEST_LINE = 16  # characters
_NAMES = {'young modulus': "Young's modulus", 'poisson ratio': "Poisson's ratio"}


def parameter_in_words(name: str) -> tuple[str, str, float]:
    """Return a parameter in words, the unit it is shown in, and that in the study's unit."""
    if name in _UNITS:
        return _UNITS[name]
    symbols = {**SYMBOLS, 'mm': 'mm', 'deg': 'deg'}
    suffix = next((one for one in sorted(symbols, key=len, reverse=True)
                   if name.endswith(f'_{one}')), '')
    words = name.removesuffix(f'_{suffix}').replace('_', ' ').replace('.', ': ')
    for plain, printed in _NAMES.items():
        words = words.replace(plain, printed)
    return words, *(STIFFNESS if suffix == 'n_m3' else (typeset(symbols.get(suffix, '')), 1.0))


def study_axis(study: Study, name: str) -> tuple[FloatArray, str]:
    """Return a parameter's values in the unit that is shown, and the axis' label."""
    return shown_axis(name, study.axes[name])


def shown_axis(name: str, values: FloatArray) -> tuple[FloatArray, str]:
    """Return values of a parameter in the unit that is shown, and the axis' label."""
    words, unit, factor = parameter_in_words(name)
    return values / factor, f'{words}  {unit}'.rstrip()


def wrapped(label: str) -> str:
    """Return a label broken into lines, as one beside a small panel is."""
    if len(label) <= _LONGEST_LINE:
        return label
    lines = label.replace(': ', ':\n').replace('  ', '\n').splitlines()
    return '\n'.join(textwrap.fill(line, _LONGEST_LINE) for line in lines)


def study_conditions(study: Study) -> str:
    """Return in words what was not swept, and what is not there."""
    parts = [study.about['brake']] if study.about['brake'] else []
    for name, value in _held(study).items():
        if value is None or value is False or (name, value) == ('damping_scale', 1.0) or (
                name == 'friction' and study.about['friction_law'] is True):
            continue
        words, unit, factor = parameter_in_words(name)
        parts.append('slope by the law' if value is True
                     else f'{words} {stiffness_words(value)}' if name == 'contact_stiffness'
                     else f'{words} {value / factor:g} {unit}'.rstrip())
    parts += ['nominal contact stiffness'] if study.about['point'].get(
        'contact_stiffness', 0.0) is None else []
    if study.about['friction_law']:
        parts.append('friction by its law of speed')
    if not study.about['rotation']:
        parts.append('without rotation')
    impossible, left = study.count(IMPOSSIBLE), int((~study.done).sum())
    parts += [f'{impossible} of {study.size} points impossible'] if impossible else []
    parts += [f'{left} of {study.size} points not done'] if left else []
    return ', '.join(parts)


def _held(study: Study) -> dict[str, Any]:
    """Return the options of the point, with the load that goes where none was given."""
    point = dict(study.about['point'])
    loads = ('preload', 'pressure')
    if all(point.get(name) is None for name in loads) and not {
            *loads, 'contact_pressure'} & study.axes.keys():
        point['preload'] = DEFAULT_PRELOAD
    return point

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

"""Units that the names of columns and fields state, and whether they are those of the signals."""

from collections.abc import Iterator
import re

from squeal_core.common.errors import short_repr
from squeal_core.common.measured_units import find_unit
from squeal_ros.recordings.signals.signals_file import SignalSource

_BRACKETED = re.compile(r'[\[({<]([^\[\](){}<>]*)[\])}>]\s*$')
_ELEMENT = re.compile(r'\[[^\[\]]*\]$')  # of a list
# ends of names that are units and nothing else, after `_` or a blank
_ENDINGS = re.compile(
    r'[_ ](bar|mbar|hpa|kpa|mpa|pa|psi|rpm|rad_s|rads|rev_s|km_h|kmh|kph|mph|m_s|deg_?[cf]|'
    r'celsius|fahrenheit|kelvin|grad_?c|percent|ms|us|ns|sec|seconds|ratio)$', re.IGNORECASE)
_OF_TYPES = {  # of messages whose definition states them
    ('sensor_msgs/msg/FluidPressure', 'fluid_pressure'): 'Pa',
    ('sensor_msgs/msg/Temperature', 'temperature'): 'degC',
    ('sensor_msgs/msg/JointState', 'velocity'): 'rad/s'}


def unit_in_name(name: str) -> str:
    """Return the unit at the end of a name, as `bar` of `Druck [bar]` or `p_bar`; else ''."""
    bracketed = _BRACKETED.search(name)
    if bracketed:
        return bracketed[1].strip()
    after_slash = name.rpartition(' / ')[2] if ' / ' in name else ''
    if after_slash and find_unit(after_slash):
        return after_slash
    ending = _ENDINGS.search(name)
    if ending is None:
        return 's' if re.fullmatch(r'(time|t|zeit|temps|tempo)_s', name.casefold()) else ''
    result = ending[1].casefold()
    return result if result.startswith(('deg', 'grad')) else result.replace('_', '/')


def unit_of_field(message_type: str, path: str) -> str:
    """Return the unit that a message type states of a field, or the name of the field; else ''."""
    stated = _OF_TYPES.get((message_type, path.partition('[')[0]), '')
    named = '' if stated else unit_in_name(_ELEMENT.sub('', path))
    return stated or (named if find_unit(named) else '')


def contradiction(source: SignalSource, name: str, text: str) -> Iterator[str]:
    """
    Yield a note where a column states another unit than the file of signals.

    Parameters
    ----------
    source : SignalSource
        What the file of signals says.
    name : str
        Of the column.
    text : str
        Unit that the column states; empty: none.

    """
    stated = find_unit(text) if text else None
    if stated is not None and not stated.converts_like(source.unit):
        of_other = f', a unit of {stated.quantity}' if (
            stated.quantity != source.unit.quantity) else ''
        yield (f'{source.where}: {source.kind} {short_repr(name)} states {stated.name}{of_other}, '
               f'and the file {source.unit.name}, which is taken')

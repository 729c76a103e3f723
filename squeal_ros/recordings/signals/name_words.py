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

"""Words in names of columns, channels and topics, as loggers of several languages write them."""

import re
import unicodedata

_CAMEL = re.compile(r'(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|(?<=[^\W\d_])(?=\d)|(?<=\d)'
                    r'(?=[^\W\d_])')
_SPELT = str.maketrans({'ä': 'ae', 'ö': 'oe', 'ü': 'ue', 'ß': 'ss', 'Ä': 'Ae', 'Ö': 'Oe',
                        'Ü': 'Ue', 'µ': 'mu', 'μ': 'mu', 'ω': 'omega', 'Ω': 'omega'})
_UNIT = re.compile(r'[\[({<][^\[\](){}<>]*[\])}>]\s*$')


def _each(words: str, value: float) -> dict[str, float]:
    return dict.fromkeys(words.split(), value)


# scores of words against any signal
OTHER_THINGS = {
    **_each(
        'ambient umgebung ambiant ambiante ambiente luft air aria aire oil oel huile olio aceite '
        'cool kuehl coolant water wasser tyre tire reifen pneu pneus pneumatico fuel kraftstoff '
        'engine motor moteur motore schall sound mic mikrofon microphone gyro yaw pitch roll imu '
        'angular gier wind barometer barometric intake boost exhaust abgas std stddev variance '
        'cabin innenraum cpu battery batterie torque moment humidity feuchte', -6.0),
    **_each(
        'soll target setpoint cmd command commanded desired request requested sollwert consigne '
        'limit limite fluid fluessigkeit pad belag plaquette pastiglia lining master tandem '
        'error status quality raw counter min max', -2.0)}
OTHER_STEMS = ('umgebung', 'schall', 'motordreh', 'reifen', 'aussen', 'kuehl', 'oeltemp',
               'ambient')


def plain_words(name: str) -> list[str]:
    """
    Return the words of a name: without its unit in brackets, accents and case.

    Examples
    --------
    >>> plain_words('BremsdruckVL [bar]')
    ['bremsdruck', 'vl']
    >>> plain_words('wss_speed_fl_rad_s')
    ['wss', 'speed', 'fl', 'rad', 's']

    """
    bare = _UNIT.sub('', name).translate(_SPELT)
    letters = ''.join(one for one in unicodedata.normalize('NFKD', bare)
                      if not unicodedata.combining(one))
    return [word.casefold() for part in re.split(r'[\W_]+', letters)
            for word in _CAMEL.split(part) if word]

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

"""Guesses which column or field is which input of which brake, by name, unit and range."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
import re

from squeal_core.common.measured_units import find_unit, Unit, UNITS
from squeal_core.monitor.setting_specs import Signal, SIGNALS
from squeal_ros.recordings.signals.contents import Entry
from squeal_ros.recordings.signals.name_words import OTHER_STEMS, OTHER_THINGS, plain_words
from squeal_ros.recordings.signals.signals_file import QUANTITIES

ONE_BRAKE = 'brake'  # name of one that nothing tells apart
USUAL_RADIUS = 0.32  # m, of the wheel of a car
_LEAST_SCORE = 2.0
# parts of words, with their scores for a signal: English, German, French, Italian, Spanish
_STEMS: Mapping[Signal, Mapping[str, float]] = {
    'pressure': dict.fromkeys(('press', 'druck', 'presion'), 2.5),
    'rotor_speed': {**dict.fromkeys((
        'drehzahl', 'rpm', 'rotorspeed', 'wheelspeed', 'raddreh', 'radgeschw', 'vitesserotation',
        'regime', 'giri', 'wss', 'umdreh', 'tours', 'omega', 'revolution'), 3.0), **dict.fromkeys((
            'speed', 'geschw', 'vitesse', 'velocit', 'velocidad', 'spd'), 2.5)},
    'friction': {**dict.fromkeys((
        'reibwert', 'reibzahl', 'reibungs', 'reibkoeff', 'frict', 'frottement', 'attrito',
        'rozamiento', 'friccion'), 3.0), 'mue': 2.5},
    'temperature': dict.fromkeys(('temp',), 2.5)}
_WORDS: Mapping[Signal, Mapping[str, float]] = {  # whole ones
    'pressure': {'p': 1.0, 'prs': 2.0, 'pb': 1.0}, 'friction': {'mu': 3.0, 'cof': 3.0},
    'rotor_speed': {'n': 1.0, 'v': 0.5, 'vel': 2.0, 'ws': 1.0, 'whl': 1.0},
    'temperature': {'t': 0.5, 'tmp': 2.0}}
_UNIT_STEMS = {'1/min': ('drehzahl', 'rpm', 'regime', 'giri', 'umdreh', 'tours'),
               'km/h': ('vehicle', 'fahrzeug', 'geschw', 'vitesse', 'velocita')}
_LATITUDE = frozenset(('lat', 'latitude', 'latitud', 'latitudine', 'breite', 'breitengrad'))
_LONGITUDE = frozenset(('lon', 'long', 'lng', 'longitude', 'longitud', 'longitudine', 'laenge',
                        'laengengrad'))
_MOVEMENT = frozenset(('acc', 'accel', 'acceleration', 'beschl', 'vel', 'velocity', 'speed',
                       'force', 'slip', 'err', 'g'))
_BETTER = ('disc', 'disk', 'rotor', 'scheibe', 'disque', 'disco', 'brake', 'brems', 'frein',
           'freno', 'wheel', 'rad', 'roue', 'ruota', 'actual', 'ist', 'wss')
_SIDES = {'l': 'left', 'left': 'left', 'links': 'left', 'li': 'left', 'gauche': 'left',
          'sinistra': 'left', 'sinistro': 'left', 'sx': 'left', 'izquierda': 'left',
          'izquierdo': 'left', 'lh': 'left', 'r': 'right', 'right': 'right', 'rechts': 'right',
          're': 'right', 'droite': 'right', 'droit': 'right', 'destra': 'right',
          'destro': 'right', 'dx': 'right', 'derecha': 'right', 'derecho': 'right',
          'rh': 'right'}
_AXLES = {'front': 'front', 'vorne': 'front', 'vorn': 'front', 'vorder': 'front', 'va': 'front',
          'avant': 'front', 'av': 'front', 'anteriore': 'front', 'ant': 'front',
          'delantera': 'front', 'delantero': 'front', 'rear': 'rear', 'hinten': 'rear',
          'hinter': 'rear', 'ha': 'rear', 'arriere': 'rear', 'ar': 'rear', 'posteriore': 'rear',
          'post': 'rear', 'trasera': 'rear', 'trasero': 'rear', 'back': 'rear'}
_CORNERS = {code: f'{axle}_{side}' for axle, side, codes in (
    ('front', 'left', 'fl lf vl avg frontleft vornelinks avantgauche'),
    ('front', 'right', 'fr rf vr avd frontright vornerechts avantdroite avantdroit'),
    ('rear', 'left', 'rl lr hl arg rearleft hintenlinks arrieregauche'),
    ('rear', 'right', 'rr hr ard rearright hintenrechts arrieredroite arrieredroit'))
    for code in codes.split()}
_WHEELS = ('front_left', 'front_right', 'rear_left', 'rear_right')
_ELEMENT = re.compile(r'(.*)\[(\d+)\](.*)')
_PREFIXES = ('p', 'n', 'v', 't', 'mu', 'press', 'druck', 'temp', 'speed', 'ws', 'wss',
             'bremsdruck')


@dataclass(frozen=True)
class Guess:
    """
    One input of one brake, as it is guessed.

    Parameters
    ----------
    brake, signal : str
    entry : Entry
        That it is read from.
    unit : Unit
    score : float
        How much speaks for it.
    notes : tuple of str
        What of it was guessed, and by what; empty: name and unit say it.
    max_age_s : float, optional
        Where values come more seldom than is usual.
    absolute : bool
        Whether a pressure rests at that of the air.

    """

    brake: str
    signal: Signal
    entry: Entry
    unit: Unit
    score: float
    notes: tuple[str, ...] = ()
    max_age_s: float | None = None
    absolute: bool = False


@dataclass(frozen=True)
class Proposal:
    """
    Proposed contents of a file of signals for a recording.

    Parameters
    ----------
    brakes : mapping
        The guesses of each brake, of those that have all inputs.
    incomplete : mapping
        What other brakes lack.

    """

    brakes: Mapping[str, Sequence[Guess]]
    incomplete: Mapping[str, Sequence[str]] = field(default_factory=dict)

    @property
    def radius_needed(self) -> bool:
        """Return whether a speed is that of the vehicle."""
        return any(guess.unit.quantity == 'speed' for one in self.brakes.values() for guess in one)


def propose(entries: Sequence[Entry]) -> Proposal:
    """Return the inputs of each brake, as far as names, units and ranges tell."""
    best: dict[tuple[str, Signal], Guess] = {}
    labels = {entry.label for entry in entries}
    for entry in entries:
        for guess in _by_element(_guesses(entry), labels):
            key = guess.brake, guess.signal
            if key not in best or guess.score > best[key].score:
                best[key] = guess
    places = list(dict.fromkeys(brake for brake, _ in best))
    corners = sorted((place for place in places if '_' in place), key=_order)
    names = corners or sorted((place for place in places if place), key=_order) or (
        [''] if places else [])
    result = {name or ONE_BRAKE: [*filter(None, (
        _of_brake(best, name, signal) for signal in SIGNALS))] for name in names}
    lacking = {name: lacks for name, guesses in result.items() if (lacks := _lacks(guesses))}
    return Proposal({name: guesses for name, guesses in result.items() if name not in lacking},
                    lacking)


def position_of(entries: Sequence[Entry]) -> tuple[Entry, ...]:
    """Return the columns that look like latitude and longitude; nothing where one is missing."""
    result = [next((entry for entry in entries if not entry.field and entry.type == 'number'
                    and entry.unit.strip('[]() °').casefold() in ('', 'deg', 'grad')
                    and words & set(plain_words(entry.name)) and entry.count
                    and not _MOVEMENT & set(plain_words(entry.name))
                    and -most <= entry.minimum <= entry.maximum <= most), None)
              for words, most in ((_LATITUDE, 90.0), (_LONGITUDE, 180.0))]
    return tuple(entry for entry in result if entry) if all(result) else ()


def _by_element(guesses: Iterator[Guess], labels: Collection[str]) -> Iterator[Guess]:
    """Yield guesses of elements of arrays as such; of four they are in the usual order."""
    for guess in guesses:
        element = _ELEMENT.fullmatch(guess.entry.field)
        count = 0
        while element and f'{guess.entry.name} {element[1]}[{count}]{element[3]}' in labels:
            count += 1
        if not element or guess.brake or count < 2:
            yield guess
        elif count == len(_WHEELS):
            yield replace(guess, brake=_WHEELS[int(element[2])], notes=(
                *guess.notes, f'by its place among four: {", ".join(_WHEELS)}'))
        else:
            yield replace(guess, notes=(*guess.notes, f'one of {count} elements'))


def _order(name: str) -> tuple[bool, str]:
    return not name.startswith('front'), name


def _of_brake(best: Mapping[tuple[str, Signal], Guess], name: str, signal: Signal
              ) -> Guess | None:
    """Return the guess for a brake: its own, its axle's, or one of no brake in particular."""
    for place in dict.fromkeys((name, name.partition('_')[0], '')):
        guess = best.get((place, signal))
        if guess is not None:
            if place == name:
                return guess
            of = f'that of the {place} axle' if place else 'of no brake in particular'
            return Guess(name, signal, guess.entry, guess.unit, guess.score,
                         (*guess.notes, of), guess.max_age_s, guess.absolute)
    return None


def _lacks(guesses: Sequence[Guess]) -> list[str]:
    there = {guess.signal for guess in guesses}
    lacks = [signal for signal in ('rotor_speed', 'pressure') if signal not in there]
    return lacks + ([] if {'friction', 'temperature'} & there else ['friction or temperature'])


def _guesses(entry: Entry) -> Iterator[Guess]:
    """Yield the signals that an entry may be."""
    if entry.type in ('text', 'time') or not entry.count:
        return
    label = entry.label.replace('[', ' ').replace(']', ' ') if entry.field else entry.label
    words = plain_words(label)
    joined = ''.join(words)
    stated = find_unit(entry.unit) if entry.unit else None
    against = sum(OTHER_THINGS.get(word, 0.0) for word in set(words)) - 6.0 * any(
        stem in joined for stem in OTHER_STEMS)
    against += 0.5 * any(stem in joined for stem in _BETTER)
    for signal in SIGNALS:
        score = max([0.0, *(value for stem, value in _STEMS[signal].items() if stem in joined),
                     *(_WORDS[signal].get(word, 0.0) for word in _parts(words))])
        if stated is not None:
            fits = stated.quantity in QUANTITIES[signal]
            if not fits or signal == 'friction' and not score:
                continue
            score += 0.0 if signal == 'friction' else 2.5
        if score == 1.0 and len([word for word in words if word not in _CORNERS]) == 1:
            score = _LEAST_SCORE  # `p`, `n_FL`: that letter is all of the name
        if score + against < _LEAST_SCORE or not score:
            continue
        unit, why = (stated, '') if stated else _unit_of(signal, entry, joined)
        score -= 0.5 * (unit.quantity == 'speed')  # that of a wheel is nearer to the rotor
        yield _completed(_place(words), signal, entry, unit, score + against, why)


def _completed(brake: str, signal: Signal, entry: Entry, unit: Unit, score: float,
               why: str) -> Guess:
    notes, slow = [f'unit {why}'] if why else [], entry.rate_hz < 5.0
    low = unit.scale * entry.minimum + unit.offset
    absolute = signal == 'pressure' and not unit.reference and 0.85e5 < low < 1.1e5
    if absolute:
        notes.append('never below 1 bar, so probably absolute')
    return Guess(brake, signal, entry, unit, score, tuple(notes),
                 math.ceil(25.0 / entry.rate_hz) / 10.0 if slow else None, absolute)


def _parts(words: Sequence[str]) -> Iterator[str]:
    """Yield words, and the text before the name of a brake in one: `p` of `pfl`."""
    for word in words:
        yield word
        if word[-2:] in _CORNERS and word[:-2] in _PREFIXES:
            yield word[:-2]


def _place(words: Sequence[str]) -> str:
    """Return the brake that words name: a corner, an axle, a side, or ''."""
    for word in words:
        if word in _CORNERS:
            return _CORNERS[word]
        if word[-2:] in _CORNERS and word[:-2] in _PREFIXES:
            return _CORNERS[word[-2:]]
    joined = '_'.join(words)
    for code, corner in _CORNERS.items():
        if len(code) > 3 and code in joined.replace('_', ''):
            return corner
    axle = next((_AXLES[word] for word in words if word in _AXLES), '')
    side = next((_SIDES[word] for word in words if word in _SIDES), '')
    if axle and side:
        return f'{axle}_{side}'
    return axle or (side if any(word in _SIDES and len(word) > 2 for word in words) else '')


def _unit_of(signal: Signal, entry: Entry, joined: str) -> tuple[Unit, str]:
    """Return a unit that is not stated, and the ground of the guess."""
    low, largest = entry.minimum, max(abs(entry.minimum), abs(entry.maximum))
    by_range = f'by its range, {low:.4g} to {entry.maximum:.4g}'
    if signal == 'pressure':
        name = 'bar' if largest <= 300.0 else 'kPa' if largest <= 30_000.0 else 'Pa'
        return UNITS[name], by_range
    if signal == 'temperature':
        return UNITS['K' if low > 240.0 and largest < 1100.0 else 'degC'], by_range
    if signal == 'friction':
        return (UNITS['-'], '') if largest <= 2.0 else (UNITS['%'], by_range)
    for unit, stems in _UNIT_STEMS.items():
        if any(stem in joined for stem in stems):
            return UNITS[unit], 'by its name'
    return UNITS['rad/s' if largest <= 200.0 else '1/min'], by_range

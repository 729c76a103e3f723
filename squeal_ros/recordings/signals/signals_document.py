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

"""The file of signals that `squeal signals` proposes; guesses are marked."""

from collections.abc import Iterator, Mapping, Sequence
import json
import math
from typing import Any

from squeal_core.common.errors import printable
from squeal_core.common.wording import counted
from squeal_ros.recordings.signals.contents import Contents, Entry
from squeal_ros.recordings.signals.signal_guesses import Guess, position_of, Proposal, USUAL_RADIUS

_MOST_LISTED = 400


def listing(contents: Contents) -> Iterator[str]:
    """Yield the contents of a recording, line by line."""
    span = ''
    if not math.isnan(contents.start_s):
        span = (f', {contents.end_s - contents.start_s:.6g} s from {contents.start_s:.6f}')
    yield f'{contents.path}: {contents.kind}, {counted(len(contents.entries), "field")}{span}'
    yield from contents.notes
    for entry in contents.entries[:_MOST_LISTED]:
        yield _line(entry)
    if len(contents.entries) > _MOST_LISTED:
        yield f'and {len(contents.entries) - _MOST_LISTED} more: see --json'


def _line(entry: Entry) -> str:
    unit = entry.unit.strip('[] ')
    parts = [entry.type if entry.type != 'number' else '', unit and f'[{unit}]',
             counted(entry.count, 'value')]
    if not math.isnan(entry.rate_hz):
        parts.append(f'{entry.rate_hz:.4g} Hz')
    if not math.isnan(entry.minimum):
        parts.append(f'{entry.minimum:.6g} to {entry.maximum:.6g}')
    if entry.gaps:
        parts.append(f'{counted(entry.gaps, "gap")}, the longest {entry.longest_gap_s:.3g} s')
    parts += [f'{entry.missing} empty'] if entry.missing else []
    parts += [counted(entry.texts, 'text')] if entry.texts else []
    group = f' (group {entry.group})' if entry.group is not None else ''
    return f'  {printable(entry.label)}{group}: {", ".join(filter(None, parts))}'


def signals_document(contents: Contents, proposal: Proposal) -> str:
    """Return the proposed file; with no brake that has all inputs it is none to be used."""
    lines = [f'# Signals of {printable(contents.path.name)}, as proposed by `squeal signals`. '
             'Check what is marked as a guess.',
             '# docs/howto/recordings.md explains each key.']
    if contents.clock:
        lines.append('clock:')
        lines += [_entry(f'  {key}: {_text(value)}', [contents.clock_notes.get(key, '')])
                  for key, value in contents.clock.items()]
    if proposal.radius_needed:
        lines.append(_entry(f'wheel_radius_m: {USUAL_RADIUS}',
                            ['a usual one; give the rolling radius of the wheel']))
    lines.append('brakes:' if proposal.brakes else 'brakes: {}')
    for brake, guesses in proposal.brakes.items():
        lines.append(f'  {brake}:')
        for guess in guesses:
            keys = _keys(guess, contents.kind)
            lines.append(_entry(f'    {guess.signal}: {_mapping(keys)}', guess.notes))
    if position := position_of(contents.entries):
        lines.append(_entry('position:', ['by the names of its columns']))
        lines += [f'  {key}: {_mapping(_column(entry, contents.kind))}' for key, entry in zip(
            ('latitude', 'longitude'), position, strict=True)]
    for brake, lacks in proposal.incomplete.items():
        lines.append(f'# {brake}: left out, nothing looks like its {" and ".join(lacks)}')
    return '\n'.join(lines) + '\n'


def _mapping(keys: Mapping[str, Any]) -> str:
    return f'{{{", ".join(f"{key}: {_text(value)}" for key, value in keys.items())}}}'


def _column(entry: Entry, kind: str) -> dict[str, Any]:
    group = {} if entry.group is None else {'group': entry.group}
    return {'channel' if kind == 'mdf' else 'column': entry.name, **group}


def _keys(guess: Guess, kind: str) -> Mapping[str, Any]:
    entry = guess.entry
    keys: dict[str, Any] = {'topic': entry.name, 'type': entry.type, 'field': entry.field} if (
        entry.field) else _column(entry, kind)
    keys['unit'] = guess.unit.name
    if guess.absolute:
        keys['reference'] = 'absolute'
    if guess.max_age_s is not None:
        keys['max_age'] = guess.max_age_s
    return keys


def _entry(line: str, notes: Sequence[str]) -> str:
    said = '; '.join(filter(None, notes))
    return f'{line}  # guess: {said}' if said else line


def _text(value: Any) -> str:
    """Return a value as YAML has it on one line, in quotes where it is a text."""
    if value and isinstance(value, str) and value.isidentifier() and value.isascii():
        return value if value.casefold() not in _YAML_WORDS else f"'{value}'"
    return json.dumps(value, ensure_ascii=False)


_YAML_WORDS = ('y', 'n', 'yes', 'no', 'on', 'off', 'true', 'false', 'null')

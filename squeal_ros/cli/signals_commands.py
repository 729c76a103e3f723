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

"""`squeal signals`: the contents of a recording, and a proposed file of signals."""

import argparse
from collections.abc import Iterator
from dataclasses import asdict
import json
from pathlib import Path
from typing import Any

from squeal_core.common.output import OutputFiles
from squeal_core.common.wording import counted
from squeal_ros.cli.arguments import check_output
from squeal_ros.cli.console import plain, report_progress
from squeal_ros.recordings.signals.contents import Contents
from squeal_ros.recordings.signals.signal_guesses import Guess, Proposal, propose
from squeal_ros.recordings.signals.signals_document import listing, signals_document
from squeal_ros.recordings.survey import contents_of


def signals(options: argparse.Namespace) -> int:
    """List the contents of a recording and propose a file of signals."""
    check_output('--output', options.output, force=options.force, inputs=(options.recording,))
    report_progress(f'reading {options.recording}')
    contents = contents_of(options.recording, options.types)
    proposal = propose(contents.entries)
    document = signals_document(contents, proposal)
    usable = bool(proposal.brakes and (contents.clock or contents.kind != 'csv'))
    if options.output:
        with OutputFiles(overwrite=options.force) as files:
            files.add(options.output).partial.write_text(document, encoding='utf-8')
    if options.json:
        print(json.dumps(plain({**_as_json(contents, proposal), 'usable': usable,
                                'output': options.output, 'document': document})))
    elif options.output:
        print('\n'.join(listing(contents)))
        print('\n'.join(_verdict(contents, proposal, usable)))
        print(f'written: {options.output}')
    else:  # a file of signals, as it stands
        print('\n'.join(f'# {line}' for line in listing(contents)))
        print(document, end='')
        print('\n'.join(f'# {line}' for line in _verdict(contents, proposal, usable)))
    return 0 if usable else 1


def _verdict(contents: Contents, proposal: Proposal, usable: bool) -> Iterator[str]:
    guessed = sum(bool(guess.notes) for one in proposal.brakes.values() for guess in one)
    for brake, lacks in proposal.incomplete.items():
        yield f'{brake}: nothing looks like its {" and ".join(lacks)}'
    if not contents.clock and contents.kind == 'csv':
        yield 'no column looks like the clock: write clock: {column: ..., unit: ...}'
    if usable:
        brakes = counted(len(proposal.brakes), 'brake')
        yield (f'proposed: {brakes} ({", ".join(proposal.brakes)}), '
               f'{counted(guessed, "input")} with guesses to be checked')
    else:
        yield 'no brake has all inputs: complete the file by what is listed'


def _as_json(contents: Contents, proposal: Proposal) -> dict[str, Any]:
    return {**{key: value for key, value in asdict(contents).items() if key != 'path'},
            'path': str(Path(contents.path)),
            'proposal': {brake: {guess.signal: _guess_json(guess) for guess in guesses}
                         for brake, guesses in proposal.brakes.items()},
            'incomplete': {brake: list(lacks) for brake, lacks in proposal.incomplete.items()}}


def _guess_json(guess: Guess) -> dict[str, Any]:
    return {'name': guess.entry.name, 'field': guess.entry.field, 'group': guess.entry.group,
            'unit': guess.unit.name, 'guesses': list(guess.notes)}

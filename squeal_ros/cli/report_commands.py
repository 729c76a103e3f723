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

"""`squeal report`: one page of the results of replays."""

import argparse
import json
import math
from pathlib import Path

from squeal_core.common.errors import SquealError
from squeal_core.common.output import output_file
from squeal_core.monitor.results.fleet_files import is_fleet
from squeal_core.sound.comparison import compare
from squeal_core.view.report.page import report_page
from squeal_core.view.report.runs import load_runs, Run
from squeal_ros.cli.arguments import check_output
from squeal_ros.cli.console import plain, ProgressBar
from squeal_ros.cli.fleet_report import fleet_report


def report(options: argparse.Namespace) -> int:
    """Write the page."""
    check_output('--output', options.output, ('.html', '.htm'), force=options.force)
    if any(map(is_fleet, options.results)):
        return fleet_report(options)
    if options.pages is not None:
        raise SquealError(f'--pages: {options.results[0]} is no folder that `squeal fleet` wrote')
    stretch = tuple(options.stretch) if options.stretch else None
    if stretch and not -math.inf < stretch[0] < stretch[1] < math.inf:
        raise SquealError(f'--stretch: {stretch[0]:g} to {stretch[1]:g} s; give a start and a '
                          'later end')
    runs = load_runs(options.results)
    comparisons = [compare(run.results, options.sound) for run in runs] if options.sound else []
    with ProgressBar('recordings') as progress:
        page = report_page(runs, comparisons=comparisons, stretch=stretch, progress=progress)
    with output_file(options.output, overwrite=options.force) as partial:
        partial.write_text(page, encoding='utf-8')
    size = Path(options.output).stat().st_size
    if options.json:
        print(json.dumps(plain({'output': options.output, 'bytes': size,
                                'runs': [_as_json(run) for run in runs],
                                'comparisons': [one.as_json() for one in comparisons]})))
    else:
        for run in runs:
            print(_line(run))
        for result in comparisons:
            print('\n'.join(result.lines()))
        print(f'written: {options.output}, {size / 1e6:.1f} MB')
    return 1 if all(run.nothing_known for run in runs) else 0


def _as_json(run: Run) -> dict[str, object]:
    return {'name': run.name, 'recordings': [result.name for result in run.results],
            'braking_s': run.total('braking_s'), 'risk_known_share': run.known_share,
            'applications': len(run.applications), 'applications_known': len(run.known),
            'applications_squealing': len(run.squealing) if run.known else None,
            'events': None if run.nothing_known else len(run.events)}


def _line(run: Run) -> str:
    if run.nothing_known:
        return f'{run.name}: nothing is known of squeal'
    return (f'{run.name}: {len(run.squealing)} of {len(run.known)} known brake applications with '
            f'predicted squeal ({len(run.applications) - len(run.known)} not known)')

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


"""`squeal report` of the folder of a fleet: its page, and those of its recordings."""

import argparse
from collections.abc import Sequence
import json
import os
from pathlib import Path

from squeal_core.common.errors import SquealError
from squeal_core.common.output import make_folder, output_file
from squeal_core.monitor.results.fleet_files import FleetFolder
from squeal_core.monitor.results.result_files import SUMMARY
from squeal_core.view.report.fleet_groups import FleetData, read_fleet, Row
from squeal_core.view.report.fleet_page import fleet_page
from squeal_core.view.report.fleet_sections import worst_first
from squeal_core.view.report.page import plotly_script, report_page
from squeal_core.view.report.runs import loaded, Run
from squeal_ros.cli.console import plain, ProgressBar, warn

PLOTLY = 'plotly.min.js'
_MOST_PAGES = 20


def fleet_report(options: argparse.Namespace) -> int:
    """Write the page of a fleet, and those of its worst recordings."""
    if len(options.results) > 1 or options.sound or options.stretch:
        raise SquealError(f'{options.results[0]}: is the folder of a fleet; give it alone, '
                          'without --sound and --stretch')
    count = _count(options.pages)
    output = Path(options.output)
    data = read_fleet(FleetFolder.load(options.results[0]))
    folder = output.with_name(f'{output.stem}_recordings')
    new = _write_pages(worst_first(data)[:count], data, folder)
    pages = {one.result: os.path.join(folder.name, _page_name(one.result))
             for _, one in data.recordings if (folder / _page_name(one.result)).is_file()}
    how = ('A name without a link: its page is not made yet. `squeal report '
           f'{options.results[0]} -o {output} --force --pages all` makes those of all '
           'recordings, --pages N of the N worst.')
    with output_file(output, overwrite=options.force) as partial:
        partial.write_text(fleet_page(data, pages, how), encoding='utf-8')
    return _said(options, data, len(pages), new)


def _count(text: str | None) -> int | None:
    """Return of how many recordings pages are made; None: of all."""
    words: dict[str | None, int | None] = {None: _MOST_PAGES, 'all': None, 'none': 0}
    if text in words:
        return words[text]
    if text is not None and text.isdecimal():
        return int(text)
    raise SquealError(f'--pages: is {text}; give all, none or a number')


def _page_name(result: str) -> str:
    """Return the name of the page of a result: results with other content have another name."""
    return f'{Path(result).name}.html'


def _write_pages(rows: Sequence[Row], data: FleetData, folder: Path) -> int:
    """Write the pages of recordings that are not there yet; return how many."""
    missing = {one.result: (label, one) for label, one in rows
               if not (folder / _page_name(one.result)).is_file()}
    if not missing:
        return 0
    script = folder / PLOTLY
    make_folder(folder)
    with output_file(script, overwrite=True) as partial:
        partial.write_text(plotly_script(), encoding='utf-8')
    written = 0
    with ProgressBar('pages of recordings') as progress:
        for done, (label, one) in enumerate(missing.values(), start=1):
            try:
                result = loaded(data.folder.path / one.result / SUMMARY)
                page = report_page([Run(label.recording, (result,))], plotly=PLOTLY)
                with output_file(folder / _page_name(one.result)) as partial:
                    partial.write_text(page, encoding='utf-8')
                written += 1
            except SquealError as error:  # the others have theirs
                warn(f'no page of {label.recording}: {error}')
            progress(done, len(missing))
    return written


def _said(options: argparse.Namespace, data: FleetData, linked: int, new: int) -> int:
    total, size = data.total, Path(options.output).stat().st_size
    nothing = total.braking_s > total.risk_known_s == 0.0
    if options.json:
        print(json.dumps(plain({
            'output': options.output, 'bytes': size, 'recordings': total.recordings,
            'recordings_failed': data.folder.manifest['recordings_failed'],
            'vehicles': len([name for name in data.vehicles if name]),
            'braking_s': total.braking_s, 'risk_not_known_share': total.unknown_share,
            'applications': total.applications, 'applications_known': total.known,
            'applications_squealing': total.alarms if total.known else None,
            'pages_written': new, 'pages_linked': linked})))
    else:
        print(f'{total.alarms} of {total.known} known brake applications with predicted squeal '
              f'({total.applications - total.known} not known) in {total.recordings} recordings'
              if not nothing else 'nothing is known of squeal')
        print(f'written: {options.output}, {size / 1e6:.1f} MB; pages of {linked} recordings, '
              f'{new} of them new')
    return 1 if nothing else 0

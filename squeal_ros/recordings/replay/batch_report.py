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

"""Report on the replays of many recordings: unknown results first."""

from collections.abc import Iterator, Sequence
import math
from typing import Any

from squeal_core.common.wording import counted, percent_down, risk_in_words
from squeal_core.monitor.results.drive_summary import DriveSummary
from squeal_ros.recordings.replay.replay_batch import ReplayOutcome

_MOST_LINES = 40


class BatchReport:
    """
    The outcome of a batch, in words and for programs.

    Parameters
    ----------
    outcomes : sequence of ReplayOutcome
        Of the recordings that were begun.
    count : int
        Recordings of the batch.

    """

    def __init__(self, outcomes: Sequence[ReplayOutcome], count: int) -> None:
        self._outcomes, self._count = outcomes, count
        self._replayed = [one for one in outcomes if one.report]
        self._outside = [one for one in outcomes if one.outside]
        self._failed = [one for one in outcomes if not one.report and not one.outside]

    @property
    def usable(self) -> bool:
        """Return whether any recording was replayed."""
        return bool(self._replayed)

    @property
    def good(self) -> bool:
        """Return whether all were replayed, with a squeal risk of every brake that braked."""
        return not self._failed and all(one.report.good for one in self._replayed if one.report)

    @property
    def _summaries(self) -> list[DriveSummary]:
        return [one.report.summary for one in self._replayed if one.report]

    @property
    def _braking(self) -> float:
        return sum(summary.braking_time for summary in self._summaries)

    @property
    def _known(self) -> float:
        return sum(summary.known_time for summary in self._summaries)

    def as_json(self) -> dict[str, Any]:
        """Return the report as plain data; docs/reference/results.md names the keys."""
        return {
            'recordings_found': self._count, 'recordings_replayed': len(self._replayed),
            'recordings_failed': len(self._failed), 'recordings_outside': len(self._outside),
            'risk_known_share': self._known / self._braking if self._braking else math.nan,
            'braking_s': self._braking, 'risk_known_s': self._known,
            **{f'total_{name}': value for name, value in self._totals().items()},
            'recordings': [{
                'name': one.name, 'path': str(one.path),
                'output': str(one.output) if one.report else None, 'error': one.error or None,
                'partial': one.partial, 'span_s': one.span,
                'applications': len(one.applications),
                **({} if one.report is None else one.report.as_json())}
                           for one in self._outcomes]}

    def _totals(self) -> dict[str, Any]:
        applications = [each.alarm for one in self._replayed for each in one.applications]
        return {'span_s': sum(one.span for one in self._replayed),
                'events': sum(len(one.report.events) for one in self._replayed if one.report),
                'applications': len(applications), 'applications_with_alarm':
                    applications.count(True), 'applications_not_known': applications.count(None)}

    def lines(self) -> list[str]:
        """Return the report in words, line by line."""
        said = [f'{what}: {one.name}: {text}' for one in self._replayed if one.report
                for what, texts in (('finding', one.report.findings), ('note', one.report.notes))
                for text in texts]
        return [*self._unknown(), *_shortened([*self._recordings()]), *_shortened(said),
                *self._total()]

    def _unknown(self) -> Iterator[str]:
        """Yield the fraction of the braking with a known risk, and the unknown rest."""
        count = f'{len(self._replayed)} of {self._count} recordings'
        if self._braking:
            share = percent_down(self._known / self._braking)
            yield (f'squeal risk known for {share} of the braking time '
                   f'({self._known:.1f} of {self._braking:.1f} s of all brakes) in {count}')
        else:
            yield f'no braking in {count}, so nothing to assess'
        yield from _shortened([f'not replayed: {one.error}' for one in self._failed])
        if self._outside:
            yield f'nothing in the range: {len(self._outside)} of {self._count} recordings'
        left = self._count - len(self._outcomes)
        if left:
            yield f'not begun: {left} of {self._count} recordings'
        for one in self._replayed:
            assert one.report is not None
            if one.partial:
                yield f'partial: {one.name}, its first {one.span:.0f} s'
        yield from _shortened([*self._reasons()])

    def _reasons(self) -> Iterator[str]:
        """Yield the reasons and remedies of each recording with a risk not known throughout."""
        for one in self._replayed:
            assert one.report is not None
            summary = one.report.summary
            why = [one.report.why_not_all] if one.report.why_not_all else []
            if summary.never_known:
                yield '; '.join([
                    f'never known: {one.name}: {", ".join(summary.never_known)}', *why])
            elif summary.risk_share < 1.0 and why:
                yield '; '.join([f'known in part: {one.name}', *why])

    def _recordings(self) -> Iterator[str]:
        width = max((len(one.name) for one in self._replayed), default=0)
        for one in self._replayed:
            assert one.report is not None
            summary = one.report.summary
            known = 'no braking' if math.isnan(summary.risk_share) else (
                f'risk known for {percent_down(summary.risk_share)} of '
                f'{summary.braking_time:.1f} s')
            peaks = [brake.peak_risk for brake in summary.brakes.values()
                     if not math.isnan(brake.peak_risk)]
            risk = f', risk up to {risk_in_words(max(peaks))}' if peaks else ''
            events = (counted(len(one.report.events), 'squeal event') if one.report.events_known
                      else 'squeal events not known')
            alarms = [each.alarm for each in one.applications]
            yield (f'{one.name:{width}}  {_duration(one.span)}; {known}{risk}; {events}; '
                   f'{alarms.count(True)} of {len(alarms)} brake applications with an alarm')

    def _total(self) -> Iterator[str]:
        if not self._replayed:
            return
        total = self._totals()
        unknown = total['applications_not_known']
        yield (f'total: {_duration(total["span_s"])}; {counted(total["events"], "squeal event")}; '
               f'{total["applications_with_alarm"]} of {total["applications"]} brake applications '
               f'with an alarm{f", {unknown} not known" if unknown else ""}')


def _duration(seconds: float) -> str:
    return f'{seconds / 3600.0:.2f} h' if seconds >= 3600.0 else f'{seconds:.0f} s'


def _shortened(lines: list[str]) -> list[str]:
    if len(lines) <= _MOST_LINES:
        return lines
    return [*lines[:_MOST_LINES], f'and {len(lines) - _MOST_LINES} more: see --json']

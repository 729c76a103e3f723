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

"""Report on a replay: first, for how much of the braking a risk is known, and why not for all."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
import math
from typing import Any

from squeal_core.common.wording import counted, percent_down, risk_in_words
from squeal_core.monitor.results.drive_summary import (
    BrakeSummary,
    DriveSummary,
    Reason,
    worst_reason,
)
from squeal_core.monitor.results.squeal_events import SquealEvent
from squeal_ros.recordings.findings import Finding

_MOST_LINES = 12
# remedies where the bag itself gives none, by words of a reading
_REMEDIES = (
    ('looks like bar', 'set its scale: 1.0e+5, if it is in bar'),
    ('looks like rpm', 'set its scale: 0.10472, if it is in rpm'),
    ('stamped ahead', 'set its stamp: receipt, or stamp with the clock of the recording'),
    ('without a stamp', 'set its stamp: receipt'),
    ('given as gauge', 'set its reference: absolute'),
    ('given as absolute', 'set its reference: gauge'),
    ('contradicted', 'have one publisher on its topic'),
    ('implausible', 'check the sensor and its unit against the brakes it is compared with'),
    ('stuck', 'check the sensor; stuck_after and stuck_changes say when a value counts as stuck'),
    ('outside validated range', 'see the validated_... settings: the model says nothing beyond '
                                'them'),
    ('outside its range', 'check its unit, scale and offset, then minimum and maximum'),
    ('never received', 'check topic, type and field of the input'),
    ('stale', 'check that its source ran; max_age should be some periods of its messages'),
    ('time went backwards', 'the clock of the recording was set back; see '
                            'docs/reference/interface.md'))
_BEYOND_EMULATOR = ('`squeal info MODEL` shows its range; where most of the ensemble is outside, '
                    'lower damping_deviation, contact_stiffness_deviation, '
                    'friction_bias_deviation or friction_slope_deviation of the settings')
_ANY_REMEDY = 'docs/reference/reliability.md says what each reason means'


class ReplayReport:
    """
    The result of a replay, in words and for programs.

    Parameters
    ----------
    summary : DriveSummary
    events : sequence of SquealEvent
    findings : sequence of Finding
        What of the bag does not fit the settings.
    notes : sequence of str
        What else is to be known of the bag.
    risk_basis : str
        What the level of the squeal risk rests on.

    """

    def __init__(self, summary: DriveSummary, events: Sequence[SquealEvent],
                 findings: Sequence[Finding], notes: Sequence[str] = (),
                 risk_basis: str = '') -> None:
        self.summary, self.events = summary, events
        self._of_risk = _risk_findings(summary)
        self.findings, self.notes, self.risk_basis = findings, notes, risk_basis

    @property
    def good(self) -> bool:
        """Return whether the risk was known of every brake for which it should have been."""
        return not self.summary.never_known

    @property
    def events_known(self) -> bool:
        """Return whether squeal would have been detected at all."""
        return bool(self.summary.known_time or not self.summary.braking_time)

    def as_json(self) -> dict[str, Any]:
        """Return the report as plain data; docs/reference/results.md names the keys."""
        summary = self.summary
        worst = worst_reason(summary.brakes.values())
        return {
            'risk_known_share': summary.risk_share, 'risk_known_s': summary.known_time,
            'risk_basis': self.risk_basis, 'never_known': list(summary.never_known),
            'incomplete_share': summary.incomplete_share,
            'assessed_share': summary.share, 'braking_s': summary.braking_time,
            'assessed_s': summary.assessed_time,
            'never_assessed': list(summary.never_assessed),
            'ticks': summary.ticks, 'ticks_by_state': dict(summary.states),
            'top_reason': None if worst is None else self._reason_json(*worst),
            'silence_s': summary.silence,
            'brakes': {name: {
                'risk_known_share': brake.risk_share, 'assessed_share': brake.share,
                'braking_s': brake.braking * brake.period,
                'assessed_s': brake.assessed * brake.period,
                'mean_risk': brake.mean_risk, 'peak_risk': brake.peak_risk,
                'ticks_by_state': dict(brake.states),
                'reasons': [self._reason_json(reason, brake)
                            for reason in brake.ranked()[:_MOST_LINES]]}
                       for name, brake in summary.brakes.items()},
            'findings': [asdict(finding) for finding in (*self._of_risk, *self.findings)],
            'notes': list(self.notes),
            'events': [self._event_json(event) for event in self.events]
            if self.events_known else None}

    @staticmethod
    def _event_json(event: SquealEvent) -> dict[str, Any]:
        # the names before there was a table of events, then those of its columns
        return {'brake': event.brake, 'start': event.start_s, 'end': event.end_s,
                'peak_risk': event.peak_risk, 'growth_rate': event.growth_rate_1_s,
                **event._asdict()}

    def lines(self) -> list[str]:
        """Return the report in words, line by line, without the events."""
        summary = self.summary
        lines = [*self._first_lines()]
        lines += [f'finding: {finding}' for finding in self._of_risk]
        width = max(map(len, summary.brakes))
        lines += [f'{name:{width}}  {_brake_line(brake)}'
                  for name, brake in summary.brakes.items()]
        if self.risk_basis and summary.known_time:
            lines.append(f'squeal risk: {self.risk_basis}')
        if summary.silence:
            lines.append(f'left out: {summary.silence:.1f} s in which no message came')
        lines += self.top_reason
        lines += [f'finding: {finding}' for finding in self.findings[:_MOST_LINES]]
        if len(self.findings) > _MOST_LINES:
            lines.append(f'{len(self.findings) - _MOST_LINES} more findings: see --json')
        return [*lines, *(f'note: {note}' for note in self.notes)]

    @property
    def top_reason(self) -> list[str]:
        """Return the reason that cost most braking time and its remedy, in two lines; none: []."""
        worst = worst_reason(self.summary.brakes.values())
        if worst is None:
            return []
        reason, brake = worst
        return [f'top reason, {counted(reason.ticks, "tick")} of {brake.name}, first at '
                f'{reason.since:.1f} s: {reason.text}',
                f'  remedy: {self.remedy(reason, brake)}']

    @property
    def why_not_all(self) -> str:
        """Return the reason for braking without a known squeal risk, and the remedy."""
        return '; '.join(map(str.strip, self.top_reason)) or '; '.join(
            f'finding: {finding}' for finding in self._of_risk[:1])

    def event_lines(self) -> list[str]:
        """Return the events in words, line by line; where nothing was assessed, that."""
        ticks = counted(self.summary.ticks, 'tick')
        if not self.events_known:
            what = 'squeal risk known' if self.summary.assessed_time else 'braking assessed'
            return [f'{ticks}, squeal events: not known ({what} at none)']
        while_known = ' while the squeal risk was known' if self.summary.risk_share < 1.0 else ''
        count = len(self.events)
        more = count - _MOST_LINES
        return [f'{ticks}, {counted(count, "squeal event")}{while_known}',
                *(f'  {e.brake}, {e.start_s:.1f} to {e.end_s:.1f} s: risk up to '
                  f'{risk_in_words(e.peak_risk)}, {e.frequency_hz:.0f} Hz, growth '
                  f'{e.growth_rate_1_s:+.1f} 1/s'
                  for e in self.events[:_MOST_LINES]),
                *([f'  and {more} more: see the table'] if more > 0 else [])]

    def _first_lines(self) -> Iterator[str]:
        """Yield the fractions of the braking with a known squeal risk, and assessed."""
        summary = self.summary
        if math.isnan(summary.share):
            yield f'no braking in {counted(summary.ticks, "tick")}, so nothing to assess'
            return
        every = ' of all brakes' if len(summary.brakes) > 1 else ''
        never, partly = summary.never_known, summary.incomplete_share
        yield (f'squeal risk known for {percent_down(summary.risk_share)} of the braking time '
               f'({summary.known_time:.1f} of {summary.braking_time:.1f} s{every})'
               + (f', {percent_down(partly)} in brake applications seen in part only'
                  if partly else '')
               + (f'; never known: {", ".join(never)}' if never else ''))
        never = summary.never_assessed
        yield (f'assessed {percent_down(summary.share)} of the braking time '
               f'({summary.assessed_time:.1f} of {summary.braking_time:.1f} s{every})'
               + (f'; never assessed: {", ".join(never)}' if never else ''))

    def remedy(self, reason: Reason, brake: BrakeSummary) -> str:
        """Return the remedy for a reason: by the bag, else by the state of the inputs."""
        own = [f'{brake.name}.{signal}' for signal in reason.inputs]
        remedies: dict[str, list[str]] = {}
        for finding in self.findings:
            remedies.setdefault(finding.remedy, []).extend(
                name for name in finding.inputs if name in own)
        result = [f'{", ".join(names)}: {remedy}' for remedy, names in remedies.items() if names]
        if result:
            return '; '.join(result)
        said = f'{reason.details} {reason.text}'
        return next((remedy for words, remedy in _REMEDIES if words in said), _ANY_REMEDY)

    def _reason_json(self, reason: Reason, brake: BrakeSummary) -> Mapping[str, Any]:
        return {'brake': brake.name, 'state': reason.state, 'ticks': reason.ticks,
                'braking_ticks': reason.braking, 'first_at_s': reason.since,
                'text': reason.text, 'remedy': self.remedy(reason, brake)}


def _risk_findings(summary: DriveSummary) -> list[Finding]:
    """Return findings on the unknown squeal risk of sliding brakes, each with a remedy."""
    result: dict[str, list[BrakeSummary]] = defaultdict(list)
    for brake in summary.brakes.values():
        for why in brake.unknown_risks:
            result[why].append(brake)
    return [_risk_finding(why, brakes) for why, brakes in result.items()]


def _risk_finding(why: str, brakes: Sequence[BrakeSummary]) -> Finding:
    seconds = sum(brake.unknown_risks[why] * brake.period for brake in brakes)
    cause, _, remedy = why.partition('; ')
    return Finding(tuple(brake.name for brake in brakes),
                   f'squeal risk not known for {seconds:.1f} s of sliding under load: {cause}',
                   remedy or _BEYOND_EMULATOR)


def _brake_line(brake: BrakeSummary) -> str:
    share = 'no braking' if math.isnan(brake.share) else (
        f'{percent_down(brake.share):>6} of {brake.braking * brake.period:.1f} s')
    states = ', '.join(f'{count} {state}' for state, count in brake.states.most_common())
    risk = ('; squeal risk not known' if brake.never_known else '') if math.isnan(
        brake.mean_risk) else (
        f'; squeal risk {risk_in_words(brake.mean_risk)} on average, up to '
        f'{risk_in_words(brake.peak_risk)}')
    return f'{share}{risk}; ticks: {states}'

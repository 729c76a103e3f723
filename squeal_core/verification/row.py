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

"""A row of the table, and the table as text."""

from collections.abc import Sequence
from dataclasses import dataclass
import textwrap
from typing import get_args, Literal, TypeAlias

from squeal_core.verification.paper import EXACT, FIT

Verdict: TypeAlias = Literal['reproduced', 'within fit', 'NOT reproduced']
_WIDTHS = (28, 8, 13, 22, 9, 14)
_HEAD = ('claim', 'source', 'K09', 'here', 'tolerance', 'verdict')


@dataclass(frozen=True, kw_only=True)
class ClaimResult:
    """
    One claim of the paper, in our words, and its result here.

    `known` says that a difference is understood, and `reason` why; see `Verification.passed`.
    """

    claim: str
    source: str
    paper: str
    project: str
    tolerance: str
    verdict: Verdict
    reason: str = ''
    known: bool = False


def row(claim: str, source: str, paper: str, project: str, holds: bool, *, known: bool = False,
        why: str = '', fit: bool = False, tolerance: str = 'as said') -> ClaimResult:
    """Return the row of a statement that holds, nearly holds (`fit`) or does not."""
    verdict: Verdict = 'reproduced' if holds else 'within fit' if fit else 'NOT reproduced'
    return ClaimResult(claim=claim, source=source, paper=paper, project=project,
                       tolerance=tolerance, verdict=verdict, reason='' if holds else why,
                       known=known and not holds)


def table(rows: Sequence[ClaimResult], skipped: Sequence[str], *, passed: bool) -> str:
    """Return rows as text, 99 columns wide, and claims not reproduced with the reason."""
    lines = [*_cells(_HEAD), '-' * 99]
    for row in rows:
        lines += _cells((row.claim, row.source, row.paper, row.project, row.tolerance,
                         row.verdict))
    counts = ', '.join(f'{sum(row.verdict == verdict for row in rows)} {verdict}'
                       for verdict in get_args(Verdict))
    end = 'nothing unexpected' if passed else 'UNEXPECTED differences'
    return '\n'.join([*lines, '', *_reasons(rows, skipped), '',
                      f'Frequencies are reproduced within {EXACT:.1%}, within fit up to '
                      f'{FIT:.1%}.', f'{len(rows)} claims: {counts}; {end}'])


def _reasons(rows: Sequence[ClaimResult], skipped: Sequence[str]) -> list[str]:
    """Return each reason once, with all claims that share it."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        if row.reason:
            reasons.setdefault((row.verdict, row.reason), []).append(row.claim)
    items = [f'{"; ".join(claims)}: {verdict}. {reason[0].upper()}{reason[1:]}.'
             for (verdict, reason), claims in reasons.items()]
    items += [f'Left out: {text}.' for text in skipped]
    return ['Why', *(line for item in items for line in textwrap.wrap(
        item, 99, initial_indent='- ', subsequent_indent='  '))]


def _cells(texts: Sequence[str]) -> list[str]:
    columns = [textwrap.wrap(text, width) or [''] for text, width in zip(texts, _WIDTHS,
                                                                         strict=True)]
    height = max(map(len, columns))
    return [' '.join((column[i] if i < len(column) else '').ljust(width)
                     for column, width in zip(columns, _WIDTHS, strict=True)).rstrip()
            for i in range(height)]

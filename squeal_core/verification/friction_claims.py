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

"""Claims of K09 about growing friction and the effect of rotation: figs 11 and 12."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from squeal_core.stability.eigensolution import Mode
from squeal_core.stability.exceptional_point import nearest_exceptional_point
from squeal_core.stability.mechanism import without_rotation
from squeal_core.verification.case import Case, gap, merged
from squeal_core.verification.paper import PADS, SLOW, SOFTER, THIRD
from squeal_core.verification.parts import Parts
from squeal_core.verification.row import ClaimResult, row


@dataclass(frozen=True)
class _Variants:
    """A case as it is, without rotation, and with the radial dissipation alone of rotation."""

    case: Case

    @cached_property
    def still(self) -> Case:
        return Case(without_rotation(self.case.model))

    @cached_property
    def damped(self) -> Case:
        return Case(replace(self.case.model, gyroscopic=None, negative_slope=None))


def third_doublet(case: Case) -> Iterator[ClaimResult]:
    """Yield the claims of fig. 12, and of section 3.1 on rotation."""
    variants, slow = _Variants(case), case.at(SLOW)
    still = variants.still
    first, second = still.pair(THIRD, slow)
    at = nearest_exceptional_point(still.model, slow, modes=(first, second)).value.real
    yield row('13/14 merge without rotation', 'fig. 12', 'merge', f'at friction {at:.3f}; '
              f'{gap(first, second):.2f} Hz apart at 0.42', merged(first, second))
    turning = Case(replace(case.model, radial_dissipation=None, negative_slope=None))
    one, other = turning.pair(THIRD, slow)
    split = [first.growth_rate - second.growth_rate, one.growth_rate - other.growth_rate]
    yield row('gyroscopic term splits Re further', 'sec. 3.1', 'strengthens',
              f'{split[0]:.1f} to {split[1]:.1f} 1/s', split[1] > split[0])
    low, high, both = (c.critical_friction(THIRD) for c in (still, variants.damped, case))
    yield row('radial term raises critical friction of 13/14', 'sec. 3.1', 'raises',
              f'{low:.3f} to {high:.3f}; all rotation {both:.3f}', high > low)


def pad_pair(case: Case, parts: Parts | None) -> Iterator[ClaimResult]:
    """Yield the claims of fig. 11: two rigid modes of the pads."""
    variants, slow = _Variants(case), case.at(SLOW)
    still = variants.still
    first, second = still.pair(PADS, slow)
    softer = [still.soft_pair(stiffness) for stiffness in SOFTER]
    near = _mergings(still, softer)
    yield row('25/26 merge without rotation, K 100 %', 'fig. 11', 'merge',
              f'{gap(first, second):.1f} Hz apart at 0.42', merged(first, second),
              why=_why_apart(gap(first, second), near, parts),
              known=all(merged(*pair) for pair in softer))
    yield row('such a merging at K 70 to 72 %', 'fig. 11', 'merge (100 %)',
              f'at friction {near}', all(merged(*pair) for pair in softer),
              tolerance='softer K')
    grown = variants.damped.pair(PADS, slow)[0].growth_rate
    yield row('unlike radial damping of 25/26 destabilises', 'sec. 3.1', 'destabilises',
              f'{first.growth_rate:+.1f} to {grown:+.1f} 1/s', grown > first.growth_rate)
    yield _raised(variants, softer[1])


def _mergings(still: Case, softer: Sequence[tuple[Mode, Mode]]) -> str:
    """Return frictions at which pairs merge at the softer contact stiffnesses, in words."""
    result = (nearest_exceptional_point(still.model, still.at(SLOW, stiffness=k),
                                        modes=pair).value.real
              for k, pair in zip(SOFTER, softer, strict=True))
    return ', '.join(f'{value:.2f}' for value in result)


def _why_apart(apart: float, near: str, parts: Parts | None) -> str:
    why = (f'with exact contact integrals they stay {apart:.0f} Hz apart. At 70, 71 and 72 % of '
           f'the stiffness they do merge, at frictions {near}')
    if parts:
        worst, _ = Case(without_rotation(parts.by_sums)).soft_pair(1.0)
        why += (f'; and at 100 % too ({worst.growth_rate:+.0f} 1/s, {worst.frequency_hz:.0f} '
                'Hz) where integrals are sums over 15 x 43 nodes, as K09 eq. (40) reads, which '
                'counts the rim of the patch too much (docs/explanation/theory.md)')
    return why


def _raised(variants: _Variants, softer: tuple[Mode, Mode]) -> ClaimResult:
    """Return the claim on critical friction by the radial term, at full and at 71 % stiffness."""
    both = variants.still, variants.damped
    low, high = (case.critical_friction(PADS) for case in both)
    soft = [case.critical_friction([mode.index for mode in softer], stiffness=SOFTER[1])
            for case in both]
    return row('radial term raises critical friction of 25/26', 'sec. 3.1', 'raises',
               f'{low:.3f} to {high:.3f}', high > low, known=soft[1] > soft[0],
               why='there is no merging here that it could put off; where there is one, at 71 % '
               f'of the stiffness, it does: from {soft[0]:.3f} to {soft[1]:.3f}')

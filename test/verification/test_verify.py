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

"""`squeal verify`: the table against the paper's printed numbers."""

from collections.abc import Iterator
from dataclasses import replace
import json
from pathlib import Path
import re
import sys

import numpy as np
import pytest
from squeal_core import BrakeModel, verification
from squeal_core.common.errors import SquealError
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.stability.mechanism import without_rotation
from squeal_core.verification import as_text, Case, ClaimResult, Verification, verify
from squeal_core.verification.claims import components, maps
from squeal_core.verification.paper import PRINTED
from squeal_core.verification.parts import parts_or_why
from support.eigenvalues import companion

pytestmark = pytest.mark.timeout(900)  # for a machine that others use; the whole takes one minute
ROOT = Path(__file__).parents[2]
DATA = json.loads((Path(__file__).parents[1] / 'data' / 'k09.json').read_text(encoding='utf-8'))
KNOWN = {'2521 Hz: added by gyroscopic term', 'further pairs at 20 rad/s',
         '25/26 merge without rotation, K 100 %',
         'radial term raises critical friction of 25/26', '... down to standstill'}


@pytest.fixture(scope='module')
def found(kang: BrakeModel, solved_once: None) -> Verification:
    """Return all claims; takes half a minute."""
    return verify(kang, stride=100)  # nothing is drawn here


def row(found: Verification, claim: str) -> ClaimResult:
    (one,) = [r for r in found.rows if r.claim == claim]
    return one


def numbers(text: str) -> list[float]:
    return [float(word) for word in re.findall(r'(?<![\w/])[-+]?\d+(?:\.\d+)?', text)]


# ---------------------------------------------------------------- the table

def test_nothing_unexpected(found: Verification) -> None:
    assert found.passed
    assert found.skipped == ()
    assert {r.claim for r in found.rows if r.verdict == 'NOT reproduced'} == KNOWN
    assert len({r.claim for r in found.rows}) == len(found.rows) >= 30
    for r in found.rows:
        assert bool(r.reason) == (r.verdict != 'reproduced')
        assert r.known == (r.verdict == 'NOT reproduced')


def test_every_figure_is_there(found: Verification) -> None:
    sources = {r.source for r in found.rows}
    assert {f'fig. {i}' for i in (8, 10, 11, 12, 14, 15, 16)} <= sources


def test_printed_frequencies_are_the_papers(found: Verification) -> None:
    printed = {item['frequency_hz']: item['mode'] for item in DATA['printed_hz']}
    assert {number: name for number, name, *_ in PRINTED} == printed
    for number, name, words, *_ in PRINTED:
        r = row(found, words)
        assert numbers(r.paper) == [number]
        own = found.model.angular_frequencies[found.model.names.index(name)] / 2.0 / np.pi
        assert numbers(r.project)[0] == pytest.approx(own, abs=0.051)


def test_merging_without_rotation(found: Verification, kang: BrakeModel) -> None:
    """Roots of K = W + k A0 + mu k B0 alone: near 71 % two of them meet as friction grows."""
    def closest(stiffness: float, friction: float, near_hz: float) -> tuple[float, float]:
        k = stiffness * kang.nominal_contact_stiffness
        matrix = np.diag(kang.angular_frequencies**2) + k * (
            kang.contact_stiffness + friction * kang.friction_couple)
        roots = np.sqrt(np.linalg.eigvals(matrix).astype(complex)) / 2.0 / np.pi
        pair = roots[np.argsort(np.abs(roots.real - near_hz))[:2]]
        return abs(np.ptp(pair.real)), float(np.ptp(pair.imag))

    gap, split = closest(0.71, 0.42, 2698.0)
    assert gap < 2.0 < 10.0 < split  # Hz: past their merging
    assert closest(0.71, 0.05, 2700.0)[0] > 8.0
    gap, split = closest(1.0, 0.42, 3204.0)
    assert gap > 10.0 > 1.0 > split
    assert numbers(row(found, '25/26 merge without rotation, K 100 %').project)[0] == (
        pytest.approx(gap, abs=0.1))
    for stiffness, friction in zip((0.70, 0.71, 0.72), numbers(row(
            found, 'such a merging at K 70 to 72 %').project), strict=True):
        near = {0.70: 2679.7, 0.71: 2698.0, 0.72: 2714.5}[stiffness]
        before, after = (closest(stiffness, friction + step, near) for step in (-0.06, 0.06))
        assert before[0] > before[1]
        assert after[0] < after[1]


def test_critical_frictions_are_where_growth_changes_sign(found: Verification) -> None:
    low, high, both = numbers(row(
        found, 'radial term raises critical friction of 13/14').project)
    still = without_rotation(found.model)
    damped = replace(still, radial_dissipation=found.model.radial_dissipation)
    for model, friction in ((still, low), (damped, high), (found.model, both)):
        grows = [max(m.growth_rate for m in complex_modes(model, Case(model).at(
            5.0, friction=friction + step)).modes if 1600.0 < m.frequency_hz < 1700.0) > 0.0
            for step in (-2e-3, 2e-3)]
        assert grows == [False, True]


def test_speeds_are_where_growth_changes_sign(found: Verification) -> None:
    edges = {words: numbers(row(found, f'{words} doublet stable at low speed').project)[0]
             for words in ('third', 'fourth')}
    for words, hertz in (('third', 1660.0), ('fourth', 2523.0)):
        grows = [any(m.kind == 'flutter' and abs(m.frequency_hz - hertz) < 20.0
                     for m in complex_modes(found.model, Case(found.model).by_law(
                         edges[words] + step)).modes) for step in (-0.2, 0.2)]
        assert grows == [False, True]


def test_text_is_no_wider_than_a_page(found: Verification) -> None:
    text = as_text(found)
    assert max(map(len, text.splitlines())) <= 99
    assert text.splitlines()[-1].endswith('nothing unexpected')
    first = text.split()
    assert first[:2] == ['claim', 'source']
    for r in found.rows:  # every word of a claim, though columns wrap
        assert set(r.claim.split()) <= set(first)


def test_json(found: Verification) -> None:
    table = json.loads(json.dumps(found.to_json()))
    assert table['passed'] is True
    assert [r['verdict'] for r in table['rows']] == [r.verdict for r in found.rows]


def test_documentation_shows_this_table(found: Verification) -> None:
    source = ROOT / 'docs' / 'explanation' / 'verification.md'
    page = ' '.join(source.read_text(encoding='utf-8').split())
    assert as_text(found).splitlines()[-1] in page
    for r in found.rows:
        assert r.paper.split()[0] in page
    for name in re.findall(r'images/(\w+\.png)', page):
        size = (ROOT / 'docs' / 'images' / name).stat().st_size
        assert 5_000 < size < 150_000, name


@pytest.mark.parametrize('seed', range(6))
def test_two_mode_formula_of_the_theory_page(seed: int) -> None:
    """4 w^2 s^2 = (c + i w O g)^2 - (n - i w d)^2, theory.md (*), to first order."""
    w, small = 1e4, np.random.default_rng(seed).uniform(-30.0, 30.0, 3)  # 1/s
    c, n, turn = 2.0 * w * small[0], 2.0 * w * small[1], small[2]
    d1, d2 = np.random.default_rng(seed + 100).uniform(0.0, 60.0, 2)
    k = np.array([[w**2 - n, c], [-c, w**2 + n]])
    d = np.array([[d1, turn], [-turn, d2]])
    roots = np.linalg.eigvals(companion(k, d))
    found = np.sort_complex(roots[roots.imag > 0.0])
    s = np.sqrt((c + 1j * w * turn)**2 - (n - 0.5j * w * (d1 - d2))**2) / (2.0 * w)
    expected = np.sort_complex(1j * w - 0.25 * (d1 + d2) + np.array([s, -s]))
    assert np.abs(found - expected).max() < 5.0 * 60.0**2 / w  # what is left out is of this size
    assert np.abs(s) > 5.0 * 60.0**2 / w  # and what is predicted is larger


# ---------------------------------------------------------------- what ought to be noticed

def verdicts(rows: Iterator[ClaimResult]) -> dict[str, ClaimResult]:
    return {r.claim: r for r in rows}


@pytest.mark.parametrize(('factor', 'verdict'), [
    (1.0, 'reproduced'), (1.003, 'within fit'), (0.997, 'within fit'), (1.01, 'NOT reproduced')])
def test_frequencies_that_are_off(factor: float, verdict: str, kang: BrakeModel) -> None:
    changed = replace(kang, angular_frequencies=factor * kang.angular_frequencies)
    r = verdicts(components(Case(changed)))['disc, 3 nodal diameters']
    assert (r.verdict, r.known) == (verdict, False)


def test_a_changed_brake_does_not_pass(kang: BrakeModel, found: Verification) -> None:
    """Without enough friction couple the third doublet does not squeal: not known, so it fails."""
    weak = replace(kang, friction_couple=0.5 * kang.friction_couple)
    rows = tuple(maps(Case(weak)))
    assert verdicts(iter(rows))['pairs that squeal at 5 rad/s'].verdict == 'NOT reproduced'
    worse = replace(found, rows=rows)
    assert not worse.passed
    assert as_text(worse).endswith('UNEXPECTED differences')


def test_other_extra_modes_are_not_known(kang: BrakeModel) -> None:
    """Without structural damping more doublets squeal at 20 rad/s than is explained."""
    bare = replace(kang, damping_ratios=1e-6)
    r = verdicts(maps(Case(bare)))['further pairs at 20 rad/s']
    assert (r.verdict, r.known) == ('NOT reproduced', False)


def test_another_brake_is_refused() -> None:
    with pytest.raises(SquealError, match=r'pad 1 flexible 1.*kang2009'):
        verify(BrakeModel(angular_frequencies=np.array([1.0, 2.0])))


def test_without_scikit_fem(kang: BrakeModel, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules
                 if name.startswith(('skfem', 'squeal_core.modes.fe.'))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, 'skfem', None)
    parts, skipped = parts_or_why(kang)
    assert parts is None
    assert 'scikit-fem' in skipped[0]


def test_a_model_that_cannot_be_rebuilt_is_left_out(kang: BrakeModel) -> None:
    parts, skipped = parts_or_why(replace(kang, provenance={}))
    assert parts is None
    assert 'missing' in skipped[0]


def test_an_interrupted_sweep_is_no_result(kang: BrakeModel,
                                           monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*arguments: object, **options: object) -> object:
        return type('Record', (), {'complete': False})

    monkeypatch.setattr(verification, 'sweep', stopped)
    with pytest.raises(KeyboardInterrupt):
        verification.sweeps(kang, None, 0)

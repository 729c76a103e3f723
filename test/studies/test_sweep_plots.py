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

"""Pictures of sweeps: maps of stability and of growth, loci, growth rates."""

from dataclasses import replace
from pathlib import Path
import re
from typing import Any

from matplotlib import rc_context
import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.studies.point_options import brake_pressure
from squeal_core.studies.sweep import sweep
from squeal_core.view.locus_plot import plot_growth_rates, plot_loci
from squeal_core.view.slide import point_words, slide_figure, stiffness_words
from squeal_core.view.stability_map import (
    conditions,
    plot_growth_map,
    plot_stability_map,
    shown_to,
)
from squeal_core.view.study_labels import shown_axis
from squeal_core.view.tornado import parameter_label
from support.sweeps import at, FRICTIONS, interrupted, PAIR, POINT


def marks(svg: str) -> int:
    """Return the number of circles of a scatter plot."""
    groups = re.findall(r'<g id="PathCollection_1">(.*?)</g>\s*</g>', svg, re.DOTALL)
    return len(re.findall('<use', groups[0])) if groups else 0


def drawn(path: Path, plot: Any, *args: Any, **options: Any) -> str:
    with rc_context({'svg.fonttype': 'none'}):
        plot(*args, path, **options)
    return path.read_text(encoding='utf-8')


def test_map_of_stability(kang: BrakeModel, tmp_path: Path) -> None:
    """A circle for each mode that flutters below the frequency shown."""
    record = sweep(kang, at(kang), {'contact_stiffness': np.linspace(0.5, 1.5, 5) * 0.35e11})
    svg = drawn(tmp_path / 'map.svg', plot_stability_map, record, title='Fig. 10')
    expected = (record.kinds == 'flutter') & (record.frequencies_hz <= 8000.0)
    assert marks(svg) == expected.sum() > 8
    for text in ('contact stiffness  % of nominal', 'frequency  kHz', 'Fig. 10', 'Ω = 5 rad/s',
                 'µ = 0.42', 'growth rate of unstable modes  1/s'):
        assert text in svg
    low = drawn(tmp_path / 'low.svg', plot_stability_map, record, highest_hz=2000.0)
    assert marks(low) == ((record.kinds == 'flutter') & (record.frequencies_hz <= 2000.0)).sum()
    stable = drawn(tmp_path / 'none.svg', plot_stability_map, sweep(
        PAIR, POINT, {'friction': [0.0, 0.1]}))
    assert marks(stable) == 0


def test_a_map_hides_no_flutter_and_no_divergence(tmp_path: Path) -> None:
    high = replace(PAIR, angular_frequencies=[9e4, 9.002e4])
    record = sweep(high, POINT, {'friction': [0.0, 0.9, 1.0]})
    assert (record.kinds == 'flutter').sum() == 2
    assert record.frequencies_hz.min() > 14000.0
    svg = drawn(tmp_path / 'high.svg', plot_stability_map, record)
    assert marks(svg) == 2
    assert 'divergence' not in svg
    sliding = BrakeModel(angular_frequencies=[0.0, 1e4], negative_slope=np.diag([1e-3, 0.0]))
    svg = drawn(tmp_path / 'slide.svg', plot_stability_map, sweep(
        sliding, POINT, {'friction_slope': [-0.1, 0.0]}))
    assert 'divergence' in svg


def test_pictures_say_what_was_held(tmp_path: Path) -> None:
    """And nothing that goes without saying."""
    plain = conditions(sweep(PAIR, POINT, {'rotor_speed': [1.0, 2.0]}))
    assert plain == 'µ = 0.1, p₀ = 1 bar, contact stiffness 10 × 10⁹ N/m³'
    point = replace(POINT, friction_slope=-0.05, contact_stiffness=0.7e10)
    assert conditions(sweep(PAIR, point, {'rotor_speed': [1.0, 2.0]})) == (
        'µ = 0.1, slope = -0.05 s/m, p₀ = 1 bar, contact stiffness 7 × 10⁹ N/m³')
    assert conditions(sweep(PAIR, point, {'rotor_speed': [1.0, 2.0]}), brief=True).endswith(
        'p₀ = 1 bar, stiffness 70%')
    swept = sweep(PAIR, POINT, {'contact_stiffness': [1e10, 2e10]})
    assert 'nominal contact stiffness 10 × 10⁹ N/m³' in conditions(swept)
    assert 'stiffness' not in conditions(swept, brief=True)
    assert 'slope in proportion to µ' in conditions(sweep(PAIR, point, {'friction': [0.1, 0.2]}))


def test_pictures_say_the_brake_pressure_of_a_model_with_a_caliper(kang: BrakeModel) -> None:
    point = replace(at(kang), contact_pressure=kang.contact_pressure(10e5))
    words = f'brake pressure 10 bar (p₀ = {point.contact_pressure / 1e5:.3g} bar)'
    assert words in conditions(sweep(kang, point, {'friction': [0.42]}))
    assert words in point_words(point, brake_pressure(kang, point))
    assert 'brake pressure' not in conditions(
        sweep(kang, point, {'contact_pressure': [point.contact_pressure]}))


def test_contact_stiffness_has_one_unit() -> None:
    """In titles, on axes of operation and design, on the bars of a tornado chart."""
    assert stiffness_words(3.5e10) == '35 × 10⁹ N/m³'
    assert stiffness_words(7.5e8, 2e10) == '0.75 to 20 × 10⁹ N/m³'
    assert point_words(replace(POINT, contact_stiffness=3.5e10)).endswith(
        'contact stiffness 35 × 10⁹ N/m³')
    for name in ('contact_stiffness', 'contact.stiffness_n_m3'):
        values, words = shown_axis(name, np.array([3.5e10]))
        assert words.endswith('stiffness  10⁹ N/m³')
        assert values.tolist() == [35.0]
    assert parameter_label('contact.stiffness_n_m3', 3.5e10, 'N/m^3') == (
        'contact: stiffness, 35 × 10⁹ N/m³')
    assert parameter_label('disc.density_kg_m3', 7150.0, 'kg/m^3') == 'disc: density, 7150 kg/m³'


def test_map_of_growth(tmp_path: Path) -> None:
    values = {'rotor_speed': [2.0, 5.0, 8.0], 'friction': FRICTIONS}
    svg = drawn(tmp_path / 'a.svg', plot_growth_map, sweep(PAIR, POINT, values))
    assert 'ContourSet' in svg or 'PathCollection' in svg  # the line of zero growth
    for text in ('rotor speed  rad/s', 'friction coefficient', 'largest growth rate'):
        assert text in svg
    assert 'p₀ = 1 bar, contact stiffness 10 × 10⁹ N/m³' in svg
    values['friction'] = [0.4, 0.6]  # all grow
    svg = drawn(tmp_path / 'b.svg', plot_growth_map, sweep(PAIR, POINT, values))
    assert 'ContourSet' not in svg
    assert 'PathCollection' not in svg


def test_loci(tmp_path: Path) -> None:
    values = {'friction': np.linspace(0.0, 0.5, 6)}
    one, other = (sweep(PAIR, POINT, values, tracked=True, rotation=r) for r in (True, False))
    svg = drawn(tmp_path / 'a.svg', lambda path, **k: plot_loci(one, (1, 2), path, **k),
                without=other, title='Fig. 12')
    for text in ('mode 1', 'mode 2, without rotation', 'Re λ  1/s', 'Fig. 12', 'stroke-dasharray'):
        assert text in svg
    # of a merged pair no picture says which is which, and the legend says so once
    assert len(re.findall('>merged 1/2<', svg)) == 1
    alone = drawn(tmp_path / 'b.svg', lambda path: plot_loci(one, (1,), path))
    assert 'without rotation' not in alone
    assert 'mode 2' not in alone


def test_growth_rates_over_speed(kang: BrakeModel, tmp_path: Path) -> None:
    """Modes that flutter somewhere, and divergence in a panel of its own."""
    record = sweep(kang, at(kang), {'rotor_speed': [3.0, 5.0, 10.0]}, friction_law=True,
                   tracked=True)
    svg = drawn(tmp_path / 'a.svg', plot_growth_rates, record)
    legend = re.findall(r'>(\d+): (\d+) Hz<', svg)
    assert [number for number, _ in legend] == ['12', '13', '18', '26']
    assert float(legend[0][1]) == pytest.approx(1363.0, abs=3.0)
    assert 'divergence  1/s' in svg
    assert 'friction by its law of speed' in svg
    plain = drawn(tmp_path / 'b.svg', plot_growth_rates, sweep(
        PAIR, POINT, {'friction': FRICTIONS}, tracked=True))
    assert 'divergence' not in plain
    assert re.findall(r'>(\S+): \d+ Hz<', plain) == ['1/2']  # a merged pair is one


def test_a_part_can_be_drawn(tmp_path: Path) -> None:
    record = interrupted(5, tracked=True)
    for name, plot in (('map', plot_stability_map), ('rates', plot_growth_rates)):
        assert '5 of 20 points' in drawn(tmp_path / f'{name}.svg', plot, record)
    plot_growth_map(sweep(PAIR, POINT, {'rotor_speed': [2.0, 5.0], 'friction': [0.1]}),
                    tmp_path / 'line.png')
    assert (tmp_path / 'line.png').read_bytes().startswith(b'\x89PNG')


def test_a_frequency_axis_that_ends_says_so(kang: BrakeModel, tmp_path: Path) -> None:
    record = sweep(kang, at(kang), {'friction': [0.0]})  # whose modes go beyond 8 kHz
    svg = drawn(tmp_path / 'map.svg', plot_stability_map, record)
    assert 'shownto8kHz(nothingunstableabove)' in re.sub(r'\s', '', svg)
    assert shown_to(record, record.frequencies_hz.max()) == ''
    growing = sweep(PAIR, POINT, {'friction': [0.5]})
    assert shown_to(growing, 1000.0) == ', shown to 1 kHz (some unstable above)'


def test_a_map_of_few_points_labels_each_of_them(tmp_path: Path) -> None:
    values = {'rotor_speed': [2.0, 5.0, 11.0], 'friction': [0.1, 0.45, 0.6]}
    svg = drawn(tmp_path / 'a.svg', plot_growth_map, sweep(PAIR, POINT, values))
    for one in (2.0, 5.0, 11.0, 0.1, 0.45, 0.6):
        assert f'>{one:g}</text>' in svg


def test_a_title_breaks_between_values_and_not_within() -> None:
    words = 'mode coupling: disc (3,0) 68%, pad 1 roll 7%, kang2009: 20 rad/s, friction 0.42, '
    for length in range(20, 60):
        title = slide_figure('a', f'{length * "x"}, {words}contact stiffness 35 × 10⁹ N/m³')
        lines = title.get_suptitle().split('\n')
        assert lines[1].endswith(',')
        assert 'contact stiffness 35 × 10⁹ N/m³' in lines[2]

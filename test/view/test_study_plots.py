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


"""Pictures of studies over several parameters, and what all pictures say of the load."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.studies.study_record import Study
from support.stability_models import kang_point

pytest.importorskip('matplotlib', reason='needs matplotlib')

from squeal_core.stability.mode_tracking import Identity  # noqa: E402, I100
from squeal_core.studies.point_options import brake_pressure  # noqa: E402
from squeal_core.studies.target_modes import TargetMode  # noqa: E402
from squeal_core.view import slide, tornado  # noqa: E402
from squeal_core.view.comparison_slide import _scale_growth  # noqa: E402
from squeal_core.view.study_labels import wrapped  # noqa: E402
from squeal_core.view.study_plot import plot_study  # noqa: E402
from squeal_ros.cli.compare_commands import _conditions, brake_labels, Given  # noqa: E402


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Return the figures that were drawn."""
    found: list[Any] = []
    monkeypatch.setattr(slide, 'save_figure', lambda figure, *_, **__: found.append(figure))
    return found


def texts(figure: Any) -> str:
    return '\n'.join([figure.get_suptitle(), *(
        text for panel in figure.axes for text in (
            panel.get_title(loc='center'), panel.get_ylabel()))])


def boundaries(side: str, growth: float) -> Study:
    """Return boundaries on one side of points whose growth rate has one sign."""
    axes = {name: np.array([1.0, 2.0]) for name in ('rotor_speed', 'damping_scale', 'friction')}
    columns = {name: np.full(8, np.nan) for name in ('below', 'above')}
    columns |= {side: np.linspace(0.1, 0.8, 8), 'growth_rate': np.full(8, growth),
                'source': np.ones(8)}
    return Study(axes=axes, columns=columns, about={
        'task': 'critical', 'parameter': 'friction_slope', 'brake': '', 'point': {},
        'friction_law': False, 'rotation': True})


@pytest.mark.parametrize(('side', 'growth', 'words'), [
    ('above', -1.0, 'lowest'), ('below', -1.0, 'highest'), ('above', 1.0, 'highest'),
    ('below', 1.0, 'lowest')])
def test_the_worst_boundary_is_next_to_a_stable_point_and_far_from_an_unstable_one(
        side: str, growth: float, words: str, figures: list[Any]) -> None:
    plot_study(boundaries(side, growth), 'a.png')
    assert f'the {words} over all others' in texts(figures[0])
    first = figures[0].axes[3].collections[0].get_array()  # below the diagonal
    whole = np.linspace(0.1, 0.8, 8).reshape(2, 2, 2)
    worst = {'lowest': np.min, 'highest': np.max}[words](whole, axis=2).T
    np.testing.assert_allclose(first, worst)


def test_line_styles_are_explained_where_each_is_of_one_place(figures: list[Any]) -> None:
    for count, words in ((2, ['1, 10', '1, 20', '2, 10', '2, 20']), (3, [])):
        axes = {'friction': [0.1, 0.2], 'rotor_speed': [3.0, 5.0], 'damping_scale': [1.0, 2.0],
                'contact_stiffness': np.linspace(1e10, 2e10, count)}
        size = 8 * count
        figure = {f'{name}_1': np.ones(size) for name in ('growth_rate', 'frequency_hz')}
        plot_study(Study(axes={name: np.array(values) for name, values in axes.items()},
                         columns={**figure, 'source': np.ones(size)}, about={
            'task': 'locus', 'numbers': [1], 'brake': '', 'point': {}, 'friction_law': False,
            'rotation': True}), 'a.png')
        legends = {legend.get_title().get_text(): [text.get_text() for text in legend.get_texts()]
                   for legend in figures[-1].legends}
        styles = 'damping scale, contact stiffness  10⁹ N/m³'
        assert legends.get(styles, []) == words
        assert (f'(6 lines each, of {styles}; their styles repeat)' in str(legends)) == (not words)


def test_labels_beside_small_panels_are_broken() -> None:
    assert wrapped('friction coefficient') == 'friction\ncoefficient'
    assert wrapped('disc: hat wall outer radius  mm') == 'disc:\nhat wall outer\nradius\nmm'
    assert wrapped('damping scale') == 'damping scale'


def load(model: BrakeModel) -> str:
    """Return what a picture of this brake is to say."""
    point = kang_point(model, 5.0)
    contact = f'p₀ = {point.contact_pressure / 1e5:.3g} bar'
    return f'brake pressure {brake_pressure(model, point) / 1e5:.3g} bar ({contact})'


def test_a_comparison_says_the_brake_pressure(kang: BrakeModel) -> None:
    point = kang_point(kang, 5.0)
    given = [Given('a', kang), Given('b', kang)]
    words = _conditions(given, [point, point])
    assert load(kang) in words
    other = kang_point(kang, 7.0)
    assert _conditions(given, [point, other]) == (
        f'a: {words}; others at their own friction, pressure and stiffness')


@pytest.mark.parametrize(('unstable', 'texts'), [
    (38.0, ['−1000', '−100', '0', '20', '40']), (20.0, ['−1000', '−100', '−20', '0', '10', '20']),
    (-5.0, ['−1000', '−100', '−10', '0', '5', '10'])])
def test_ticks_of_growth_rates_are_apart(unstable: float, texts: list[str]) -> None:
    axes = slide.Figure().subplots()
    axes.plot([-1500.0, 45.0], [0.0, 1.0])
    _scale_growth(axes, unstable)
    assert [tick.get_text() for tick in axes.get_xticklabels()] == texts


def test_charts_of_what_to_change_say_the_brake_pressure(
        kang: BrakeModel, figures: list[Any]) -> None:
    point = kang_point(kang, 5.0)
    target = TargetMode(Identity((13,)), point, 5.0 + 1e4j, 0.4, 1e4j, ())
    study: Any = SimpleNamespace(variants=SimpleNamespace(model=kang), targets=(target,),
                                 braking=())
    tornado.plot_tornado(study, [], {}, 'a.png')
    assert load(kang) in texts(figures[0])
    mode = SimpleNamespace(identity='13', frequency_hz=1661.0, without=1.0,
                           over_angle=np.array([1.0, 2.0]))
    masses: Any = SimpleNamespace(count=6, mass=5e-3, diameters=3, split=0.01, period=1.0)
    growth: Any = SimpleNamespace(angles=np.array([0.0, 0.5]), modes=(mode,), least_stable=mode)
    tornado.plot_over_angle(masses, growth, point, 'a.png', pressure=brake_pressure(kang, point))
    assert load(kang) in texts(figures[1]).replace('\n', ' ')


def test_a_title_keeps_all_conditions_or_says_that_it_does_not() -> None:
    words = ', '.join(f'condition {number} of a picture' for number in range(12))
    assert slide.slide_figure('a', words).get_suptitle().replace('\n', ' ') == f'a {words}'
    assert slide.slide_figure('a', f'{words}, {words}').get_suptitle().endswith(' …')


def test_brakes_are_named_as_briefly_as_tells_them_apart() -> None:
    for names, labels in (
            (('kang2009', '/a/tables/kang2009.npz', 'x/van.yaml'),
             ['kang2009', 'kang2009.npz', 'van']),
            (('x/a.npz', 'y/a.npz'), ['x/a.npz', 'y/a.npz']), (('a', 'a'), ['a (1)', 'a (2)'])):
        assert brake_labels(names) == labels

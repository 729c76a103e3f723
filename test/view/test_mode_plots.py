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

"""Pictures of modes: the data behind them against closed forms, and the files that come out."""

import base64
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel, complex_modes
from squeal_core.model.surface_shapes import Patch, SurfaceShapes
from squeal_core.stability.mechanism import mechanisms
from squeal_core.studies.sweep import sweep
from squeal_core.studies.unstable_modes import mode_names, unstable_modes
from support.commands import squeal
from support.eigenvalues import companion_roots
from support.stability_models import fluttering, kang_point, POINT

pytest.importorskip('matplotlib', reason='needs matplotlib')

from matplotlib import rc_context  # noqa: E402, I100
from matplotlib.figure import Figure  # noqa: E402
from PIL import Image  # noqa: E402
from squeal_core.view import mode_shape, slide  # noqa: E402
from squeal_core.view.bubble_map import spread  # noqa: E402
from squeal_core.view.contributions import ranked_terms  # noqa: E402
from squeal_core.view.mode_bars import damping_bars, plot_mechanism  # noqa: E402
from squeal_core.view.mode_shape_page import shape_figure, shape_page  # noqa: E402

COUPLE = 6e-3  # m^2/kg: flutter at POINT
RADII, DIAMETERS = (0.1, 0.14), 3


def with_ring(count: int = 16) -> BrakeModel:
    """Return two modes that merge, of a ring: axial shapes cos and sin of three diameters."""
    angle = 2.0 * np.pi * np.arange(count) / count
    points = np.concatenate([np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.0 * angle])
                             for r in RADII])
    shapes = np.zeros((2 * count, 3, 2))
    shapes[:, 2] = np.tile(np.column_stack([np.cos(DIAMETERS * angle),
                                            np.sin(DIAMETERS * angle)]), (2, 1))
    model = fluttering(COUPLE)
    return BrakeModel(
        angular_frequencies=model.angular_frequencies, damping_ratios=model.damping_ratios,
        friction_couple=model.friction_couple, contact_stiffness=model.contact_stiffness,
        names=('disc (3,0)c', 'disc (3,0)s'),
        surface=SurfaceShapes(points, shapes, (Patch('disc', 2, count, True),)))


VECTOR = np.array([1.0, 0.5j])  # cos (3 theta) cos (phase) - 0.5 sin (3 theta) sin (phase)


def test_a_ring_is_drawn_between_its_points_as_its_harmonics_are() -> None:
    view = mode_shape.shape_view(with_ring(), 1j * VECTOR, 'a', 'b')
    (ring,) = view.surfaces
    angle = 2.0 * np.pi * np.arange(48) / 48  # three times as many points
    for phase in (0.0, 0.7):
        points, size = ring.at(phase)
        wave = view.drawn * (np.cos(DIAMETERS * angle) * np.cos(phase)
                             - 0.5 * np.sin(DIAMETERS * angle) * np.sin(phase))
        np.testing.assert_allclose(points[0, :, 0], RADII[0] * np.cos(angle), atol=1e-12)
        np.testing.assert_allclose(points[-1, :, 1], RADII[1] * np.sin(angle), atol=1e-12)
        np.testing.assert_allclose(points[1, :, 2], wave, atol=1e-12)
        np.testing.assert_allclose(size[1], np.abs(wave), atol=1e-12)


def test_the_axis_around_the_disc_holds_the_whole_cycle_and_little_more() -> None:
    view = mode_shape.shape_view(with_ring(), VECTOR, 'a', 'b')
    for part in (1.0, 0.3):  # of what the pads move
        axes = Figure().subplots()
        mode_shape._around(axes, view._replace(drawn=view.drawn / part), 0.5 * np.pi)
        assert axes.get_ylim() == pytest.approx((-1.1 * part, 1.1 * part), rel=1e-3)


def test_numbers_beside_bars_of_a_mechanism_have_room(
        kang: BrakeModel, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the lowest bar ends, at which matplotlib would end the axis."""
    shown: list[Any] = []
    monkeypatch.setattr(slide, 'save_figure', lambda figure, *_, **__: shown.append(figure))
    (why,) = mechanisms(kang, kang_point(kang, 20.0))[:1]
    plot_mechanism(replace(why, contributions={'a': 500.0, 'b': -1000.0, 'c': -20.0}), 'a.png',
                   title='', about='')
    low, high = shown[0].axes[0].get_xlim()
    assert low < -520.0 - 0.1 * (500.0 + 520.0)
    assert high > 500.0 + 0.1 * (500.0 + 520.0)


def test_damping_bars_say_what_the_threshold_is_for(saved: str, tmp_path: Path,
                                                    capsys: pytest.CaptureFixture[str]) -> None:
    with rc_context({'svg.fonttype': 'none'}):
        assert squeal(capsys, 'modes', saved, *AT, '--plot-kind', 'damping', '--threshold', '0.4',
                      '--plot', str(tmp_path / 'a.svg'))[0] == 0
    text = (tmp_path / 'a.svg').read_text(encoding='utf-8')
    for words in ('threshold −0.4 %: unstable modes below it count as squeal',
                  'as Abaqus prints it, −2 Re λ / |Im λ|', 'damping ratio −Re λ / |λ|  %'):
        assert words in text


def unpacked(packed: dict[str, str]) -> Any:
    return np.frombuffer(base64.b64decode(packed['bdata']), f'<{packed["dtype"]}')


def test_the_page_moves_over_one_cycle_and_asks_for_nothing_else() -> None:
    pytest.importorskip('plotly', reason='needs plotly')
    view = mode_shape.shape_view(with_ring(), VECTOR, '</title><script>x', 'b')
    frames = shape_figure(view, moving=True)['frames']
    assert len(frames) == mode_shape.FRAMES
    expected = view.surfaces[0].at(2.0 * np.pi * 3.0 / mode_shape.FRAMES)[0]
    np.testing.assert_allclose(unpacked(frames[3]['data'][0]['z']),
                               1e3 * expected[..., 2].ravel(), atol=1e-5)
    page = shape_page(view, moving=True)
    assert '</title><script>x' not in page
    assert 'src="http' not in page
    assert 'Plotly.addFrames' in page
    assert 'Plotly.addFrames' not in shape_page(view, moving=False).split('Plotly.newPlot')[-1]


def test_damping_bars_are_the_modes_of_the_band_by_frequency() -> None:
    model = with_ring()
    roots = companion_roots(model, POINT)
    roots = roots[roots.imag > 0.0]
    modes = complex_modes(model, POINT).modes
    ratios = sorted(-100.0 * roots.real / np.abs(roots))
    bars = damping_bars(modes, ['1', '2'], -0.9 * ratios[0], (1000.0, 2000.0))
    assert sorted(bar.percent for bar in bars) == pytest.approx(ratios)
    assert [bar.frequency_hz for bar in bars] == sorted(bar.frequency_hz for bar in bars)
    assert {bar.verdict for bar in bars} == {'beyond the threshold', 'stable'}
    bars = damping_bars(modes, ['1', '2'], -1.1 * ratios[0], (1000.0, 2000.0))
    assert {bar.verdict for bar in bars} == {'unstable, within the threshold', 'stable'}
    assert damping_bars(modes, ['1', '2'], 0.5, (2000.0, 3000.0)) == []


def test_mechanism_bars_sum_to_the_growth_rate_of_an_independent_solution(
        kang: BrakeModel) -> None:
    point = kang_point(kang, 20.0)
    roots = companion_roots(kang, point)
    (why,) = mechanisms(kang, point)[:1]
    growth = roots[np.abs(roots - why.mode.eigenvalue).argmin()].real
    terms = ranked_terms(why.contributions)
    # an eigenvalue of 184 states is good to 1e-8 1/s or so
    assert sum(terms.values()) == pytest.approx(growth, abs=1e-5)
    assert ranked_terms({'a': 3.0, 'b': -1.0, 'c': 1e-4, 'd': 2e-4}) == pytest.approx(
        {'a': 3.0, 'b': -1.0, 'others': 3e-4})
    assert 'others' not in ranked_terms({'a': 3.0, 'b': 0.0})


def test_bubbles_are_the_unstable_roots_and_named_by_who_takes_part() -> None:
    model = with_ring()
    record = sweep(model, POINT, {'friction': [0.1, 0.4, 0.6]}, tracked=True)
    found = unstable_modes(model, record)
    assert [mode.place for mode in found] == [1, 2]
    for mode, friction in zip(found, (0.4, 0.6), strict=True):
        roots = companion_roots(model, replace(
            POINT, friction=friction, friction_slope=-0.2 * friction))
        worst = roots[roots.real.argmax()]
        assert mode.growth_rate == pytest.approx(worst.real, rel=1e-9)
        assert mode.damping_ratio == pytest.approx(-worst.real / abs(worst), rel=1e-9)
        assert mode.frequency_hz == pytest.approx(abs(worst.imag) / 2.0 / np.pi, rel=1e-9)
        assert mode.mechanism == 'mode coupling'
    names = mode_names(model, record, found)
    assert set(names) == {mode.identity for mode in found}
    assert all('disc (3,0)' in name for name in names.values())


@pytest.mark.parametrize('heights', [[1.0, 1.01, 1.02, 7.9, 7.95], [0.0] * 40, [8.0] * 3, []])
def test_names_stand_apart_and_inside(heights: list[float]) -> None:
    found = spread(heights, 0.3, 8.0)
    gap = min(0.3, 8.0 / max(len(heights), 1))
    assert all(np.diff(found) >= gap - 1e-9)
    assert all(-1e-9 <= height <= 8.0 + 1e-9 for height in found)


@pytest.fixture
def saved(tmp_path: Path) -> str:
    path = tmp_path / 'ring.npz'
    with_ring().save(path)
    return str(path)


AT = ('--rotor-speed', '7', '--friction', '0.5', '--contact-stiffness', '1e9')


def test_pictures_of_a_slides_size_are_written(
        saved: str, tmp_path: Path, capsys: pytest.CaptureFixture[str],
        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mode_shape, 'FRAMES', 2)
    plot, moving = str(tmp_path / 'a.png'), str(tmp_path / 'a.gif')
    for options in (('--animate', moving), ('--plot-kind', 'damping'),
                    ('--plot-kind', 'mechanism', '--mode', '1')):
        code, _, err = squeal(capsys, 'modes', saved, *AT, '--plot', plot, *options, '--force')
        assert (code, err) == (0, '')
        with Image.open(plot) as picture:
            assert picture.size == (1466, 825)
    with Image.open(moving) as animation:
        assert (animation.n_frames, animation.size) == (2, (1466, 825))
    assert squeal(capsys, 'locus', saved, '--friction', '0.5', '--contact-stiffness', '1e9',
                  '--over', 'friction=0.3:0.5:2', '--plot', plot, '--plot-kind', 'bubbles',
                  '--force')[0] == 0
    assert squeal(capsys, 'compare', saved, saved, *AT, '--plot', plot, '--force')[0] == 0


@pytest.mark.parametrize(('options', 'words'), [
    (('--plot', 'a.png'), 'carries no shapes'),
    (('--animate', 'a.mp4'), '.gif, .html'),
    (('--plot', 'a.html', '--plot-kind', 'damping'), '.png, .svg, .pdf'),
    (('--plot', 'a.png', '--plot-kind', 'mechanism', '--mode', '93'), 'column `mode`'),
    (('--threshold', '0'), 'positive number of per cent')])
def test_what_cannot_be_drawn_is_refused_in_one_line(
        options: tuple[str, ...], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    fluttering(COUPLE).save('bare.npz')
    code, _, err = squeal(capsys, 'modes', 'bare.npz', *AT, *options)
    assert code == 2
    assert words in err
    assert err.count('\n') == 1
    assert [path.name for path in tmp_path.iterdir()] == ['bare.npz']

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

"""The page of `squeal report` in headless Chromium: drawn, hovered, zoomed, printed; offline."""

from collections.abc import Callable, Iterator
from contextlib import suppress
import io
from pathlib import Path
import shutil
from typing import Any

import numpy as np
import pytest
from squeal_core.view.report.page import report_page
from squeal_core.view.report.runs import load_runs
from support.drive_results import SyntheticDrive

playwright = pytest.importorskip('playwright.sync_api', reason='needs playwright')
pdfium = pytest.importorskip('pypdfium2', reason='needs pypdfium2, beside playwright')
images = pytest.importorskip('matplotlib.image', reason='needs matplotlib')
CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser')
if not CHROMIUM:
    pytest.skip('needs Chromium (Debian: apt install chromium)', allow_module_level=True)

TIMEOUT = 120e3  # ms, on a busy machine, too
NASTY = '"><img src=x onerror=alert(1)>'
# in a container /dev/shm may be too small for a page
FLAGS = ('--no-sandbox', '--disable-gpu', '--disable-background-networking',
         '--disable-dev-shm-usage')


class Opened:
    """A page in the browser, and all that its console said and its scripts asked for."""

    def __init__(self, browser: Any, path: Path, scheme: str) -> None:
        self.context = browser.new_context(color_scheme=scheme, offline=True,
                                           viewport={'width': 1300, 'height': 8000})  # all in view
        self.page = self.context.new_page()
        self.page.set_default_timeout(TIMEOUT)
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.page.on('console', lambda message: self.errors.append(message.text)
                     if message.type == 'error' else None)
        self.page.on('pageerror', lambda error: self.errors.append(str(error)))
        self.page.on('dialog', lambda dialog: self.errors.append(dialog.message))
        self.page.on('request', lambda request: self.requests.append(request.url))
        self.page.goto(path.as_uri())
        self.page.wait_for_function('document.documentElement.dataset.printable')

    def figures(self) -> list[str]:
        return list(self.page.evaluate(
            "JSON.parse(document.getElementById('figures').textContent).map(one => one.id)"))

    def colours(self) -> dict[str, int]:
        """Return how many colours each figure shows."""
        shot = (255.0 * images.imread(io.BytesIO(self.page.screenshot()))).round()
        pixels = shot[..., :3].astype(int) @ [65536, 256, 1]
        found = {}
        for name in self.figures():
            box = self.page.locator(f'#{name}').bounding_box()
            left, top = round(box['x']), round(box['y'])
            found[name] = len(np.unique(pixels[top:top + round(box['height']),
                                               left:left + round(box['width'])]))
        return found


@pytest.fixture(scope='module')
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as started:
        found = started.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS),
                                        timeout=TIMEOUT)
        yield found
        found.close()


@pytest.fixture(scope='module')
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp('browser')
    drive = SyntheticDrive(90.0, 5.0, brakes=('left', NASTY), name=NASTY).write(folder / 'run')
    page = folder / 'page.html'
    page.write_text(report_page(load_runs([drive])), encoding='utf-8')
    return page


@pytest.fixture(scope='module')
def opened(browser: Any, path: Path) -> Iterator[Opened]:
    found = Opened(browser, path, 'light')
    yield found
    found.context.close()


def test_every_figure_is_drawn_without_a_word_of_the_console(opened: Opened, path: Path) -> None:
    colours = opened.colours()
    assert len(colours) == 13
    assert min(colours.values()) > 20, colours
    assert opened.errors == []
    assert {url for url in opened.requests if not url.startswith(('blob:', 'data:'))} == {
        path.as_uri()}


def test_hover_and_zoom_act_on_all_panels(opened: Opened) -> None:
    page = opened.page
    plot = page.locator('#timeline-0-0')
    box = plot.bounding_box()
    at = [box['x'] + 0.4 * box['width'], box['y'] + 0.45 * box['height']]
    _repeat(page, lambda attempt: page.mouse.move(at[0] + attempt, at[1]),
            "document.querySelectorAll('#timeline-0-0 .hovertext').length > 3")
    whole = _range(page)

    def drag(_: int) -> None:
        page.mouse.move(*at)
        page.mouse.down()
        page.mouse.move(at[0] + 0.2 * box['width'], at[1] + 2.0, steps=5)
        page.mouse.up()

    _repeat(page, drag,
            "document.getElementById('timeline-0-0')._fullLayout.xaxis.range[0] > 1.0")
    zoomed = _range(page)
    assert whole[0] < zoomed[0] < zoomed[1] < whole[1]
    assert 0.2 < (zoomed[1] - zoomed[0]) / (whole[1] - whole[0]) < 0.3
    # one axis of time serves all panels
    assert page.evaluate("Object.keys(document.getElementById('timeline-0-0')._fullLayout)"
                         ".filter(key => key.startsWith('xaxis'))") == ['xaxis']


def test_the_shape_turns(opened: Opened) -> None:
    page = opened.page
    plot = page.locator('#shape-0')
    box = plot.bounding_box()
    eye = "JSON.stringify(document.getElementById('shape-0')._fullLayout.scene.camera.eye)"
    before = page.evaluate(eye)

    def turn(attempt: int) -> None:
        page.mouse.move(box['x'] + 150, box['y'] + 200)
        page.mouse.down()
        page.mouse.move(box['x'] + 250 + attempt, box['y'] + 230, steps=8)
        page.mouse.up()

    _repeat(page, turn, f'{eye} !== {before!r}')


def test_paper_has_every_chart(opened: Opened) -> None:
    document = pdfium.PdfDocument(opened.page.pdf(prefer_css_page_size=True))
    pages = list(document)
    text = '\n'.join(page.get_textpage().get_text_range() for page in pages)
    for words in ('3 to 3.5', 'mean brake pressure bar',
                  'temperature at the start °C', 'rotor speed at the start rad/s',
                  'largest build-up dB above the noise floor', 'largest squeal risk',
                  'recorded time s', 'friction coefficient',
                  'time from the start of the recording', 'contribution to the growth rate',
                  'Shape of the worst mode'):
        assert words in ' '.join(text.split()), words
    pictures = [found for page in pages for found in page.get_objects(
        filter=[pdfium.raw.FPDF_PAGEOBJ_IMAGE], max_depth=9)]
    assert any(min(found.get_px_size()) > 400 for found in pictures)  # the shape
    widths = {page.get_size() for page in pages}
    assert all(width > height for width, height in widths)
    assert _range(opened.page)  # and the page is as it was
    assert opened.page.evaluate("document.getElementById('friction').layout.width") is None


def test_dark_is_followed(opened: Opened) -> None:
    page = opened.page
    colour = "document.getElementById('friction')._fullLayout.font.color"
    light = page.evaluate(colour)
    page.emulate_media(color_scheme='dark')
    page.wait_for_function(f'{colour} !== {light!r}')
    back = page.evaluate('getComputedStyle(document.body).backgroundColor')
    assert max(map(int, back[4:-1].split(','))) < 40
    page.emulate_media(color_scheme='light')
    page.wait_for_function(f'{colour} === {light!r}')


def _repeat(page: Any, act: Callable[[int], None], condition: str) -> None:
    """Act until a condition holds: the page looks at the mouse once a frame, perhaps too late."""
    for attempt in range(20):
        act(attempt)
        with suppress(playwright.TimeoutError):
            page.wait_for_function(condition, timeout=5e3)
            return
    pytest.fail(f'{condition} did not come true')


def _range(page: Any) -> list[float]:
    return list(page.evaluate(
        "document.getElementById('timeline-0-0')._fullLayout.xaxis.range.map(Number)"))

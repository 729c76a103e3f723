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

"""The documentation as a whole: no sentence twice, links, names of the code, a small sample."""

from collections import defaultdict
from pathlib import Path
import re
import tomllib

from markdown_it import MarkdownIt
from markdown_it.token import Token
import pytest
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.history import AssessmentRecord
from squeal_core.monitor.results.squeal_events import SquealEvent
from support.rows import each

ROOT = Path(__file__).parents[2]
DOCS = ROOT / 'docs'
PAGES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted(DOCS.rglob('*.md'))]
LEAST = 9  # words: shorter sentences are headings, captions, commands
PARSER = MarkdownIt().enable('table')


def prose(tokens: list[Token]) -> str:
    """Return the text of paragraphs and cells, code in a line included."""
    return '\n\n'.join(' '.join(child.content for child in token.children or ()
                                if child.type in ('text', 'code_inline'))
                       for token in tokens if token.type == 'inline')


def sentences(page: Path) -> list[str]:
    text = prose(PARSER.parse(page.read_text(encoding='utf-8')))
    parts = re.split(r'(?<=[.!?:;])\s+(?=[A-Z`*])|\n\n', text)
    return [' '.join(re.findall(r'\w+', part.lower())) for part in parts]


def test_no_sentence_is_written_twice() -> None:
    places = defaultdict(list)
    for page in PAGES:
        for sentence in sentences(page):
            if len(sentence.split()) >= LEAST:
                places[sentence].append(page.relative_to(ROOT).as_posix())
    assert len(places) > 1000
    assert {text: where for text, where in places.items() if len(where) > 1} == {}


def test_links_of_pages_outside_the_site_lead_somewhere() -> None:
    for page in (ROOT / 'README.md', ROOT / 'CONTRIBUTING.md'):
        links = re.findall(r'\]\((?!https?:)([^)#]+)', page.read_text(encoding='utf-8'))
        assert [link for link in links if not (ROOT / link).exists()] == []


def test_contributing_names_what_is_there() -> None:
    """Files by their paths or ends of paths, names as they are in the code."""
    code = [path for folder in ('squeal_core', 'squeal_ros', 'squeal_msgs', 'test', 'docs')
            for path in (ROOT / folder).rglob('*') if path.suffix in ('.py', '.md', '.msg')]
    text = ' '.join(path.read_text(encoding='utf-8') for path in code)
    for name in re.findall(r'`([^` ]+)`', (ROOT / 'CONTRIBUTING.md').read_text('utf-8')):
        if '/' in name or name.endswith(('.py', '.md')):
            assert (ROOT / name).exists() or any(
                path.as_posix().endswith(f'/{name}') for path in code) or (
                    ROOT / 'squeal_core' / name).is_dir(), name
        elif re.fullmatch(r'[A-Z_][A-Za-z_]+', name):
            assert re.search(rf'\b{name}\b', text), name


def test_the_example_of_the_python_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    page = (DOCS / 'reference' / 'api.md').read_text(encoding='utf-8')
    example = next(token.content for token in PARSER.parse(page) if token.info == 'python')
    exec(example, {})
    assert 'flutter' in capsys.readouterr().out


def test_messages_name_pages_that_are_there() -> None:
    for folder in ('squeal_core', 'squeal_ros', 'config', 'benchmark', 'examples'):
        for path in (ROOT / folder).rglob('*'):
            if path.suffix in ('.py', '.yaml', '.xml'):
                for name in re.findall(r'docs/[\w/]+\.md', path.read_text(encoding='utf-8')):
                    assert (ROOT / name).exists(), f'{path}: {name}'


@each(('heading', 'columns'), [
    ('The table of ticks', AssessmentRecord._fields), ('Squeal events', SquealEvent._fields),
    ('Brake applications', ApplicationRecord._fields)])
def test_files_of_a_result_have_each_column(heading: str, columns: tuple[str, ...]) -> None:
    """In the first cells of the table under its heading, and no others."""
    page = (DOCS / 'reference' / 'results.md').read_text(encoding='utf-8')
    section = page.partition(f'\n## {heading}\n')[2].partition('\n## ')[0]
    cells = re.findall(r'^\| (`[^|]+) \|', section, re.MULTILINE)
    assert set(re.findall(r'`(\w+)`', ' '.join(cells))) == set(columns)


def test_words_of_calibration_are_in_the_glossary_and_linked() -> None:
    """Those that output and pages use without an explanation of their own."""
    glossary = (DOCS / 'reference' / 'glossary.md').read_text(encoding='utf-8')
    terms = re.findall(r'^\| ([^|]+) \| [^|]', glossary, re.MULTILINE)[1:]
    for term in ('Emulator', 'Ensemble', 'Neper', 'Prior, posterior', 'Shrinkage', 'ECE',
                 'Brier score', 'Matthews coefficient', 'ln damping'):
        assert term in terms
    assert terms == sorted(terms, key=str.casefold)
    for page in ('howto/calibration', 'tutorials/my_recordings', 'reference/comparison'):
        assert 'glossary.md' in (DOCS / f'{page}.md').read_text(encoding='utf-8'), page


def test_extras_that_pages_install_are_there() -> None:
    extras = tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))[
        'project']['optional-dependencies']
    named = [name for page in PAGES for found in re.findall(
        r"-e '?\.\[([\w,]+)\]", page.read_text(encoding='utf-8')) for name in found.split(',')]
    assert {'bags', 'mdf', 'sound', 'report', 'fleet'} <= set(named) <= set(extras)


def test_the_sample_is_small() -> None:
    assert sum(path.stat().st_size for path in (DOCS / 'sample').iterdir()) < 300_000

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

"""The documentation as a whole: no sentence twice, a small sample, links of the README."""

from collections import defaultdict
from pathlib import Path
import re

from markdown_it import MarkdownIt
from markdown_it.token import Token

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


def test_messages_name_pages_that_are_there() -> None:
    for folder in ('squeal_core', 'squeal_ros', 'config', 'benchmark', 'examples'):
        for path in (ROOT / folder).rglob('*'):
            if path.suffix in ('.py', '.yaml', '.xml'):
                for name in re.findall(r'docs/[\w/]+\.md', path.read_text(encoding='utf-8')):
                    assert (ROOT / name).exists(), f'{path}: {name}'


def test_the_sample_is_small() -> None:
    assert sum(path.stat().st_size for path in (DOCS / 'sample').iterdir()) < 300_000

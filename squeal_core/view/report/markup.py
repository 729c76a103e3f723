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

"""HTML from Python: whatever is no markup already is escaped."""

from collections.abc import Iterable, Sequence
import html
import re
from typing import TypeAlias


class Markup(str):
    """Text that is HTML and is not escaped any more."""

    __slots__ = ()


Content: TypeAlias = str | Iterable['Content'] | None

_CONTROLS = re.compile(r'[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]')


def markup(content: Content) -> Markup:
    """Return content as HTML: plain text escaped, parts joined, None left out."""
    if isinstance(content, Markup):
        return content
    if content is None:
        return Markup()
    if isinstance(content, str):
        return Markup(html.escape(printable_text(content)))
    return Markup(''.join(map(markup, content)))


def prose(text: str) -> Markup:
    """Return text in which text between backticks is code."""
    parts = text.split('`')
    if len(parts) % 2 == 0:
        return markup(text)
    return markup([element('code', one) if place % 2 else one
                   for place, one in enumerate(parts)])


def element(tag: str, *content: Content, **attributes: str) -> Markup:
    """Return an element; a trailing _ of an attribute's name is left out, others become '-'."""
    words = ''.join(f' {name.rstrip("_").replace("_", "-")}="{markup(str(value))}"'
                    for name, value in attributes.items())
    return Markup(f'<{tag}{words}>{markup(content)}</{tag}>')


def table(head: Sequence[Content], rows: Iterable[Sequence[Content]], *, caption: str = '',
          numbers_from: int = 1) -> Markup:
    """
    Return a table.

    Parameters
    ----------
    head : sequence of content
        First row.
    rows : iterable of sequences of content
        Cells of the others, the first one a heading.
    caption : str
        Above it.
    numbers_from : int
        Column from which cells are aligned to the right.

    """
    def cell(place: int, content: Content) -> Markup:
        own = {'class_': 'number'} if place >= numbers_from else {}
        return element('td' if place else 'th', content, **own,
                       **({} if place else {'scope': 'row'}))

    return element('div', element(
        'table', element('caption', caption) if caption else None,
        element('thead', element('tr', [element(
            'th', one, scope='col', **({'class_': 'number'} if place >= numbers_from else {}))
            for place, one in enumerate(head)])),
        element('tbody', [element('tr', [cell(*one) for one in enumerate(row)])
                          for row in rows])), class_='table')


def printable_text(text: str) -> str:
    """Return text without control characters and halves of surrogate pairs."""
    return _CONTROLS.sub('\N{REPLACEMENT CHARACTER}', text)


def label(text: str) -> str:
    """Return text for a figure, in which plotly would read tags."""
    return html.escape(printable_text(text), quote=False)

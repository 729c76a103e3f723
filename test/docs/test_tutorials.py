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

"""The tutorials' commands run as a reader types them, and print what the page shows."""

from collections.abc import Iterator
import doctest
import os
from pathlib import Path
import re
import subprocess
import sys

from markdown_it import MarkdownIt
import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / 'docs' / 'tutorials').glob('my_*.md'))
SHOWN = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
END = '=== end of a command: '


def steps(page: str) -> Iterator[tuple[str, str]]:
    """Yield commands with the output that is shown; files that the reader writes as commands."""
    for token in MarkdownIt().parse(page):
        name = re.search(r'^:caption: (\S+)\n', token.content, re.MULTILINE)
        if token.type == 'fence' and token.info == 'console':
            for part in re.split(r'^\$ ', token.content, flags=re.MULTILINE)[1:]:
                command = re.match(r'(?:.*\\\n)*.*\n', part)
                assert command
                yield command[0].rstrip(), part[command.end():]
        elif token.type == 'fence' and token.info.startswith('{code-block}') and name:
            yield f"cat > {name[1]} <<'END'{token.content[name.end() - 1:]}END", ''


def session(commands: list[str], home: Path) -> list[str]:
    """Return what each command of one shell printed; all have to end with 0."""
    script = ''.join(f'{command}\nprintf "\\n{END}%d\\n" "$?"\n' for command in commands)
    variables = {name: value for name, value in os.environ.items()
                 if name not in ('SQUEAL_TABLES', 'XDG_CACHE_HOME')}  # those of the tests
    said = subprocess.run(
        ['bash', '--norc'], input=script, text=True, cwd=ROOT,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env={
            **variables, 'HOME': str(home), 'OPENBLAS_NUM_THREADS': '1', 'COLUMNS': '100',
            'PATH': f'{Path(sys.executable).parent}:{variables["PATH"]}'}).stdout
    parts = re.split(rf'\n?{END}(\d+)\n', said)
    for command, text, code in zip(commands, parts[::2], parts[1::2], strict=False):
        assert code == '0', f'{command}\n{text}'
    assert len(parts) == 2 * len(commands) + 1, said
    return parts[:-1:2]


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.stem)
@pytest.mark.usefixtures('own_domain')
def test_tutorial(page: Path, tmp_path: Path) -> None:
    pytest.importorskip('rclpy', reason='needs rclpy')
    todo = list(steps(page.read_text(encoding='utf-8')))
    assert len(todo) > 5
    printed = session([command for command, _ in todo], tmp_path)
    for (command, shown), text in zip(todo, printed, strict=True):
        if shown:
            assert doctest.OutputChecker().check_output(shown, text, SHOWN), (
                f'$ {command}\nprints\n{text}\nthe page shows\n{shown}')

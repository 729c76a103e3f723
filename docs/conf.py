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

"""Sphinx settings of the documentation; `make docs` builds it."""

from pathlib import Path
import sys

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx
from squeal_core import __version__

sys.path.insert(0, str(Path(__file__).parent / 'extensions'))

project = 'squeal_ros'
author = 'squeal_ros developers'
release = version = __version__
extensions = ['myst_parser', 'brake_keys', 'settings_table', 'sphinx.ext.autodoc',
              'sphinx.ext.napoleon', 'sphinx_argparse_cli', 'sphinx_copybutton']
default_role = 'literal'  # single backticks in docstrings
myst_heading_anchors = 4
myst_enable_extensions = ['attrs_block', 'attrs_inline']

autodoc_typehints = 'none'  # the sections of the docstrings name types, shapes and units
autodoc_member_order = 'bysource'
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_param = napoleon_use_rtype = False  # arguments described together stay so

html_theme = 'furo'
html_title = f'squeal_ros {release}'
html_last_updated_fmt = '%Y-%m-%d'
html_static_path = ['static']
html_css_files = ['wide.css']
html_show_copyright = html_show_sphinx = html_copy_source = False
copybutton_prompt_text = '$ '
copybutton_copy_empty_lines = False


def setup(app: Sphinx) -> None:
    """Let tables of text be shown as they are."""
    app.add_lexer('csv', TextLexer)

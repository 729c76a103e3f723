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

"""The directive `settings`: tables of the monitor's settings, from where the monitor has them."""

from collections.abc import Iterable
import json
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from squeal_core.monitor.setting_specs import input_keys, MONITOR_KEYS, SettingSpec, SIGNALS

_CHANGE = {'tick': 'at the next tick', 'configure': 'when configured', 'start': 'at the start'}


class SettingsTable(SphinxDirective):
    """The settings of the monitor (`monitor`), or of an input (`rotor_speed`, `pressure`, ...)."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the table, each setting with an anchor of its name."""
        chosen = self.arguments[0]
        keys = MONITOR_KEYS if chosen == 'monitor' else input_keys('<brake>', _signal(chosen))
        return self.parse_text_to_nodes('\n'.join(_table(keys)))


def _signal(name: str) -> Any:
    if name not in SIGNALS:
        raise ValueError(f'settings: {name} is no input; give monitor or one of {SIGNALS}')
    return name


def _table(keys: Iterable[SettingSpec]) -> Iterable[str]:
    yield '| key | meaning | unit | range | default | takes effect |'
    yield '|---|---|---|---|---|---|'
    for key in keys:
        cells = (f'`{key.name.rpartition(".")[2]}`', key.meaning.replace('<', '\\<'), key.unit,
                 _range(key), f'`{json.dumps(key.default)}`', _CHANGE[key.change])
        yield '| ' + ' | '.join(cell.replace('|', '\\|') for cell in cells) + ' |'


def _range(key: SettingSpec) -> str:
    if key.choices:
        return ' or '.join(f'`{choice}`' for choice in key.choices)
    if isinstance(key.default, bool):
        return '`true` or `false`'
    if not isinstance(key.default, float) or key.minimum == -key.maximum == float('-inf'):
        return ''
    return f'{key.minimum:g} to {key.maximum:g}' if key.maximum < float('inf') else (
        f'from {key.minimum:g}')


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive('settings', SettingsTable)
    return {'parallel_read_safe': True}

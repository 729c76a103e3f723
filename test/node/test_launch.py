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

"""Launch files: read as text always, loaded where ROS is, their node run as its own process."""

import ast
import importlib.util
from pathlib import Path
import re
import signal
import subprocess
import sys
from typing import Any

import pytest
from squeal_core.monitor.settings import is_built_in, settings_keys
from support.processes import process
import yaml

ROOT = Path(__file__).parents[2]
FILES = {path.name: path for path in sorted((ROOT / 'launch').glob('*.py'))}
MONITOR, REPLAY = 'squeal_monitor.launch.py', 'squeal_replay.launch.py'
TREES = {name: ast.parse(path.read_text(encoding='utf-8')) for name, path in FILES.items()}
# what Jazzy's launch and launch_ros have, of which these files may use
API = {
    'launch': {'LaunchDescription'},
    'launch.actions': {'DeclareLaunchArgument', 'ExecuteProcess', 'IncludeLaunchDescription',
                       'OpaqueFunction', 'Shutdown'},
    'launch.launch_context': {'LaunchContext'},
    'launch.launch_description_entity': {'LaunchDescriptionEntity'},
    'launch.launch_description_sources': {'PythonLaunchDescriptionSource'},
    'launch.substitutions': {'LaunchConfiguration', 'PathJoinSubstitution'},
    'launch_ros.actions': {'LifecycleNode'},
    'launch_ros.parameter_descriptions': {'ParameterValue'},
    'launch_ros.substitutions': {'FindPackageShare'},
}
KEYWORDS = {
    'DeclareLaunchArgument': {'default_value', 'description', 'choices'},
    'ExecuteProcess': {'cmd', 'output', 'on_exit', 'name'},
    'IncludeLaunchDescription': {'launch_arguments'},
    'LifecycleNode': {'package', 'executable', 'name', 'namespace', 'output', 'parameters'},
    'OpaqueFunction': {'function'}, 'ParameterValue': {'value_type'}, 'Shutdown': {'reason'},
}
# options of Jazzy's `ros2 bag play` (rosbag2 0.26), and whether a value follows
PLAY = {'--clock': True, '--rate': True, '--delay': True, '--exclude-regex': True,
        '--disable-keyboard-controls': False}


def calls(name: str, function: str) -> list[ast.Call]:
    """Return the calls of a function in a launch file."""
    return [node for node in ast.walk(TREES[name]) if isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name) and node.func.id == function]


def texts(call: ast.Call) -> dict[str, Any]:
    """Return keywords and first argument (as '') of a call that are constants; else their AST."""
    pairs = {keyword.arg or '**': keyword.value for keyword in call.keywords}
    pairs.update({'': call.args[0]} if call.args else {})
    return {name: value.value if isinstance(value, ast.Constant) else value
            for name, value in pairs.items()}


def declared(name: str) -> dict[str, dict[str, Any]]:
    return {texts(call)['']: texts(call) for call in calls(name, 'DeclareLaunchArgument')}


@pytest.mark.parametrize('name', FILES)
def test_only_what_launch_has_is_used(name: str) -> None:
    compile(FILES[name].read_text(encoding='utf-8'), name, 'exec')
    for node in ast.walk(TREES[name]):
        assert not isinstance(node, ast.Import), 'import names from modules'
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith('launch'):
            assert {alias.name for alias in node.names} <= API[str(node.module)]
    for function, keywords in KEYWORDS.items():
        for call in calls(name, function):
            assert set(texts(call)) - {''} <= keywords


@pytest.mark.parametrize('name', FILES)
def test_every_argument_is_documented_and_used(name: str) -> None:
    assert declared(name)
    for argument, given in declared(name).items():
        assert isinstance(given['description'], str), argument
        assert len(given['description'].split()) > 3, f'{argument}: say more'
    used = {texts(call)[''] for call in calls(name, 'LaunchConfiguration')}
    assert used == set(declared(name))


def test_node_is_what_setup_installs() -> None:
    (call,) = calls(MONITOR, 'LifecycleNode')
    node = texts(call)
    setup = (ROOT / 'setup.py').read_text(encoding='utf-8')
    project = (ROOT / 'pyproject.toml').read_text(encoding='utf-8')
    assert f"{node['executable']} = 'squeal_ros.node.__main__:monitor'" in project
    package = (ROOT / 'package.xml').read_text(encoding='utf-8')
    assert f'<name>{node["package"]}</name>' in package
    for name in ('launch', 'launch_ros', 'ros2launch', 'ros2bag'):
        assert f'<exec_depend>{name}</exec_depend>' in package
    assert re.search(r"glob\('launch/\*\.launch\.py'\)", setup)
    default = declared(MONITOR)['config']['default_value']  # a name in the function
    (joined,) = calls(MONITOR, 'PathJoinSubstitution')
    assert isinstance(default, ast.Name)
    assert isinstance(joined.args[0], ast.List)
    parts = [part.value for part in joined.args[0].elts if isinstance(part, ast.Constant)]
    assert ROOT.joinpath(*parts).is_file()


def test_what_the_launch_file_sets_are_parameters_of_the_node() -> None:
    names = {key.value for node in ast.walk(TREES[MONITOR]) if isinstance(node, ast.Dict)
             for key in node.keys if isinstance(key, ast.Constant)}
    names |= {node.slice.value for node in ast.walk(TREES[MONITOR])
              if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store)
              and isinstance(node.slice, ast.Constant)}
    assert names == {'use_sim_time', 'model'}
    keys = {key.name for key in settings_keys(('fl',))}
    assert all(name in keys or is_built_in(name) for name in names)


def test_player_gives_the_clock_and_no_old_answers() -> None:
    (call,) = calls(REPLAY, 'ExecuteProcess')
    command = texts(call)['cmd'].elts
    words = [word.value if isinstance(word, ast.Constant) else word for word in command]
    assert words[:3] == ['ros2', 'bag', 'play']
    assert isinstance(words[3], ast.Call)  # the bag, before any option
    rest = words[4:]
    while rest:
        option = rest.pop(0)
        if PLAY[option]:
            assert isinstance(rest.pop(0), ast.Call), option
    (include,) = calls(REPLAY, 'IncludeLaunchDescription')
    assert "'use_sim_time': 'true'" in ast.unparse(include)
    (old,) = [ast.literal_eval(node.value) for node in TREES[REPLAY].body
              if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == 'OLD_ANSWERS']
    for topic in ('/squeal_monitor/front_left/squeal_risk', '/car/squeal_monitor/fl/growth_rate',
                  '/diagnostics', '/clock'):
        assert re.fullmatch(old, topic)
        assert re.search(old, topic)
    for topic in ('/joint_states', '/front_left/friction', '/clock_drift', '/my/diagnostics_agg'):
        assert not re.search(old, topic)


@pytest.mark.parametrize('name', FILES)
def test_launch_loads_it(name: str) -> None:
    """The real launch, where ROS is installed: every argument found, with its description."""
    pytest.importorskip('launch_ros', reason='needs ROS 2 (launch is not on PyPI)')
    from launch.launch_description_sources import PythonLaunchDescriptionSource

    from launch import LaunchContext

    source = PythonLaunchDescriptionSource(str(FILES[name]))
    description = source.get_launch_description(LaunchContext())
    arguments = {argument.name: argument.description
                 for argument in description.get_launch_arguments()}
    expected = {**declared(MONITOR), **declared(name)}
    assert set(arguments) == set(expected)
    assert all(arguments[a] == given['description'] for a, given in expected.items())


def start(arguments: list[str]) -> tuple[str, int]:
    """Run the node as launch does until it watches or ends; its words and exit code."""
    with process(['-m', 'squeal_ros.node', '--ros-args', *arguments], stderr=subprocess.PIPE,
                 text=True) as node:
        said = node.stderr.readline()
        if 'watching' in said:
            node.send_signal(signal.SIGTERM)
        said += node.stderr.read()
        return said, node.wait()


@pytest.mark.skipif(importlib.util.find_spec('rclpy') is None, reason='needs rclpy')
@pytest.mark.parametrize(('model', 'words', 'code'), [
    (None, 'watching only', 0), ('nobody', 'nobody', 2)])
def test_node_takes_what_launch_gives_it(model: str | None, words: str, code: int,
                                         tmp_path: Path, own_domain: None) -> None:
    """As launch_ros starts a node: names, the settings, then a file of the other parameters."""
    settings, overrides = tmp_path / 'settings.yaml', tmp_path / 'overrides.yaml'
    settings.write_text(yaml.safe_dump({'/**': {'ros__parameters': {
        'brakes': ['only'], 'model': 'kang2009' if model is None else 'not this one'}}}))
    values = {'use_sim_time': True, **({} if model is None else {'model': model})}
    overrides.write_text(yaml.safe_dump({'/**': {'ros__parameters': values}}))
    said, returned = start(['-r', '__node:=squeal_monitor', '-r', '__ns:=/car',
                            '--params-file', str(settings), '--params-file', str(overrides)])
    assert words in said
    assert returned == code
    assert 'not this one' not in said


def test_settings_that_are_not_there_stop_the_launch(tmp_path: Path,
                                                     monkeypatch: pytest.MonkeyPatch) -> None:
    """The function of the launch file, run with what stands for launch and launch_ros."""
    class Stand:

        def __init__(self, *values: Any, **options: Any) -> None:
            self.values, self.options = values, options

        def perform(self, context: dict[str, str]) -> str:
            return context[self.values[0]]

    for module, names in API.items():
        monkeypatch.setitem(sys.modules, module, type(
            'Module', (), {**dict.fromkeys(names, Stand), '__path__': []}))
    monkeypatch.setitem(sys.modules, 'launch_ros', type('Module', (), {'__path__': []}))
    space: dict[str, Any] = {}
    exec(compile(FILES[MONITOR].read_text(encoding='utf-8'), MONITOR, 'exec'), space)
    settings = tmp_path / 'settings.yaml'
    with pytest.raises(FileNotFoundError, match=r'settings\.yaml: there is no such file; give'):
        space['monitor']({'config': str(settings), 'model': ''})
    settings.write_text('')
    (node,) = space['monitor']({'config': str(settings), 'model': 'mine.npz'})
    assert node.options['executable'] == 'squeal_monitor'
    assert set(node.options['parameters'][1]) == {'use_sim_time', 'model'}

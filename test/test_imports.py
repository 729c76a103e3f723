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

"""Imports run one way, and what is optional is imported only in the leaf that needs it."""

import ast
from collections.abc import Iterator
from pathlib import Path
import re
import subprocess
import sys
from typing import NamedTuple

from support.rows import each

ROOT = Path(__file__).parents[1]

# A package uses only itself and those above it, in the order of the computation.
PACKAGES = (
    'squeal_core.common',
    'squeal_core.brake',
    'squeal_core.vehicle',
    'squeal_core.modes',
    'squeal_core.model',
    'squeal_core.stability',
    'squeal_core.assembly',
    'squeal_core.simulation',
    'squeal_core.surrogate',
    'squeal_core.risk',
    'squeal_core.calibration',
    'squeal_core.studies',
    'squeal_core.verification',
    'squeal_core.monitor.axles',
    'squeal_core.monitor.setting_specs',
    'squeal_core.monitor.brake_settings',
    'squeal_core.monitor.settings',
    'squeal_core.monitor.inputs',
    'squeal_core.monitor',
    'squeal_core.monitor.results',
    'squeal_core.sound',
    'squeal_core.view',
    'squeal_core',
    'squeal_ros.blas',
    'squeal_ros.interrupts',
    'squeal_ros.node',
    'squeal_ros.recordings.signals',
    'squeal_ros.recordings.positions',
    'squeal_ros.recordings.findings',
    'squeal_ros.recordings.recording',
    'squeal_ros.recordings.time_range',
    'squeal_ros.recordings.bags',
    'squeal_ros.recordings.tables',
    'squeal_ros.recordings',
    'squeal_ros.recordings.replay',
    'squeal_ros.recordings.fleet',
    'squeal_ros.cli',
)

# optional packages, and the only modules (or packages of modules) that import them
LEAVES = {
    'lz4': ('squeal_ros.recordings',),
    'rclpy': ('squeal_ros.node.executor', 'squeal_ros.node.parameters', 'squeal_ros.node.ticker',
              'squeal_ros.node.subscriptions', 'squeal_ros.node.publishers',
              'squeal_ros.node.lifecycle_node', 'squeal_ros.node.transitions',
              'squeal_ros.cli.player'),
    'rosbags': ('squeal_ros.recordings',),
    'skfem': ('squeal_core.modes.fe',),
    'yaml': ('squeal_core.common.yaml_reader',),
    'h5py': ('squeal_core.modes.readers.hdf5_tables',),
    'pyNastran': ('squeal_core.modes.readers.nastran_op2',),
    'asammdf': ('squeal_ros.recordings.tables.mdf_file',),
    'dask': ('squeal_ros.recordings.fleet.fleet_engine',),
    'distributed': ('squeal_ros.recordings.fleet.fleet_engine',
                    'squeal_ros.recordings.fleet.fleet_scheduler'),
    'matplotlib': ('squeal_core.view',),
    'mpl_toolkits': ('squeal_core.view',),
    'plotly': ('squeal_core.view',),
    'sklearn': ('squeal_core.calibration.baselines',),
    'rich': ('squeal_core.view',),
    'soundfile': ('squeal_core.sound.other_formats',),
    'pyarrow': ('squeal_core.monitor.results.parquet_table',),
}
ALWAYS_THERE = {'numpy', 'scipy'}
PINNED = ('squeal_ros.node.__main__', 'squeal_ros.node.lifecycle_node', 'squeal_ros.cli.player',
          'squeal_ros.cli.__main__', 'squeal_ros.cli.main')


class Import(NamedTuple):
    """One import: the module it names, and whether it runs as the importing module loads."""

    target: str
    at_load: bool


def imports_in(source: str) -> list[Import]:
    return list(_imports(ast.parse(source), at_load=True))


def _imports(node: ast.AST, *, at_load: bool) -> Iterator[Import]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            yield from (Import(alias.name, at_load) for alias in child.names)
        elif isinstance(child, ast.ImportFrom):
            assert child.level == 0, 'write whole module names'
            yield from (Import(_module(str(child.module), alias.name), at_load)
                        for alias in child.names)
        elif isinstance(child, ast.Call):
            yield from _named(child, at_load=at_load)
        lazy = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        yield from _imports(child, at_load=at_load and not lazy)


def _named(call: ast.Call, *, at_load: bool) -> Iterator[Import]:
    """Yield what `import_module` or `__import__` is told to import, where it is a name."""
    function = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(
        call.func, 'id', '')
    if function in ('import_module', '__import__') and call.args:
        match call.args[0]:
            case ast.Constant(value=str(target)):
                yield Import(target, at_load)


def _module(package: str, name: str) -> str:
    """`from package import name` names a module of ours or what is in the package."""
    return f'{package}.{name}' if f'{package}.{name}' in SOURCES else package


def _name(path: Path) -> str:
    return '.'.join(path.relative_to(ROOT).with_suffix('').parts).removesuffix('.__init__')


SOURCES = {_name(path): path for package in ('squeal_core', 'squeal_ros')
           for path in sorted((ROOT / package).rglob('*.py'))}
IMPORTS = {name: imports_in(path.read_text(encoding='utf-8')) for name, path in SOURCES.items()}


def top(module: str) -> str:
    return module.partition('.')[0]


def within(module: str, package: str) -> bool:
    return f'{module}.'.startswith(f'{package}.')


def is_ros(module: str) -> bool:
    return top(module).startswith('rcl') or top(module).endswith(('_msgs', '_interfaces'))


def leaf_of(target: str) -> str:
    return 'rclpy' if is_ros(target) else top(target)


def package_of(module: str) -> str:
    """Return the package of a module of ours: the longest of PACKAGES that it is within."""
    return max((name for name in PACKAGES if within(module, name)), key=len)


def test_every_package_is_in_the_order() -> None:
    folders = {f'{path.parent.name}.{path.name}' for root in ('squeal_core', 'squeal_ros')
               for path in (ROOT / root).iterdir() if (path / '__init__.py').exists()}
    assert folders == {name for name in PACKAGES if name.count('.') == 1
                       and (ROOT / name.replace('.', '/')).is_dir()}


def test_the_architecture_names_every_package() -> None:
    page = (ROOT / 'docs/explanation/architecture.md').read_text('utf-8')
    named = set(re.findall(r'`(\w+)/?`', page))
    assert {name.rpartition('.')[2] for name in PACKAGES} - named == set()


@each('module', [name for name in SOURCES if name != 'squeal_ros'])
def test_packages_import_only_what_is_above_them(module: str) -> None:
    above = PACKAGES[:PACKAGES.index(package_of(module)) + 1]
    assert [i.target for i in IMPORTS[module] if top(i.target) in ('squeal_core', 'squeal_ros')
            and package_of(i.target) not in above] == []


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph = {module: {i.target for i in imports if i.target in SOURCES}
             for module, imports in IMPORTS.items()}
    while leaves := {name for name, targets in graph.items() if not targets & graph.keys()}:
        graph = {name: targets for name, targets in graph.items() if name not in leaves}
    assert sorted(graph) == []


@each('module', [name for name in SOURCES if within(name, 'squeal_core')])
def test_no_ros_in_the_core(module: str) -> None:
    assert [i.target for i in IMPORTS[module]
            if is_ros(i.target) or top(i.target) == 'squeal_ros'] == []


@each('module', SOURCES)
def test_optional_packages_only_in_their_leaves(module: str) -> None:
    assert [i.target for i in IMPORTS[module] if not any(
        within(module, leaf) for leaf in LEAVES.get(leaf_of(i.target), (module,)))] == []


@each('package', LEAVES)
def test_every_leaf_is_one(package: str) -> None:
    for leaf in LEAVES[package]:
        assert package in {leaf_of(i.target) for name, found in IMPORTS.items()
                           if within(name, leaf) for i in found}


@each('module', [
    name for name in SOURCES if within(name, 'squeal_core')
    and not any(within(name, f'squeal_core.{leaf}')
                for leaf in ('modes.fe', 'modes.readers', 'calibration.baselines',
                             'sound.other_formats', 'monitor.results.parquet_table', 'view'))])
def test_the_core_needs_numpy_and_scipy_only(module: str) -> None:
    foreign = [i for i in IMPORTS[module] if top(i.target) not in {
        *sys.stdlib_module_names, *ALWAYS_THERE, 'squeal_core'}]
    assert {i.target for i in foreign} <= {'yaml'}
    assert not any(i.at_load for i in foreign)


@each('module', PINNED)
def test_blas_is_pinned_before_anything_else(module: str) -> None:
    assert IMPORTS[module][0] == Import('squeal_ros.blas', at_load=True)


@each('action', ['', "; squeal_core.BrakeModel.load('kang2009')",
                 '; import squeal_core.monitor.vehicle_monitor'])
def test_what_the_core_pulls_in(action: str) -> None:
    run = subprocess.run(
        [sys.executable, '-c', f'import sys, squeal_core{action}; print(*sys.modules)'],
        capture_output=True, text=True, check=True)
    loaded = {top(name) for name in run.stdout.split()}
    assert {'numpy', 'squeal_core'} <= loaded
    assert loaded & {'squeal_ros', *LEAVES} == set()


@each(('source', 'target', 'at_load'), [
    ('import rclpy.node', 'rclpy.node', True),
    ('import numpy, skfem', 'skfem', True),
    ('try:\n import rich\nexcept ImportError: pass', 'rich', True),
    ('if True:\n from rosbags import x', 'rosbags', True),
    ('class A:\n import yaml', 'yaml', True),
    ('def f():\n def g():\n  import yaml', 'yaml', False),
    ('class A:\n async def f(self):\n  from yaml import load', 'yaml', False),
    ('importlib.import_module("squeal_core.risk")', 'squeal_core.risk', True),
    ('def f():\n return __import__("yaml")', 'yaml', False),
    ('from squeal_core.common import errors', 'squeal_core.common.errors', True),
    ('from squeal_core import BrakeModel', 'squeal_core', True),
    ('from squeal_core.brake.dimensions import Brake', 'squeal_core.brake.dimensions', True)])
def test_the_walk_finds_imports(source: str, target: str, at_load: bool) -> None:
    assert Import(target, at_load) in imports_in(source)
    assert not is_ros('numpy.linalg')
    assert is_ros('std_msgs.msg')

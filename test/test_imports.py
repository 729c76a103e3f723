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

# A module uses only what stands above it. A new module gets its place here.
ORDER = (
    'squeal_core.arrays',
    'squeal_core.errors',
    'squeal_core.bounded_reader',
    'squeal_core.partial_files',
    'squeal_core.output',
    'squeal_core.npz_archive',
    'squeal_core.axles',
    'squeal_core.resources',
    'squeal_core.steps',
    'squeal_core.workers',
    'squeal_core.yaml_file',
    'squeal_core.ranges',
    'squeal_core.description',
    'squeal_core.friction',
    'squeal_core.brake',
    'squeal_core.brake_quantities',
    'squeal_core.brake_proportions',
    'squeal_core.brake_file',
    'squeal_core.operating_point',
    'squeal_core.modal_basis',
    'squeal_core.surface',
    'squeal_core.nodal_modes',
    'squeal_core.fe',
    'squeal_core.fe.mass',
    'squeal_core.fe.axisymmetric',
    'squeal_core.fe.elements',
    'squeal_core.fe.locate',
    'squeal_core.fe.meshes',
    'squeal_core.fe.mode_cache',
    'squeal_core.fe.polar',
    'squeal_core.fe.mixed',
    'squeal_core.fe.eigen',
    'squeal_core.fe.solid',
    'squeal_core.readers.raw',
    'squeal_core.readers.text',
    'squeal_core.readers.phases',
    'squeal_core.readers.listing',
    'squeal_core.readers.table',
    'squeal_core.readers.unv',
    'squeal_core.readers.frd',
    'squeal_core.readers.hdf5_tables',
    'squeal_core.readers.nastran_h5',
    'squeal_core.readers.nastran_op2',
    'squeal_core.readers.vtu',
    'squeal_core.readers.placing',
    'squeal_core.readers.rigid_modes',
    'squeal_core.readers.normalising',
    'squeal_core.readers',
    'squeal_core.planar_grid',
    'squeal_core.scattered_nodes',
    'squeal_core.planar_layers',
    'squeal_core.planar_mesh',
    'squeal_core.operators',
    'squeal_core.brake_model',
    'squeal_core.model_file',
    'squeal_core.lapack',
    'squeal_core.stability',
    'squeal_core.mode_vectors',
    'squeal_core.tracking',
    'squeal_core.mechanism',
    'squeal_core.sensitivity',
    'squeal_core.critical',
    'squeal_core.merging',
    'squeal_core.audit',
    'squeal_core.component',
    'squeal_core.build',
    'squeal_core.monomials',
    'squeal_core.coupling_floor',
    'squeal_core.block_series',
    'squeal_core.encounters',
    'squeal_core.anchor',
    'squeal_core.block_recursion',
    'squeal_core.anchor_solution',
    'squeal_core.table_file',
    'squeal_core.anchor_table',
    'squeal_core.neighbours',
    'squeal_core.anchor_requests',
    'squeal_core.tabulation',
    'squeal_core.envelope',
    'squeal_core.batch',
    'squeal_core.risk',
    'squeal_core.risk_rule',
    'squeal_core.risk_cell',
    'squeal_core.risk_cell_making',
    'squeal_core.cell_table',
    'squeal_core.risk_estimate',
    'squeal_core.risk_table',
    'squeal_core.margin',
    'squeal_core.margin_search',
    'squeal_core.settings',
    'squeal_core.settings_document',
    'squeal_core.plausibility',
    'squeal_core.publishers',
    'squeal_core.stuck',
    'squeal_core.onset',
    'squeal_core.engines',
    'squeal_core.sliding',
    'squeal_core.inputs',
    'squeal_core.alarm',
    'squeal_core.assessment',
    'squeal_core.signal_windows',
    'squeal_core.cross_evidence',
    'squeal_core.cross_motion',
    'squeal_core.cross_pressure',
    'squeal_core.cross_speed',
    'squeal_core.cross_friction',
    'squeal_core.cross_checks',
    'squeal_core.monitor',
    'squeal_core.history',
    'squeal_core.drive_summary',
    'squeal_core.drive_envelope',
    'squeal_core.sweep_record',
    'squeal_core.sweep',
    'squeal_core.verification.paper',
    'squeal_core.verification.row',
    'squeal_core.verification.case',
    'squeal_core.verification.parts',
    'squeal_core.verification.claims',
    'squeal_core.verification.friction_claims',
    'squeal_core.verification.speed_claims',
    'squeal_core.verification',
    'squeal_core.drive_cycle',
    'squeal_core.vehicle',
    'squeal_core',
    'squeal_core.view',
    'squeal_core.view.saving',
    'squeal_core.view.drive_plot',
    'squeal_core.view.stability_map',
    'squeal_core.view.locus_plot',
    'squeal_core.view.verification_shapes',
    'squeal_core.view.verification_figures',
    'squeal_core.view.engine_plot',
    'squeal_core.view.mesh_convergence',
    'squeal_core.view.table',
    'squeal_ros',
    'squeal_ros.blas',
    'squeal_ros.model_info',
    'squeal_ros.interrupts',
    'squeal_ros.monitor_options',
    'squeal_ros.signals',
    'squeal_ros.messages',
    'squeal_ros.field_check',
    'squeal_ros.policy',
    'squeal_ros.message_types',
    'squeal_ros.grid',
    'squeal_ros.health',
    'squeal_ros.silence',
    'squeal_ros.guards',
    'squeal_ros.parameters',
    'squeal_ros.mode_shapes',
    'squeal_ros.ticker',
    'squeal_ros.input_topics',
    'squeal_ros.output_topics',
    'squeal_ros.reporting',
    'squeal_ros.node',
    'squeal_ros.findings',
    'squeal_ros.bag_bounds',
    'squeal_ros.message_definitions',
    'squeal_ros.bag_reader',
    'squeal_ros.bag',
    'squeal_ros.replay',
    'squeal_ros.replay_report',
    'squeal_ros.drive',
    'squeal_ros.agreement',
    'squeal_ros.demo',
    'squeal_ros.console',
    'squeal_ros.listing',
    'squeal_ros.options',
    'squeal_ros.point_checks',
    'squeal_ros.commands',
    'squeal_ros.tables',
    'squeal_ros.analysis',
    'squeal_ros.cli',
    'squeal_ros.start',
)
# the one import that points up: `BrakeModel.load` and `.save`, inside the functions
UPWARD = {('squeal_core.brake_model', 'squeal_core.model_file')}

# optional packages, and the only modules (or packages of modules) that import them
LEAVES = {
    'lz4': ('squeal_ros.bag_bounds',),
    'rclpy': ('squeal_ros.guards', 'squeal_ros.parameters', 'squeal_ros.ticker',
              'squeal_ros.input_topics', 'squeal_ros.output_topics', 'squeal_ros.node',
              'squeal_ros.drive'),
    'rosbags': ('squeal_ros.bag_bounds', 'squeal_ros.message_definitions',
                'squeal_ros.bag_reader', 'squeal_ros.bag'),
    'skfem': ('squeal_core.fe',),
    'yaml': ('squeal_core.yaml_file',),
    'h5py': ('squeal_core.readers.hdf5_tables',),
    'pyNastran': ('squeal_core.readers.nastran_op2',),
    'matplotlib': ('squeal_core.view',),
    'rich': ('squeal_core.view',),
}
ALWAYS_THERE = {'numpy', 'scipy'}
PINNED = ('squeal_ros.node', 'squeal_ros.drive', 'squeal_ros.cli', 'squeal_ros.start')


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
        lazy = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        yield from _imports(child, at_load=at_load and not lazy)


def _module(package: str, name: str) -> str:
    """`from package import name` names a module of ours or what is in the package."""
    return f'{package}.{name}' if f'{package}.{name}' in ORDER else package


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


def test_every_module_has_its_place_in_the_order() -> None:
    assert sorted(SOURCES) == sorted(ORDER)


def test_the_architecture_names_every_module() -> None:
    named = set(re.findall(r'`(\w+)/?`', (ROOT / 'docs/architecture.md').read_text('utf-8')))
    rooms = {name.split('.')[1] for name in SOURCES if '.' in name}  # packages are named whole
    assert rooms - named == set()


@each('module', SOURCES)
def test_imports_run_one_way(module: str) -> None:
    ours = [i for i in IMPORTS[module] if top(i.target) in ('squeal_core', 'squeal_ros')]
    above = ORDER[:ORDER.index(module)]
    assert [i.target for i in ours if i.target not in above
            and (i.at_load or (module, i.target) not in UPWARD)] == []


def test_the_import_that_points_up_is_lazy_and_needed() -> None:
    for module, target in UPWARD:
        assert {i.at_load for i in IMPORTS[module] if i.target == target} == {False}


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
    and not any(within(name, f'squeal_core.{leaf}') for leaf in ('fe', 'readers', 'view'))])
def test_the_core_needs_numpy_and_scipy_only(module: str) -> None:
    foreign = [i for i in IMPORTS[module] if top(i.target) not in {
        *sys.stdlib_module_names, *ALWAYS_THERE, 'squeal_core'}]
    assert {i.target for i in foreign} <= {'yaml'}
    assert not any(i.at_load for i in foreign)


@each('module', PINNED)
def test_blas_is_pinned_before_anything_else(module: str) -> None:
    assert IMPORTS[module][0] == Import('squeal_ros.blas', at_load=True)


@each('action', ['', "; squeal_core.BrakeModel.load('kang2009')",
                 '; import squeal_core.monitor'])
def test_what_the_core_pulls_in(action: str) -> None:
    run = subprocess.run(
        [sys.executable, '-c', f'import sys, squeal_core{action}; print(*sys.modules)'],
        capture_output=True, text=True, check=True, timeout=600)
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
    ('from squeal_core import vehicle', 'squeal_core.vehicle', True),
    ('from squeal_core import BrakeModel', 'squeal_core', True),
    ('from squeal_core.brake import Brake', 'squeal_core.brake', True)])
def test_the_walk_finds_imports(source: str, target: str, at_load: bool) -> None:
    assert Import(target, at_load) in imports_in(source)
    assert not is_ros('numpy.linalg')
    assert is_ros('std_msgs.msg')

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

"""What is installed, from what, and with which licence: metadata, source archive, headers."""

import ast
from importlib import metadata
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))['project']
EXTRAS: dict[str, list[str]] = PROJECT['optional-dependencies']
CODE = ('squeal_core', 'squeal_ros', 'test', 'launch', 'benchmark', 'examples', 'docs')
FOLDERS = (*CODE, 'config', 'resource', 'squeal_msgs')
SOURCES = [ROOT / 'setup.py', *(path for folder in CODE
                                for path in sorted((ROOT / folder).rglob('*.py')))]
LEFT_OUT = re.compile(r'(^|/)(__pycache__|\.[^/]*|[^/]*\.egg-info)(/|$)|\.py[cod]$')
HEADER = """# Copyright 2026 squeal_ros developers
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
"""


def required(extra: str) -> set[str]:
    """Return the names of what an extra brings, those of extras within it too."""
    names: set[str] = set()
    for requirement in EXTRAS[extra]:
        own = re.fullmatch(r'squeal_ros\[(.+)\]', requirement)
        if own:
            names.update(*(required(part) for part in own[1].split(',')))
        else:
            names.add(re.split(r'[\[<>=]', requirement)[0])
    return names


def test_metadata_are_those_of_pep_621() -> None:
    assert {'name', 'description', 'readme', 'license', 'authors', 'maintainers', 'keywords',
            'classifiers', 'urls', 'dependencies', 'scripts'} <= PROJECT.keys()
    assert 'License :: OSI Approved :: Apache Software License' in PROJECT['classifiers']
    assert {'Homepage', 'Source', 'Issues'} <= PROJECT['urls'].keys()
    python = {text.rpartition(' ')[2] for text in PROJECT['classifiers'] if '3.1' in text}
    assert python == {'3.11', '3.12', '3.13', '3.14'}


def test_the_vehicle_needs_three_packages_and_each_has_bounds() -> None:
    assert [re.split('[<>=]', text)[0] for text in PROJECT['dependencies']] == [
        'numpy', 'scipy', 'PyYAML']
    bounded = re.compile(r'[A-Za-z0-9_.\[\]-]+>=[\d.]+(,<\d+)?')
    for requirement in (*PROJECT['dependencies'], *EXTRAS['ros'], *EXTRAS['fe'], *EXTRAS['bags'],
                        *EXTRAS['view'], *EXTRAS['test']):
        assert bounded.fullmatch(requirement), requirement


def test_all_brings_no_tools_of_developers() -> None:
    assert required('all') == set().union(*map(required, (
        'ros', 'readers', 'bags', 'mdf', 'calibration', 'sound', 'parquet', 'fleet',
        'view', 'report')))
    assert not required('all') & (required('test') | required('lint') | required('colcon'))
    assert 'pyNastran' not in required('all')


def test_nothing_of_setuptools_is_imported_when_it_runs() -> None:
    for path in SOURCES:
        if path.is_relative_to(ROOT / 'squeal_core') or path.is_relative_to(ROOT / 'squeal_ros'):
            names = {name.partition('.')[0] for node in ast.walk(ast.parse(path.read_bytes()))
                     for name in ([a.name for a in node.names] if isinstance(node, ast.Import)
                                  else [node.module or ''] if isinstance(node, ast.ImportFrom)
                                  else [])}
            assert not names & {'setuptools', 'pkg_resources', 'distutils'}, path


def test_squeal_msgs_is_built_with_what_the_extra_brings() -> None:
    own = tomllib.loads((ROOT / 'squeal_msgs' / 'pyproject.toml').read_text(encoding='utf-8'))
    wanted = {re.split(r'[\[<>=]', text)[0] for text in own['build-system']['requires']}
    assert wanted | {'cmake'} == required('ros') | required('msgs')
    package = ElementTree.parse(ROOT / 'squeal_msgs' / 'package.xml').getroot()
    assert package.findtext('version') == own['project']['version']


def test_package_xml_names_what_tests_need() -> None:
    package = ElementTree.parse(ROOT / 'package.xml').getroot()
    assert {item.text for item in package.iter('test_depend')} >= {
        'ament_copyright', 'ament_flake8', 'ament_pep257', 'python3-hypothesis', 'python3-pytest',
        'python3-pytest-timeout'}
    assert {item.text for item in package.iter('exec_depend')} >= {
        'python3-numpy', 'python3-scipy', 'python3-yaml', 'rclpy'}


def test_every_file_has_the_licence_header() -> None:
    without = [str(path.relative_to(ROOT)) for path in SOURCES
               if not path.read_text(encoding='utf-8').startswith(f'{HEADER}\n')
               and path.stat().st_size]
    assert without == []


def test_the_source_archive_is_whole(tmp_path: Path) -> None:
    pytest.importorskip('setuptools')
    source = tmp_path / 'source'
    shutil.copytree(ROOT, source, ignore=shutil.ignore_patterns(
        '.git', '.venv*', '__pycache__', '*.egg-info', 'build', 'install', 'log', 'demo_output',
        '.*_cache', '.hypothesis'))
    code = f'from setuptools import build_meta; build_meta.build_sdist({str(tmp_path)!r})'
    subprocess.run([sys.executable, '-c', code], cwd=source, check=True, capture_output=True)
    (archive,) = tmp_path.glob('*.tar.gz')
    with tarfile.open(archive) as packed:
        there = {name.partition('/')[2] for name in packed.getnames()}
    wanted = {str(path.relative_to(source)) for path in source.rglob('*') if path.is_file()}
    wanted = {name for name in wanted if name.partition('/')[0] in FOLDERS or '/' not in name}
    assert {name for name in wanted if not LEFT_OUT.search(name)} - there == set()
    assert {'.ci/run', 'config/models/kang2009.npz', 'resource/squeal_ros', 'Makefile'} <= there
    assert not [name for name in there if '__pycache__' in name]


def test_what_is_installed_says_the_same() -> None:
    try:
        found = metadata.distribution('squeal_ros')
    except metadata.PackageNotFoundError:
        pytest.skip('not installed here')
    commands = {entry.name for entry in found.entry_points if entry.group == 'console_scripts'}
    assert commands == {'squeal', 'squeal_monitor'}


@pytest.mark.skipif('AMENT_PREFIX_PATH' not in os.environ, reason='`make lint` runs them')
@pytest.mark.parametrize('linter', ['copyright', 'flake8', 'pep257'])
def test_linters_of_ament(linter: str) -> None:
    main = pytest.importorskip(f'ament_{linter}.main')
    assert main.main(argv=[str(path) for path in SOURCES]) == 0

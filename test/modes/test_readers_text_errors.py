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

"""What each text format says of a change in a sample: message, line, remedy."""

from pathlib import Path
import re

import pytest
from support.reader_samples import options, refusal, write_sample

NODE_10, NODE_13 = f'{10:10d}', f'{13:10d}'


def altered(name: str, folder: Path, old: str, new: str, count: int = 1) -> str:
    """Return what a sample gives after a change of its text, which must be found in it."""
    path = write_sample(name, folder)
    text = path.read_text()
    found = re.sub(old, new, text, count=count, flags=re.MULTILINE)
    assert found != text
    path.write_text(found)
    return refusal(path, **options(name))


@pytest.mark.parametrize(('old', 'new', 'message'), [
    (r'^    -1\n\Z', '', r'line \d+: begins a dataset that has no end, or ends one that'),
    (r'^    -1\n    -1\n', '', r'line \d+: '),
    (rf'^{NODE_10} {{9}}1', f'{NODE_10}{2:10d}',
     'dataset 2411 at line 9: gives node 10 in coordinate systems 2 and 1; the global Cartesian'),
    (r'^( +1 +)2( +3 +8 +)2', r'\g<1>3\g<2>5', r'line \d+: has complex modes \(analysis type 3,'),
    (r'^( +1 +2 +3 +8 +)2', r'\g<1>1', r'has data type 1, not real or complex numbers'),
    (r'^( +1 +2 +3 +8 +)2', r'\g<1>5', r'ends dataset 55 in the middle of a node'),
    (r'^( +1 +2 +)3( +8 +2 +6)', r'\g<1>2\g<2>', 'has 6 values a node of data characteristic 2'),
    (r'^  2411', '  2410', r'^holds no nodes \(dataset 15 or 2411\); export the nodes as well'),
    (r'^  2412', '  2411', r'line \d+: '),
    (r' 116 ', ' 117 ', 'has an element of descriptor 117 with 20 nodes, which is not known; mes'),
    (r'^( +1 +116 .*)20$', r'\g<1>16', 'has an element of descriptor 116 with 16 nodes'),
    (r' 1\.0000000000000000E\+03', ' 1.0000000000000000E+00',
     "says that its lengths are in units of 1 m, but length_unit is 'mm'; give the unit of"),
    (r' 1\.0000000000000000E\+03', ' 0.0000000000000000E+00', 'gives 0.0 units of length to a m'),
    (rf'^{NODE_13}$', NODE_10, r'^dataset 55 at line \d+: names node 10 2 times; export one comp'),
    (rf'^{NODE_13}$', f'{99999:10d}', 'moves node 99999, which dataset 2411 at line 9 does'),
    (rf'^{NODE_13}\n.*\n', '', r'has a hex20 with node 13, which no mode moves|moves 89 nodes'),
    (r'E\+01 ', 'E+0x ', r"^line \d+: has ' .*E\+0x' in columns \d+ to \d+, not a number; export"),
])
def test_universal_files(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert re.search(message, altered('unv', tmp_path, old, new))


def test_elements_in_another_order(tmp_path: Path) -> None:
    """Corners first, as many a script writes them: the file reads well, and means nonsense."""
    text = altered('unv', tmp_path, r'(?<= 20\n)(.{10})(.{10})(.{10})', r'\1\3\2')
    assert re.match(r'has a hex20 with node \d+ in the place of the middle between nodes \d+ and '
                    r'\d+, but far from it; export elements in the order of the format', text)


def test_universal_file_without_modes(tmp_path: Path) -> None:
    for old, new in (('^    55$', '    56'), ('( 1 +)2( +3 +8 )', r'\g<1>1\2')):
        assert 'holds no real normal modes; export' in altered('unv', tmp_path, old, new, 0)


@pytest.mark.parametrize(('old', 'new', 'message'), [
    (r'\n 9999\n', '\n', r'^line \d+: is the last line, but the file is not complete; it was cut'),
    (r'^(    2C.*)1$', r'\g<1>2', r"^line 12: has format '2'; 1, the long ASCII one, is read"),
    (r'^(    2C +)89', r'\g<1>90', r"line 102: is ' -3', not one of the 90 rows of the block abo"),
    (r'^(    2C +)89', r'\g<1>88', r"line 101: is ' -1 .*', not one of the 88 rows of the block"),
    (r'^(    3C +)8 ', r'\g<1>9 ', r"line \d+: is ' -3', not one of the 9 elements of its block"),
    (r'^(    3C +)8 ', r'\g<1>7 ', r'line \d+: is .*, not the end of a block of 7 elements'),
    (r'^( -1         1 )   4', r'\g<1>  40', 'has an element of type 40, which is not known; mes'),
    (r'^ -2', ' -7', r"line \d+: is ' -7.*, not a line of nodes of an element"),
    (r'    2C', '    5C', r'holds no nodes \(no block 2C\); run CalculiX with \*NODE FILE'),
    (r'(?s)(    2C.*?\n -3\n)', r'\1\1', r'line \d+: begins a second block of nodes; give the'),
    (r'^ -1 {8}13', ' -1        14', r'line 12: names node 14 2 times; export one component, eac'),
    (r'1\.10000E\+01$', '1.1x000E+01', r"has ' 1.1x000E\+01' in columns 38 to 49, not a number"),
    (r'1\.10000E\+01$', '        nan', r'line 12: has \[.*nan\] at node \d+, which is not finite'),
    (r'(?<=CL  101 )0\.0', '9.9', r'mode 2 has 0.0 Hz after 9.9 Hz; give the modes of one anal'),
])
def test_calculix_files(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert re.search(message, altered('frd', tmp_path, old, new))


def test_calculix_files_without_modes(tmp_path: Path) -> None:
    """A static step, or other results than displacements, is passed over."""
    for old, new in (('MODAL', 'STATI'), (' 2( +[0-9]+MODAL)', r' 0\1'), ('DISP', 'FORC')):
        assert altered('frd', tmp_path, old, new, 0).startswith('holds no real normal modes')


@pytest.mark.parametrize(('old', 'new', 'message'), [
    (r'frequency_hz', 'frequencies', 'holds no table of displacements below .* layout is not re'),
    (r'^modal_mass, 1', 'modal_mass', r'line 3: gives 8 modal masses of 9 modes; give one each'),
    (r'ux_1', 'vx_1', "line 4: has 'vx_1' in column 5, where 9 modes have ux; see docs/howto"),
    (r', uz_9', '', r'line 4: has nothing in column 31, where 9 modes have uz'),
    (r', uz_9', ', uz_9, ux_10', "line 4: has 'ux_10' in column 32, where 9 modes have nothing"),
    (r'^13, ', '13, 0.0, ', r'line 7: has 32 columns, not 31; give a line each node: its number'),
    (r'^13, [^,]*', '13, 1.2.3', "line 7: has '1.2.3', not a number; see docs/howto/modal_re"),
    (r'^13, [^,]*', '13, nan', r'lines from 5: has \[nan, .*\] at node 13, which is not finite'),
    (r'^13, ', '10, ', r'lines from 5: names node 10 2 times; export one component, each node on'),
    (r'^13, ', '13.5, ', r'line 7: has node number 13.5; number nodes by whole numbers'),
    (r'(?s)^10, .*', '', r'line 4: is the last line: there are no nodes; see docs/howto/modal_'),
    (r'^# a pad', '# \\udcff', r'line 1: is no UTF-8 text|surrogates'),
])
def test_tables(old: str, new: str, message: str, tmp_path: Path) -> None:
    if 'udc' in new:
        path = write_sample('table', tmp_path)
        path.write_bytes(path.read_bytes().replace(b'# a pad', b'# \xff'))
        assert re.search(message, refusal(path))
    else:
        assert re.search(message, altered('table', tmp_path, old, new))


def test_decimal_commas(tmp_path: Path) -> None:
    path = tmp_path / 'pad.csv'
    path.write_text('frequency_hz; 0; 3442,5\nnode; x; y; z; ux; uy; uz; ux; uy; uz\n1;0;0;0;1;1;1'
                    ';1;1;1\n')
    assert refusal(path) == "line 1: has '3442,5', not a number; write decimals with a point"


@pytest.mark.parametrize(('name', 'old', 'new', 'message'), [
    ('ansys', r'^    NODE +X .*', '    NODE      A', 'holds no table of coordinates: this lay'),
    ('ansys', r'   FREQ=', '   TIME=', r'line \d+: begins displacements with no frequency above'),
    ('ansys', r'SUBSTEP= +2', 'SUBSTEP=     1', 'mode 1 substep 1: names node 10 2 times; exp'),
    ('ansys', r'SUBSTEP= +8', 'SUBSTEP=     7', r'gives .* Hz to mode 1 substep 7, which had 3'),
    ('ansys', r'^ {6}13 .*\n', '', r'^mode 1 substep 1: moves|moves 89 nodes, the first mode 88'),
    ('ansys', r'^( {6}13 .*)$', r'\1 1.0', r'line \d+: has 6 numbers, not 5; see docs/howto'),
    ('ansys', r'^( {6}13 .*?)E', r'\1F', r"line \d+: has '.*F.*', not a number; see docs"),
    ('abaqus', r'^\*Node,.*', '*Node output', 'holds no table of coordinates: this layout is'),
    ('abaqus', r'Freq = ', 'Load = ', r'line \d+: begins displacements with no frequency above'),
    ('abaqus', r'^( {14}13 .*)$', r'\1 1.0', r'line \d+: has 6 numbers, not 5'),
    ('abaqus', r'^ {14}13 ', ' ' * 14 + '10 ', '^mode 1: names node 10 2 times; export one compo'),
    ('abaqus', r'^ {14}13 ', ' 99999999999999913 ', "has node number '99999999999999913'; number"),
])
def test_listings(name: str, old: str, new: str, message: str, tmp_path: Path) -> None:
    count = 0 if 'NODE +X' in old or 'Node,' in old else 1
    assert re.search(message, altered(name, tmp_path, old, new, count))


def test_a_listing_of_one_mode_that_was_cut(tmp_path: Path) -> None:
    path = write_sample('abaqus', tmp_path)
    text = path.read_text()
    path.write_text(text[:text.rindex('Minimum') - 400])
    assert re.match(r'mode 9: moves \d+ nodes, the first mode 89 \(node \d+ differs\); export the',
                    refusal(path, **options('abaqus')))

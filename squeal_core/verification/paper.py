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

"""Numbers and claims of K09, and the tolerances they are held to."""

from typing import TypeAlias

Pair: TypeAlias = tuple[int, int]

FRICTION, PRELOAD, SLOW, FAST = 0.42, 2000.0, 5.0, 20.0  # K09: -, N, rad/s, rad/s
THIRD, PADS = (13, 14), (25, 26)  # K09's numbers of its two squeal pairs
ADDED = ((19, 20), (39, 40))  # those of fig. 14
EXACT, FIT = 1e-3, 5e-3  # of frequencies: as printed; as a fitted hat and another mesh leave them
SOFTER = (0.70, 0.71, 0.72)  # of the nominal contact stiffness
TORSION = 'disc (0,0)s'
_HAT, _MESH = ('the dimensions are fitted to these frequencies, for K09 does not print them',
               "the pad's dimensions are printed, so this is the mesh: K09's is not known, this "
               'one is converged (docs/explanation/convergence.md)')
PRINTED = (  # Hz in K09, the mode's name here, in words, where printed, why it may differ
    (3431.0, 'pad 1 flexible 1', 'first bending of the pad', 'sec. 3', _MESH),
    (5720.0, 'pad 1 flexible 2', 'first torsion of the pad', 'sec. 3', _MESH),
    (1365.0, TORSION, 'in-plane torsion of the disc', 'sec. 3', _HAT),
    (727.0, 'disc (0,0)c', 'umbrella mode of the disc', 'fig. 8', _HAT),
    (1896.0, 'disc (0,1)c', 'second umbrella mode', 'fig. 8', _HAT),
    (1959.0, 'disc (1,1)c', 'disc, 1 nodal diameter', 'fig. 8', _HAT),
    (4820.0, 'disc (3,1)c', 'disc, 3 nodal diameters', 'fig. 8', _HAT),
    (4920.0, 'disc (2,2)c', 'disc, 2 nodal diameters', 'fig. 8', _HAT),
    (7528.0, 'disc (4,1)c', 'disc, 4 nodal diameters', 'fig. 8', _HAT))

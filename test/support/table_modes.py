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

"""The complex modes at one of many points that a table answered, by the class's own means."""

from squeal_core.stability.eigensolution import ComplexModes
from squeal_core.surrogate.expansion_table import TableModes


def modes_at(found: TableModes, place: int) -> ComplexModes:
    """Return the modes at a point; `ComplexModes` finds the unstable ones among them."""
    first, count = found.divergent[place], found.counts[place]
    roots = found.eigenvalues[place, :count]
    return ComplexModes(
        roots[:first], roots[first:], roots, found.errors[place, :count], found.tolerances,
        'table', found.numbers[place, :count], float(found.omitted_below[place]))

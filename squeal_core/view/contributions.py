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

"""Terms that add up to a growth rate, ranked for bars."""

from collections.abc import Mapping

_LEAST_SHARE = 1e-3  # of the largest contribution, below which terms are summed up


def ranked_terms(contributions: Mapping[str, float]) -> dict[str, float]:
    """Return the terms that count [1/s], largest first, and the sum of the others."""
    least = _LEAST_SHARE * max(map(abs, contributions.values()))
    ranked = sorted(contributions.items(), key=lambda item: -item[1])
    result = {name: value for name, value in ranked if abs(value) >= least}
    rest = sum(value for name, value in contributions.items() if name not in result)
    return {**result, 'others': rest} if rest else result

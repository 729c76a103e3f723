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

"""Numbers as messages say them."""

import math

from squeal_core.common.wording import risk_in_words
from support.rows import each


@each(('risk', 'words'), [(1.0, '>0.99'), (0.9951, '>0.99'), (0.9949, '0.99'), (0.494, '0.49'),
                          (0.0, '0.00'), (math.nan, 'nan')])
def test_no_risk_is_rounded_up_to_certainty(risk: float, words: str) -> None:
    assert risk_in_words(risk) == words

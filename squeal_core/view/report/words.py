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

"""Numbers as the page writes them; an unknown one is a dash."""

from datetime import datetime, UTC
import math

from squeal_core.common import wording
from squeal_core.view.report.runs import DATED

DASH = '–'


def number(value: float, digits: str = '.1f') -> str:
    """Return a formatted number, or a dash if it is not finite."""
    return format(value, digits) if math.isfinite(value) else DASH


def risk(value: float) -> str:
    """Return a squeal risk, never rounded up to certainty."""
    return wording.risk_in_words(value) if math.isfinite(value) else DASH


def percent(share: float) -> str:
    """Return a share in per cent, or a dash if it is not finite."""
    return f'{100.0 * share:.1f} %' if math.isfinite(share) else DASH


def percent_down(share: float) -> str:
    """Return a share in %, never rounded up to all."""
    return wording.percent_down(share) if math.isfinite(share) else DASH


def duration(seconds: float) -> str:
    """Return a duration in s, min or h."""
    if seconds < 120.0:
        return f'{seconds:.1f} s'
    return f'{seconds / 60.0:.1f} min' if seconds < 7200.0 else f'{seconds / 3600.0:.2f} h'


def clock(time: float) -> str:
    """Return date and time, UTC; the time of a clock without a date in s."""
    if not time > DATED:
        return f'{time:.1f} s'
    return datetime.fromtimestamp(time, UTC).strftime('%Y-%m-%d %H:%M:%S UTC')

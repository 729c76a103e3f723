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

"""The build-up over a whole brake application, at ticks that are given."""

from collections.abc import Sequence

import numpy as np
from squeal_core.risk.application_risk import ApplicationRisk
from squeal_core.risk.risk_records import MemberGrowth
from squeal_core.risk.squeal_risk import SquealRisk


def over_application(risk: SquealRisk, times_ns: Sequence[int],
                     growth: MemberGrowth) -> ApplicationRisk:
    """
    Return the build-up after a whole brake application; its peaks are those of all of it.

    Parameters
    ----------
    risk : SquealRisk
        Of the ensemble.
    times_ns : (T,) sequence of int
        Ticks at which the brake slides; it is taken as released a tick before and a tick after.
    growth : MemberGrowth
        At these ticks; NaN where nothing is known.

    """
    application = ApplicationRisk(risk)
    period = int(min(np.diff(times_ns), default=50_000_000))
    application.release(int(times_ns[0]) - period)
    for tick, time in enumerate(times_ns):
        application.advance(int(time), growth.at(tick))
    application.finish(int(times_ns[-1]) + period)
    return application

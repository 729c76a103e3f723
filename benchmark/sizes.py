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

"""Models of K09's brake with fewer and with more modes than it keeps, for the benchmarks."""

from dataclasses import replace

from squeal_core.assembly.build import build_model
from squeal_core.assembly.checks import truncated
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.common.resources import config_folder
from squeal_core.model.brake_model import BrakeModel


def sized(count: int) -> BrakeModel:
    """Return a model of about so many modes; doublets stay whole."""
    shipped = BrakeModel.load('kang2009')
    if count <= shipped.size:
        return replace(truncated(shipped, count / shipped.size), caliper=shipped.caliper,
                       friction_law=shipped.friction_law)
    brake = read_brake(config_folder() / 'brakes' / 'kang2009.yaml')
    share = count / shipped.size
    more = replace(brake, disc_modes=round(share * brake.disc_modes),
                   pad_modes=round(share * brake.pad_modes))
    return build_model(more)

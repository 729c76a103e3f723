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

"""Entry point of `squeal_monitor`: signals are handled before anything slow is imported."""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import sys  # noqa: I100

from squeal_ros import interrupts


def monitor() -> int:
    """Run the node `squeal_monitor`."""
    interrupts.EndAtOnce(0, always=True)
    try:
        from squeal_ros.node.lifecycle_node import main
    except ModuleNotFoundError as error:
        print(f'squeal_monitor: {error}; source the setup of ROS 2 Jazzy, or '
              "pip install -e '.[ros]' in the checkout", file=sys.stderr)
        return 2
    code = main()
    interrupts.ignore()
    return code


if __name__ == '__main__':
    sys.exit(monitor())

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

"""Files beyond the packages, as ament_python installs them; the rest is in pyproject.toml."""

from glob import glob

from setuptools import setup

PACKAGE = 'squeal_ros'
SHARE = f'share/{PACKAGE}'
CONFIG = ('config', 'config/brakes', 'config/models', 'config/tables', 'config/drive_cycles',
          'config/schedules', 'config/vehicles', 'config/layouts', 'config/security')

setup(
    python_requires='>=3.11',
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (SHARE, ['package.xml']),
        (f'{SHARE}/launch', glob('launch/*.launch.py')),
        *((f'{SHARE}/{folder}', [f for f in glob(f'{folder}/*') if '.' in f.rpartition('/')[2]])
          for folder in CONFIG),
        (f'{SHARE}/squeal_msgs/msg', glob('squeal_msgs/msg/*.msg')),  # to write bags
    ],
)

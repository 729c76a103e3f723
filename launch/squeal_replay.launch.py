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

"""
Play a bag to the monitor, on the bag's time; everything ends with the bag.

    ros2 launch squeal_ros squeal_replay.launch.py bag:=drive config:=my.yaml

What an earlier monitor published is not played again: two publishers would be heard at once.
Faster than real time, with the same samples at every tick, and with a summary that begins with how
much of the braking was assessed: `squeal replay`.
"""

from pathlib import Path

from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    IncludeLaunchDescription,
    Shutdown,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription  # noqa: I100

# a path known before launching: `--show-args` then lists the monitor's arguments too
MONITOR = Path(__file__).with_name('squeal_monitor.launch.py')
# whole names, whether the player's regular expression is matched or searched
OLD_ANSWERS = '^(.*/squeal_monitor/.*|/diagnostics|/clock)$'


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription([
        DeclareLaunchArgument('bag', description='folder or file that `ros2 bag play` reads'),
        DeclareLaunchArgument('rate', default_value='1.0',
                              description='seconds of the bag in one second'),
        DeclareLaunchArgument('clock_rate', default_value='200.0',
                              description='messages on /clock a second; many to one tick of the '
                                          'monitor keep its ticks on time'),
        DeclareLaunchArgument('delay', default_value='5.0',
                              description='seconds the monitor has to start and subscribe'),
        DeclareLaunchArgument('exclude', default_value=OLD_ANSWERS,
                              description='regular expression of topics that are not played'),
        IncludeLaunchDescription(PythonLaunchDescriptionSource(str(MONITOR)),
                                 launch_arguments={'use_sim_time': 'true'}.items()),
        ExecuteProcess(
            # the bag first: an option that takes several values would swallow it
            cmd=['ros2', 'bag', 'play', LaunchConfiguration('bag'),
                 '--clock', LaunchConfiguration('clock_rate'),
                 '--rate', LaunchConfiguration('rate'),
                 '--delay', LaunchConfiguration('delay'),
                 '--exclude-regex', LaunchConfiguration('exclude'),
                 '--disable-keyboard-controls'],
            output='screen', on_exit=Shutdown(reason='the bag has been played')),
    ])

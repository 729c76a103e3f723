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
Launch the monitor of one vehicle.

ros2 launch squeal_ros squeal_monitor.launch.py config:=my.yaml use_sim_time:=true
"""

from pathlib import Path

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.launch_context import LaunchContext
from launch.launch_description_entity import LaunchDescriptionEntity
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription  # noqa: I100


def generate_launch_description() -> LaunchDescription:
    shipped = PathJoinSubstitution([FindPackageShare('squeal_ros'), 'config', 'monitor.yaml'])
    return LaunchDescription([
        DeclareLaunchArgument('config', default_value=shipped,
                              description='settings of the monitor, a ROS parameter file'),
        DeclareLaunchArgument('model', default_value='',
                              description='path of a model file, or the name of a shipped model; '
                                          'empty: the one that the settings name'),
        DeclareLaunchArgument('namespace', default_value='',
                              description='of the node and of its relative topics'),
        DeclareLaunchArgument('use_sim_time', default_value='false',
                              description='take the time from /clock'),
        OpaqueFunction(function=monitor),
    ])


def monitor(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """
    Return the node; a function, because a model that is not given must not be set at all.

    Settings that are not there end the launch: ROS would start the node with its defaults.
    """
    config = Path(LaunchConfiguration('config').perform(context))
    if not config.is_file():
        raise FileNotFoundError(f'config:={config}: there is no such file; give the settings of '
                                'the monitor, a ROS parameter file')
    overrides = {'use_sim_time': ParameterValue(
        LaunchConfiguration('use_sim_time'), value_type=bool)}
    if LaunchConfiguration('model').perform(context):
        overrides['model'] = ParameterValue(LaunchConfiguration('model'), value_type=str)
    return [LifecycleNode(
        package='squeal_ros', executable='squeal_monitor', name='squeal_monitor',
        namespace=LaunchConfiguration('namespace'), output='screen',
        parameters=[LaunchConfiguration('config'), overrides])]

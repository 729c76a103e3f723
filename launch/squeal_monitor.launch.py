"""Launch the monitor of one vehicle.

    ros2 launch squeal_ros squeal_monitor.launch.py config:=my.yaml use_sim_time:=true
"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    shipped = PathJoinSubstitution([FindPackageShare('squeal_ros'), 'config', 'monitor.yaml'])
    return LaunchDescription([
        DeclareLaunchArgument('config', default_value=shipped,
                              description='settings of the monitor, a ROS parameter file'),
        DeclareLaunchArgument('namespace', default_value='',
                              description='of the node and of its relative topics'),
        DeclareLaunchArgument('use_sim_time', default_value='false',
                              description='take the time from /clock'),
        LifecycleNode(
            package='squeal_ros', executable='squeal_monitor', name='squeal_monitor',
            namespace=LaunchConfiguration('namespace'), output='screen',
            parameters=[LaunchConfiguration('config'), {'use_sim_time': ParameterValue(
                LaunchConfiguration('use_sim_time'), value_type=bool)}]),
    ])

"""Beside ouster_ros (point_type original): the sensor is recovered from the clouds.

ros2 launch mapless_ros ouster.launch.py motion:=tf rviz:=true
"""

import pathlib

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource

LABELLER = pathlib.Path(get_package_share_directory("mapless_ros")) / "launch" / "labeller.launch.py"


def generate_launch_description():
    arguments = {"points": "/ouster/points", "sensor": ""}
    source = PythonLaunchDescriptionSource(str(LABELLER))
    return LaunchDescription([IncludeLaunchDescription(source, launch_arguments=arguments.items())])

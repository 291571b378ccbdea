"""Beside velodyne_driver and velodyne_pointcloud of a VLP-16.

ros2 launch mapless_ros vlp16.launch.py motion:=tf rviz:=true
"""

import pathlib

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource

LABELLER = pathlib.Path(get_package_share_directory("mapless_ros")) / "launch" / "labeller.launch.py"


def generate_launch_description():
    arguments = {"points": "/velodyne_points", "sensor": "VLP-16"}
    source = PythonLaunchDescriptionSource(str(LABELLER))
    return LaunchDescription([IncludeLaunchDescription(source, launch_arguments=arguments.items())])

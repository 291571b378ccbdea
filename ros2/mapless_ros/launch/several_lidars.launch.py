"""A labeller for each of several lidars, each with its own topics: /front/points_labelled, /rear/points_labelled ...

They share the motion of tf, not yet their rays: a labeller sees what its own lidar sees.
"""

import pathlib

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource

LABELLER = pathlib.Path(get_package_share_directory("mapless_ros")) / "launch" / "labeller.launch.py"
LIDARS = {"front": "/front/velodyne_points", "rear": "/rear/velodyne_points"}


def generate_launch_description():
    groups = []
    for name, points in LIDARS.items():
        arguments = {"namespace": name, "points": points, "sensor": "VLP-16", "motion": "tf"}
        source = PythonLaunchDescriptionSource(str(LABELLER))
        groups.append(GroupAction([IncludeLaunchDescription(source, launch_arguments=arguments.items())]))
    return LaunchDescription(groups)

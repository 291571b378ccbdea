"""A labeller for each of several lidars of one vehicle, each with its own topics: /front/points_labelled, ...

ros2 launch mapless_ros several_lidars.launch.py                  # the first lidar's odometry moves all of them
ros2 launch mapless_ros several_lidars.launch.py motion:=tf       # the vehicle's localisation does

/tf_static places the frames of their clouds on base_link. The motion is that of /tf (odom to base_link). Each sees
what its own lidar sees: they do not share their rays, as `mapless detect RIG` does.
"""

import pathlib

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PythonExpression

LABELLER = pathlib.Path(get_package_share_directory("mapless_ros")) / "launch" / "labeller.launch.py"
LIDARS = {
    "front": {"points": "/front/velodyne_points", "sensor": "VLP-16"},
    "rear": {"points": "/rear/velodyne_points", "sensor": "VLP-16", "clock_offset_s": "0.0"},
}


def labeller_of(name, lidar, arguments):
    source = PythonLaunchDescriptionSource(str(LABELLER))
    arguments = {"namespace": name, **lidar, **arguments}
    return GroupAction([IncludeLaunchDescription(source, launch_arguments=arguments.items())])


def generate_launch_description():
    motion = LaunchConfiguration("motion")
    of_first = {
        "motion": motion,
        "base_frame": "base_link",
        "publish_tf": PythonExpression(["'true' if '", motion, "' == 'own' else 'false'"]),
    }
    of_others = {"motion": "tf", "pose_wait_s": "2.0"}  # until the odometry of the first has started
    first, *others = LIDARS
    return LaunchDescription(
        [
            DeclareLaunchArgument("motion", default_value="own", description="of the first lidar: own or tf"),
            labeller_of(first, LIDARS[first], of_first),
            *(labeller_of(name, LIDARS[name], of_others) for name in others),
        ]
    )

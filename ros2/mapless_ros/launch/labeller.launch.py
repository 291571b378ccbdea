"""One labeller as a component. Load the driver into the same container, and clouds are not copied.

ros2 launch mapless_ros labeller.launch.py points:=/velodyne_points sensor:=VLP-16 publish_tf:=true rviz:=true
"""

import pathlib

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import ComposableNodeContainer, Node
from launch_ros.descriptions import ComposableNode

SHARE = pathlib.Path(get_package_share_directory("mapless_ros"))
# Empty: as in the file of parameters, which has a value for each.
PARAMETERS = {
    "sensor": (str, "name of the sensor or its calibration file; none: recovered from the first clouds"),
    "motion": (str, "own, tf or odometry"),
    "publish_tf": (lambda text: text.lower() == "true", "write the own odometry to tf"),
    "base_frame": (str, "the own odometry is of this frame, which tf_static places; none: of the clouds' frame"),
    "clock_offset_s": (float, "added to the stamps of the clouds, where their clock is not that of tf"),
    "pose_wait_s": (float, "how long a cloud waits for poses"),
    "static_map_file": (str, "file that service save_static_map writes"),
}
ARGUMENTS = {
    "points": ("points", "topic of the clouds"),
    "odometry_in": ("odometry_in", "topic of nav_msgs/Odometry, for motion:=odometry"),
    "namespace": ("", "of the node and of the topics it writes"),
    "params": (str(SHARE / "config" / "labeller.yaml"), "file of parameters"),
    "rviz": ("false", "show the result"),
    **{name: ("", f"{text} (empty: as in params)") for name, (_, text) in PARAMETERS.items()},
}


def container(context):
    """An argument that is empty leaves what the file of parameters says."""
    value = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    given = {name: kind(value[name]) for name, (kind, _) in PARAMETERS.items() if value[name]}
    labeller = ComposableNode(
        package="mapless_ros",
        plugin="mapless_ros::Labeller",
        name="labeller",
        namespace=value["namespace"],
        parameters=[value["params"], *([given] if given else [])],
        remappings=[("points", value["points"]), ("odometry_in", value["odometry_in"])],
        extra_arguments=[{"use_intra_process_comms": True}],
    )
    return [
        ComposableNodeContainer(
            package="rclcpp_components",
            executable="component_container_mt",
            name="mapless_container",
            namespace=value["namespace"],
            composable_node_descriptions=[labeller],
            output="screen",
        )
    ]


def generate_launch_description():
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", str(SHARE / "rviz" / "labeller.rviz")],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=container), rviz])

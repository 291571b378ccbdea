"""One labeller as a component. Load the driver into the same container, and clouds are not copied.

ros2 launch mapless_ros labeller.launch.py points:=/velodyne_points sensor:=VLP-16 publish_tf:=true rviz:=true
"""

import pathlib

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import ComposableNodeContainer, Node
from launch_ros.descriptions import ComposableNode
from launch_ros.parameter_descriptions import ParameterValue

SHARE = pathlib.Path(get_package_share_directory("mapless_ros"))
ARGUMENTS = {
    "points": ("points", "topic of the clouds"),
    "odometry_in": ("odometry_in", "topic of nav_msgs/Odometry, for motion:=odometry"),
    "namespace": ("", "of the node and of the topics it writes"),
    "sensor": ("", "name of the sensor or its calibration file; empty: recovered from the first clouds"),
    "motion": ("own", "own, tf or odometry"),
    "publish_tf": ("false", "write the own odometry to tf"),
    "base_frame": ("", "the own odometry is of this frame, which tf_static places; empty: of the clouds' frame"),
    "clock_offset_s": ("0.0", "added to the stamps of the clouds, where their clock is not that of tf"),
    "pose_wait_s": ("0.3", "how long a cloud waits for poses"),
    "params": (str(SHARE / "config" / "labeller.yaml"), "file of parameters"),
    "rviz": ("false", "show the result"),
}


def generate_launch_description():
    value = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    labeller = ComposableNode(
        package="mapless_ros",
        plugin="mapless_ros::Labeller",
        name="labeller",
        namespace=value["namespace"],
        parameters=[
            value["params"],
            {
                "sensor": ParameterValue(value["sensor"], value_type=str),
                "motion": ParameterValue(value["motion"], value_type=str),
                "publish_tf": ParameterValue(value["publish_tf"], value_type=bool),
                "base_frame": ParameterValue(value["base_frame"], value_type=str),
                "clock_offset_s": ParameterValue(value["clock_offset_s"], value_type=float),
                "pose_wait_s": ParameterValue(value["pose_wait_s"], value_type=float),
            },
        ],
        remappings=[("points", value["points"]), ("odometry_in", value["odometry_in"])],
        extra_arguments=[{"use_intra_process_comms": True}],
    )
    container = ComposableNodeContainer(
        package="rclcpp_components",
        executable="component_container_mt",
        name="mapless_container",
        namespace=value["namespace"],
        composable_node_descriptions=[labeller],
        output="screen",
    )
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", str(SHARE / "rviz" / "labeller.rviz")],
        condition=IfCondition(value["rviz"]),
    )
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, container, rviz])

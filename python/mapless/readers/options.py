"""What a user can say about a recording."""

from __future__ import annotations

import dataclasses

OPTIONS = {
    "--topic": "topic of the clouds in a bag; not needed where there is one",
    "--meta": "metadata (JSON) of an Ouster capture; not needed where it lies beside it with the same name",
    "--columns": "what a folder of .bin or .npy files has per point, in order: x,y,z,intensity,ring:u2,time:f8 (float32 "
    "where there is no type)",
    "--lidar": "which sensor of a recording of several: up_lidar or down_lidar of Argoverse 2, Ouster or Velodyne of HeLiPR",
    "--scene": "which drive of a data set of several: scene-0061 of nuScenes",
    "--pose-topic": "topic of the odometry, poses or transforms in a bag: its poses in place of own odometry",
    "--world-frame": "with --pose-topic: the frame of the poses; not needed where the transforms have one at the top",
    "--imu-topic": "topic of sensor_msgs/Imu in a bag: its angular velocities for the odometry, as --imu; /tf_static places "
    "its frame on that of the clouds",
    "--speed-topic": "topic of geometry_msgs/TwistStamped or nav_msgs/Odometry in a bag: speed of the lidar by its twist for "
    "the odometry, as --speed; /tf_static places its frame",
}
"""Options of the command that readers take, by flag: an attribute of Options each."""


@dataclasses.dataclass
class Options:
    sensor: str = ""
    topic: str | None = None
    meta: str | None = None
    columns: str | None = None
    lidar: str | None = None
    scene: str | None = None
    pose_topic: str | None = None
    world_frame: str | None = None
    imu_topic: str | None = None
    speed_topic: str | None = None


FORMATS = (
    *("rosbag1", "rosbag2", "mcap", "velodyne", "ouster", "argoverse2", "boreas", "helipr", "nuscenes", "helimos"),
    *("bin", "npy", "ply", "las"),
)
"""Of all readers of registry.py, in its order."""

FIELDS = {flag: flag.lstrip("-").replace("-", "_") for flag in OPTIONS}
"""Attribute of Options by flag."""

"""Poses of the sensor from topics of a bag, written by rosbags."""

import numpy as np
import pytest

import mapless

rosbags = pytest.importorskip("rosbags")
from rosbags.rosbag2 import Writer  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

from test_bags import VELODYNE, clouds_of, message, velodyne  # noqa: E402

STORE = get_typestore(Stores.ROS2_HUMBLE)
# The lidar is 2 m above and 1 m in front of the vehicle, and turned by a quarter about z: (x, y, z), (qx, qy, qz, qw).
MOUNT = ((1.0, 0.0, 2.0), (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)))
T_VEHICLE_LIDAR = np.array([[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1.0]])


def make(kind, **fields):
    return STORE.types[kind](**fields)


def header(stamp_ns, frame):
    stamp = make("builtin_interfaces/msg/Time", sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def vector(kind, numbers):
    return make(f"geometry_msgs/msg/{kind}", **dict(zip("xyzw", map(float, numbers), strict=False)))


def transform(stamp_ns, parent, child, position, quaternion=(0, 0, 0, 1)):
    inner = make(
        "geometry_msgs/msg/Transform",
        translation=vector("Vector3", position),
        rotation=vector("Quaternion", quaternion),
    )
    one = make(
        "geometry_msgs/msg/TransformStamped", header=header(stamp_ns, parent), child_frame_id=child, transform=inner
    )
    return "tf2_msgs/msg/TFMessage", make("tf2_msgs/msg/TFMessage", transforms=[one])


def odometry(stamp_ns, child, position):
    pose = make(
        "geometry_msgs/msg/Pose", position=vector("Point", position), orientation=vector("Quaternion", (0, 0, 0, 1))
    )
    zero = make(
        "geometry_msgs/msg/Twist", linear=vector("Vector3", (0, 0, 0)), angular=vector("Vector3", (0, 0, 0))
    )
    none = np.zeros(36)
    return "nav_msgs/msg/Odometry", make(
        "nav_msgs/msg/Odometry",
        header=header(stamp_ns, "odom"),
        child_frame_id=child,
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=none),
        twist=make("geometry_msgs/msg/TwistWithCovariance", twist=zero, covariance=none),
    )


def write(folder, scans, others):
    """Clouds in frame "lidar" on /points, and `others`: topic, instant and message."""
    with Writer(folder, version=9) as writer:
        cloud_type = "sensor_msgs/msg/PointCloud2"
        connections = {"/points": writer.add_connection("/points", cloud_type, typestore=STORE)}
        for cloud, stamp_ns in clouds_of(scans, VELODYNE, velodyne):
            data = STORE.serialize_cdr(message(STORE, cloud, stamp_ns), cloud_type)
            writer.write(connections["/points"], stamp_ns, data)
        for topic, stamp_ns, (kind, one) in others:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(connections[topic], stamp_ns, STORE.serialize_cdr(one, kind))
    return folder


def along(make_one, child):
    """Poses of a vehicle that drives along x at 10 m/s, 20 a second."""
    return [(ns, make_one(ns, child, (10 * ns * 1e-9, 0, 0))) for ns in range(0, 600_000_000, 50_000_000)]


@pytest.mark.parametrize("kind", ["odometry", "transforms"])
def test_poses_of_the_vehicle_become_poses_of_the_lidar(kind, scans, tmp_path):
    mount = [("/tf_static", 0, transform(0, "base", "lidar", *MOUNT))]
    if kind == "odometry":
        topic, poses = "/odom", along(odometry, "base")
    else:
        topic, poses = "/tf", along(lambda ns, child, at: transform(ns, "odom", child, at), "base")
    bag = write(tmp_path / "drive", scans[:4], [*mount, *((topic, ns, one) for ns, one in poses)])
    recording = mapless.open(bag, sensor="VLP-16", pose_topic=topic)
    expected = T_VEHICLE_LIDAR.copy()
    expected[0, 3] += 10 * 0.225
    np.testing.assert_allclose(recording.trajectory.pose_at(225_000_000), expected, atol=1e-9)
    assert f"poses: of frame lidar in odom from topic {topic} and /tf_static" in recording.notes


def test_poses_of_another_frame_are_refused_with_the_frames_there_are(scans, tmp_path):
    bag = write(tmp_path / "drive", scans[:2], [("/odom", ns, one) for ns, one in along(odometry, "base")])
    with pytest.raises(mapless.InputError, match="no poses of frame lidar, .*; its transforms are odom -> base"):
        mapless.open(bag, sensor="VLP-16", pose_topic="/odom")
    with pytest.raises(mapless.InputError, match="--pose-topic /gps: not one of its topics of .*: /odom"):
        mapless.open(bag, sensor="VLP-16", pose_topic="/gps")

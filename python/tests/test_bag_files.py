"""Compressed and split bags hold the scans of whole ones."""

import shutil

import numpy as np
import pytest

import mapless

rosbags = pytest.importorskip("rosbags")
import yaml  # noqa: E402
from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import CompressionFormat, CompressionMode  # noqa: E402
from rosbags.rosbag2 import Writer as Writer2  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

from test_bags import VELODYNE, clouds_of, message, velodyne  # noqa: E402

KIND = "sensor_msgs/msg/PointCloud2"


def ros1(path, clouds, compression=None):
    store = get_typestore(Stores.ROS1_NOETIC)
    writer = Writer1(path)
    if compression is not None:
        writer.set_compression(Writer1.CompressionFormat[compression])
    with writer:
        connection = writer.add_connection("/points", KIND, typestore=store)
        for cloud, stamp_ns in clouds:
            writer.write(connection, stamp_ns, store.serialize_ros1(message(store, cloud, stamp_ns), KIND))
    return path


def ros2(path, clouds, mode=None):
    store = get_typestore(Stores.ROS2_HUMBLE)
    writer = Writer2(path, version=9)
    if mode is not None:
        writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/points", KIND, typestore=store)
        for cloud, stamp_ns in clouds:
            writer.write(connection, stamp_ns, store.serialize_cdr(message(store, cloud, stamp_ns), KIND))
    return path


def split_ros1(path, clouds):
    path.mkdir()
    ros1(path / "drive_0.bag", clouds[:2])
    ros1(path / "drive_1.bag", clouds[2:])
    return path


def split_ros2(path, clouds):
    """As ros2 bag record --max-bag-duration writes it: one folder, several files."""
    ros2(path, clouds[:2])
    rest = ros2(path.with_name("rest"), clouds[2:])
    information = [yaml.safe_load((folder / "metadata.yaml").read_text()) for folder in (path, rest)]
    whole, part = (one["rosbag2_bagfile_information"] for one in information)
    shutil.copy(rest / "rest.db3", path / "drive_1.db3")
    whole["relative_file_paths"].append("drive_1.db3")
    for count in (whole, whole["topics_with_message_count"][0]):
        count["message_count"] += part["message_count"]
    begin_ns = whole["starting_time"]["nanoseconds_since_epoch"]
    end_ns = part["starting_time"]["nanoseconds_since_epoch"] + part["duration"]["nanoseconds"]
    whole["duration"]["nanoseconds"] = end_ns - begin_ns
    whole["files"].append({**part["files"][0], "path": "drive_1.db3"})
    (path / "metadata.yaml").write_text(yaml.safe_dump(information[0]))
    return path


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("drive.bag", lambda path, clouds: ros1(path, clouds, "BZ2")),
        ("drive.bag", lambda path, clouds: ros1(path, clouds, "LZ4")),
        ("drive", lambda path, clouds: ros2(path, clouds, "FILE")),
        ("drive", lambda path, clouds: ros2(path, clouds, "MESSAGE")),
        ("drive", split_ros1),
        ("drive", split_ros2),
    ],
    ids=["bz2 chunks", "lz4 chunks", "zstd file", "zstd messages", "split rosbag1", "split rosbag2"],
)
def test_a_compressed_or_split_bag_has_the_scans_of_a_whole_one(name, make, scans, tmp_path):
    clouds = list(clouds_of(scans[:4], VELODYNE, velodyne))
    found = mapless.open(make(tmp_path / name, clouds), sensor="VLP-16")
    whole = mapless.open(ros1(tmp_path / "whole.bag", clouds), sensor="VLP-16")
    assert len(found) == len(whole) == 4
    for k in (2, 0, 3):
        assert found[k].stamp_ns == whole[k].stamp_ns
        np.testing.assert_array_equal(found[k].points, whole[k].points)
        np.testing.assert_array_equal(found[k].time_s, whole[k].time_s)

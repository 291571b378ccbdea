"""MCAP files written by the packages mcap and mcap-ros2-support from a simulated drive."""

from types import SimpleNamespace

import numpy as np
import pytest

import mapless
from comparison import compact, iou

pytest.importorskip("rosbags")
pytest.importorskip("mcap_ros2")
from mcap_ros2.writer import Writer  # noqa: E402

from test_bags import HESAI, NEBULA, OUSTER, TYPES, VELODYNE, clouds_of, hesai, nebula, ouster, velodyne  # noqa: E402

SEPARATOR = "=" * 80
# As `ros2 interface show` prints them.
POINT_CLOUD2 = f"""std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
{SEPARATOR}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{SEPARATOR}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{SEPARATOR}
MSG: sensor_msgs/PointField
uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
"""


def message(points, stamp_ns, height):
    kinds = {name: points.dtype.fields[name] for name in points.dtype.names}
    stamp = SimpleNamespace(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    return SimpleNamespace(
        header=SimpleNamespace(stamp=stamp, frame_id="lidar"),
        height=height,
        width=len(points) // height,
        fields=[
            SimpleNamespace(name=name, offset=offset, datatype=TYPES[kind.str[1:]], count=1)
            for name, (kind, offset) in kinds.items()
        ],
        is_bigendian=False,
        point_step=points.dtype.itemsize,
        row_step=points.dtype.itemsize * (len(points) // height),
        data=points.tobytes(),
        is_dense=False,
    )


def write(path, clouds, height=1):
    with path.open("wb") as file:
        writer = Writer(file)
        schema = writer.register_msgdef("sensor_msgs/msg/PointCloud2", POINT_CLOUD2)
        for cloud, stamp_ns in clouds:
            writer.write_message("/points", schema, message(cloud, stamp_ns, height), log_time=stamp_ns)
        writer.finish()
    return path


def everything(_scan):
    return slice(None)


def ouster_as_columns(scan, cloud):
    """Its rings from the bottom, as the rows of the native recording."""
    stamp_ns = ouster(scan, cloud)
    cloud["ring"] = scan.ring
    return stamp_ns


def test_a_cloud_with_every_ray_in_ns_gives_the_same_labels(scans, driver_result, tmp_path):
    clouds = clouds_of(scans, OUSTER, ouster_as_columns, everything)
    result = mapless.detect(write(tmp_path / "drive.mcap", clouds), tmp_path / "out", sensor="VLP-16")
    assert result.scans == driver_result.scans
    for k in result.scans:
        np.testing.assert_array_equal(result.label(k)[compact(scans[k])], driver_result.label(k)[compact(scans[k])])


@pytest.mark.parametrize(
    ("dtype", "fill"),
    [(VELODYNE, velodyne), (OUSTER, ouster), (HESAI, hesai), (NEBULA, nebula)],
    ids=["velodyne", "ouster", "hesai", "nebula"],
)
def test_a_file_of_returns_gives_the_labels_of_the_native_recording(dtype, fill, scans, driver_result, tmp_path):
    bag = write(tmp_path / "drive.mcap", clouds_of(scans, dtype, fill))
    result = mapless.detect(bag, tmp_path / "out", sensor="VLP-16")
    assert len(result) == len(scans)
    found = np.concatenate([result.moving(k) for k in result.scans])
    expected = np.concatenate([driver_result.moving(k)[compact(scans[k])] for k in result.scans])
    assert expected.any()
    assert iou(found, expected) > 0.99


def test_a_destaggered_image_gives_the_same_labels(scans, driver_result, tmp_path):
    """As ouster-ros publishes: organised, each row shifted so that a column of the image is an azimuth, not an instant."""
    rows = 16
    order = np.concatenate([np.roll(row, 7 * k) for k, row in enumerate(np.arange(len(scans[0])).reshape(rows, -1))])
    clouds = ((cloud[order], stamp_ns) for cloud, stamp_ns in clouds_of(scans, OUSTER, ouster_as_columns, everything))
    result = mapless.detect(write(tmp_path / "drive.mcap", clouds, height=rows), tmp_path / "out", sensor="VLP-16")
    assert result.scans == driver_result.scans
    for k in result.scans:
        kept = compact(scans[k])[order]
        np.testing.assert_array_equal(result.label(k)[kept], driver_result.label(k)[order][kept])

"""Bags written by another library, rosbags, from a simulated drive."""

import numpy as np
import pytest

import mapless
from comparison import compact, iou

rosbags = pytest.importorskip("rosbags")
from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import StoragePlugin  # noqa: E402
from rosbags.rosbag2 import Writer as Writer2  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

TYPES = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}
XYZ = [("x", "f4"), ("y", "f4"), ("z", "f4")]
# Fields as the drivers name and place them; section 1.3 of their documents.
VELODYNE = np.dtype([*XYZ, ("intensity", "f4"), ("ring", "u2"), ("time", "f4")])
OUSTER = np.dtype([*XYZ, ("intensity", "f4"), ("t", "u4"), ("reflectivity", "u2"), ("ring", "u2"), ("range", "u4")])
HESAI = np.dtype([*XYZ, ("intensity", "f4"), ("ring", "u2"), ("timestamp", "f8")])  # 26 bytes: timestamp not aligned
NEBULA = np.dtype([*XYZ, ("intensity", "u1"), ("channel", "u2"), ("azimuth", "f4"), ("time_stamp", "u4")])


def velodyne(scan, cloud):
    cloud["ring"] = scan.ring
    cloud["time"] = scan.time_s - 0.1  # the header has the stamp of the last packet
    return scan.stamp_ns + 100_000_000


def ouster(scan, cloud):
    cloud["ring"] = 15 - scan.ring  # counted from the top
    cloud["t"] = np.round(np.nan_to_num(scan.time_s) * 1e9)
    return scan.stamp_ns


def hesai(scan, cloud):
    cloud["ring"] = scan.ring
    cloud["timestamp"] = EPOCH_S + scan.stamp_ns * 1e-9 + scan.time_s
    return EPOCH_S * 1_000_000_000 + scan.stamp_ns


def nebula(scan, cloud):
    cloud["channel"] = scan.ring
    cloud["time_stamp"] = np.round(np.nan_to_num(scan.time_s) * 1e9)
    return scan.stamp_ns


EPOCH_S = 1_790_000_000


def message(store, points, stamp_ns, height=1):
    kinds = {name: points.dtype.fields[name] for name in points.dtype.names}
    field = store.types["sensor_msgs/msg/PointField"]
    stamp = store.types["builtin_interfaces/msg/Time"](stamp_ns // 1_000_000_000, stamp_ns % 1_000_000_000)
    header_type = store.types["std_msgs/msg/Header"]
    ros1 = "seq" in header_type.__dataclass_fields__
    header = header_type(seq=0, stamp=stamp, frame_id="lidar") if ros1 else header_type(stamp, "lidar")
    return store.types["sensor_msgs/msg/PointCloud2"](
        header=header,
        height=height,
        width=len(points) // height,
        fields=[field(name, offset, TYPES[kind.str[1:]], 1) for name, (kind, offset) in kinds.items()],
        is_bigendian=False,
        point_step=points.dtype.itemsize,
        row_step=points.dtype.itemsize * (len(points) // height),
        data=np.frombuffer(points.tobytes(), np.uint8),
        is_dense=False,
    )


def write(path, clouds, topics=("/points",)):
    """A bag of clouds and stamps; the suffix of the path is its format: .bag, .mcap, .db3."""
    kind = "sensor_msgs/msg/PointCloud2"
    ros1 = path.suffix == ".bag"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    plugin = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    with Writer1(path) if ros1 else Writer2(path.with_suffix(""), version=9, storage_plugin=plugin) as writer:
        connections = [writer.add_connection(topic, kind, typestore=store) for topic in topics]
        for cloud, stamp_ns in clouds:
            one = message(store, cloud, stamp_ns)
            data = store.serialize_ros1(one, kind) if ros1 else store.serialize_cdr(one, kind)
            for connection in connections:
                writer.write(connection, stamp_ns, data)
    if ros1:
        return path
    return next(path.with_suffix("").glob("*.mcap")) if path.suffix == ".mcap" else path.with_suffix("")


def clouds_of(scans, dtype, fill, keep=compact):
    for scan in scans:
        cloud = np.zeros(len(scan), dtype)
        for i, name in enumerate("xyz"):
            cloud[name] = scan.points[:, i]
        with np.errstate(invalid="ignore"):
            stamp_ns = fill(scan, cloud)
        yield cloud[keep(scan)], stamp_ns


@pytest.mark.parametrize(
    ("suffix", "dtype", "fill"),
    [(".bag", VELODYNE, velodyne), (".mcap", OUSTER, ouster), (".db3", HESAI, hesai), (".mcap", NEBULA, nebula)],
    ids=["rosbag1-velodyne", "mcap-ouster", "rosbag2-hesai", "mcap-nebula"],
)
def test_a_bag_gives_the_labels_of_the_native_recording(suffix, dtype, fill, scans, driver_result, tmp_path):
    bag = write(tmp_path / f"drive{suffix}", clouds_of(scans, dtype, fill))
    result = mapless.detect(bag, tmp_path / "out", sensor="VLP-16")
    assert len(result) == len(scans)
    found = np.concatenate([result.moving(k) for k in result.scans])
    kept = [compact(scan) for scan in scans]
    expected = np.concatenate([driver_result.moving(k)[kept[k]] for k in result.scans])
    assert expected.any()
    assert iou(found, expected) > 0.99


def test_a_bag_gives_the_labels_of_its_arrays(scans, tmp_path):
    clouds = list(clouds_of(scans, VELODYNE, velodyne))
    result = mapless.detect(write(tmp_path / "drive.bag", clouds), tmp_path / "out", sensor="VLP-16")
    detector = mapless.OnlineDetector("VLP-16")
    found = [f for cloud, stamp_ns in clouds for f in detector.push(cloud, stamp_ns=stamp_ns)] + detector.flush()
    for f in found:
        np.testing.assert_array_equal(result.label(f.scan), f.label)


def test_scans_of_a_bag_are_those_written(scans, tmp_path):
    bag = write(tmp_path / "drive.mcap", clouds_of(scans, VELODYNE, velodyne, keep=lambda scan: slice(None)))
    recording = mapless.open(bag, sensor="VLP-16")
    assert recording.format == "mcap"
    assert len(recording) == len(scans)
    for k in (3, 4, 13, 0):  # in order and not
        scan = recording[k]
        np.testing.assert_array_equal(scan.points, scans[k].points)
        offset = scan.stamp_ns - scans[k].stamp_ns  # the scan starts with its first return; float32 rounds its time
        assert abs(offset) < 1_000_000
        np.testing.assert_allclose(scan.time_s + offset * 1e-9, scans[k].time_s, atol=1e-8)
    assert any("field time (float32) in s since the stamp" in note for note in recording.notes)


def test_times_that_are_all_zero_are_left_out(scans, tmp_path):
    def no_times(scan, cloud):  # as the Velodyne driver fills them for an HDL-64E
        cloud["ring"] = scan.ring
        return scan.stamp_ns

    recording = mapless.open(write(tmp_path / "drive.bag", clouds_of(scans[:3], VELODYNE, no_times)), sensor="VLP-16")
    assert any("the driver has left the field time empty" in note for note in recording.notes)
    assert np.nanmax(recording[1].time_s) > 0.09  # of a turn of 0.1 s


def test_several_topics_are_listed(scans, tmp_path):
    bag = write(tmp_path / "two.mcap", clouds_of(scans[:2], VELODYNE, velodyne), topics=("/front", "/rear"))
    with pytest.raises(mapless.InputError, match="several PointCloud2 topics: /front, /rear; choose one with --topic"):
        mapless.open(bag)
    with pytest.raises(mapless.CommandError, match="/front, /rear"):
        mapless.detect(bag, tmp_path / "out")
    with pytest.raises(mapless.InputError, match="topic /top: not one of its PointCloud2 topics: /front, /rear"):
        mapless.open(bag, topic="/top")
    assert len(mapless.open(bag, topic="/rear", sensor="VLP-16")) == 2


LIVOX = np.dtype([*XYZ, ("intensity", "f4"), ("tag", "u1"), ("line", "u1"), ("timestamp", "f8")])


@pytest.mark.parametrize(
    ("dtype", "scale", "message"),
    [
        (LIVOX, 1, "pattern does not repeat"),
        (np.dtype(XYZ[:2]), 1, "no field z"),
        (VELODYNE, 1000, "are they millimetres"),
    ],
)
def test_clouds_that_cannot_work_are_refused_with_the_reason(dtype, scale, message, scans, tmp_path):
    cloud = np.zeros(len(scans[0]), dtype)
    for i, name in enumerate("xyz"):
        if name in dtype.names:
            cloud[name] = scans[0].points[:, i] * scale
    with pytest.raises(mapless.InputError, match=message):
        mapless.open(write(tmp_path / "drive.bag", [(cloud, 1)]), sensor="VLP-16")


def test_a_truncated_bag_is_refused(scans, tmp_path):
    bag = write(tmp_path / "drive.bag", clouds_of(scans[:2], VELODYNE, velodyne))
    bag.write_bytes(bag.read_bytes()[:-200])
    with pytest.raises(mapless.InputError, match="not a complete bag"):
        mapless.open(bag)


def test_a_message_twice_is_named(scans, tmp_path):
    clouds = list(clouds_of(scans[:4], VELODYNE, velodyne))
    bag = write(tmp_path / "drive.bag", [clouds[0], clouds[1], clouds[1], clouds[2]])
    with pytest.raises(mapless.CommandError, match="/points message 2"):
        mapless.detect(bag, tmp_path / "out", sensor="VLP-16")
    assert not (tmp_path / "out").exists()

"""Explanations from Python, LAS files, and MCAP files read back with the public packages."""

import numpy as np
import pytest

import mapless
from mapless._command import asks_for_mcap
from mapless._verbs import run_verb
from mapless.mcap_export import export_mcap, main, quaternion_of


def test_a_point_is_explained(drive, native_result):
    record = int(np.flatnonzero(native_result.moving(9))[0])
    said = mapless.explain(drive, native_result.path, scan=9, point=record)
    assert said["label"] == "dynamic"
    assert said["object"]["number"] == native_result.label(9)[record] >> 16
    assert sum(o["votes"] for o in said["observations"]) == said["votes"]["total"]


def labelled_pcd(drive, result, folder, k, *more):
    """The points of a scan with their fields, as PCD; in a new folder of `folder`."""
    folder = folder / f"pcd_{'_'.join(more)}"
    run_verb("export", str(drive), str(result.path), "--what", "labelled", "--scans", f"{k}:{k}", "-o", str(folder), *more)
    content = (folder / f"{k:06}.pcd").read_bytes()
    fields = [(name, "<f4") for name in "xyz"] + [(name, "<u4") for name in ("label", "object", "record")]
    fields += [("probability", "<f4")]
    return np.frombuffer(content, np.dtype(fields), offset=content.index(b"DATA binary\n") + 12)


def test_las_has_the_points_and_columns_of_pcd(drive, native_result, tmp_path):
    laspy = pytest.importorskip("laspy")
    pcd = labelled_pcd(drive, native_result, tmp_path, 9)
    run_verb(
        "export", str(drive), str(native_result.path), "--what", "labelled", "--scans", "9:9",
        "-o", str(tmp_path / "las"), "--cloud-format", "las",
    )
    las = laspy.read(tmp_path / "las" / "000009.las")
    assert (las.header.version.major, las.header.version.minor, las.header.point_format.id) == (1, 4, 6)
    for axis in "xyz":
        np.testing.assert_allclose(las[axis], pcd[axis], atol=1.01e-4)
    for column in ("label", "object", "record", "probability"):
        np.testing.assert_array_equal(las[column], pcd[column])
    assert las.header.maxs == pytest.approx([pcd[a].max() for a in "xyz"], abs=2e-4)


@pytest.fixture(scope="module")
def mcap_file(drive, native_result, tmp_path_factory):
    pytest.importorskip("mcap")
    file = tmp_path_factory.mktemp("mcap") / "drive.mcap"
    words = [str(drive), str(native_result.path), "--cloud-format", "mcap", "-o", str(file), "--scans", "2:12", "--every", "2"]
    assert asks_for_mcap(words)
    assert main(words) == 0
    return file


def messages(file, topic):
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory as Protobuf
    from mcap_ros2.decoder import DecoderFactory as Ros2

    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[Ros2(), Protobuf()])
        return [(schema, message.log_time, decoded) for schema, _, message, decoded in reader.iter_decoded_messages(topics=[topic])]


def test_mcap_clouds_are_those_of_the_result(drive, native_result, mcap_file, tmp_path):
    found = messages(mcap_file, "/points")
    assert len(found) == 6
    schema, time_ns, cloud = found[1]
    assert (schema.name, schema.encoding) == ("sensor_msgs/msg/PointCloud2", "ros2msg")
    pcd = labelled_pcd(drive, native_result, tmp_path, 4, "--frame", "sensor")
    assert [f.name for f in cloud.fields] == list(pcd.dtype.names)
    assert cloud.width == len(pcd) and cloud.point_step == pcd.dtype.itemsize and bytes(cloud.data) == pcd.tobytes()
    assert cloud.header.stamp.sec * 10**9 + cloud.header.stamp.nanosec == time_ns
    assert abs(time_ns - mapless.open(drive)[4].stamp_ns) < 1000
    assert np.count_nonzero(pcd["label"] == 251) == native_result.moving(4).sum()
    np.testing.assert_array_equal(pcd["probability"], native_result.probability(4)[pcd["record"]])


def test_mcap_poses_take_points_into_the_world(drive, native_result, mcap_file, tmp_path):
    _, _, tf = messages(mcap_file, "/tf")[5]
    one = tf.transforms[0]
    assert (one.header.frame_id, one.child_frame_id) == ("world", "lidar")
    t, q = one.transform.translation, one.transform.rotation
    world = labelled_pcd(drive, native_result, tmp_path, 12)
    sensor = labelled_pcd(drive, native_result, tmp_path, 12, "--frame", "sensor")
    p = np.stack([sensor[a].astype(float) for a in "xyz"], axis=1)
    axis = np.array([q.x, q.y, q.z])
    turned = p + 2 * np.cross(axis, np.cross(axis, p) + q.w * p)  # rotation by a unit quaternion
    np.testing.assert_allclose(turned + [t.x, t.y, t.z], np.stack([world[a] for a in "xyz"], axis=1), atol=2e-3)


def test_mcap_boxes_are_those_of_the_table(native_result, mcap_file):
    rows = native_result.objects()
    shown = set()
    for k, (schema, _, update) in zip(range(2, 13, 2), messages(mcap_file, "/objects"), strict=True):
        assert (schema.name, schema.encoding) == ("foxglove.SceneUpdate", "protobuf")
        of_scan = rows[rows["scan"] == k]
        assert [int(e.id) for e in update.entities] == list(of_scan["id"])
        for entity, row in zip(update.entities, of_scan, strict=True):
            cube = entity.cubes[0]
            assert entity.frame_id == "world"
            assert [cube.pose.position.x, cube.size.z] == [row["x_m"], row["extent_z_m"]]
            velocity = np.array([row["vx_mps"], row["vy_mps"], row["vz_mps"]])
            assert len(entity.arrows) == (1 if velocity.any() else 0)  # none in the first scan of an object
            if not velocity.any():
                continue
            arrow = entity.arrows[0]
            assert arrow.shaft_length + arrow.head_length == pytest.approx(np.linalg.norm(velocity))
            o = arrow.pose.orientation
            x_axis = [1 - 2 * (o.y**2 + o.z**2), 2 * (o.x * o.y + o.z * o.w), 2 * (o.x * o.z - o.y * o.w)]
            np.testing.assert_allclose(x_axis, velocity / np.linalg.norm(velocity), atol=1e-9)
        now = set(map(int, of_scan["id"]))
        assert {int(d.id) for d in update.deletions} == shown - now
        shown = now
    assert shown


def test_quaternion_of_a_turn_about_z():
    x, y, z, w = quaternion_of(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]))
    np.testing.assert_allclose(np.array([x, y, z, w]) * np.sign(w), [0, 0, np.sqrt(0.5), np.sqrt(0.5)], atol=1e-12)


def test_mcap_refuses_scans_that_are_not_there(drive, native_result, tmp_path, capsys):
    with pytest.raises(mapless.InputError, match="has 0 to 13"):
        export_mcap(drive, native_result.path, tmp_path / "no.mcap", scans="40:50")
    words = [str(drive), str(tmp_path), "--cloud-format", "mcap", "-o", str(tmp_path / "no.mcap")]
    assert main(words) == 3
    assert "no result" in capsys.readouterr().err

"""Data sets in their own layouts, written here from a simulated drive, and real samples where they lie."""

import csv
import json
import math
import pathlib

import numpy as np
import pytest

import mapless
from comparison import compact, iou

DATA = pathlib.Path("/work/shared/data")
EPOCH_NS = 1_600_000_000_000_000_000


def rows_of(scan, columns, points=None, **values):
    kept = compact(scan)
    rows = np.zeros(kept.sum(), columns)
    for i, axis in enumerate("xyz"):
        rows[axis] = (scan.points if points is None else points)[kept, i]
    for name, numbers in values.items():
        rows[name] = np.asarray(numbers)[kept]
    return rows


def moved_to(scan, poses, instant_ns):
    """The points in the sensor frame at another instant, as a data set that compensates has them: to a millimetre."""
    sensor_from_world = np.linalg.inv(poses.pose_at(instant_ns))
    step_ns = 100_000
    instants, of_point = np.unique(np.round(np.nan_to_num(scan.time_s) * 1e9 / step_ns).astype(int), return_inverse=True)
    moves = [sensor_from_world @ poses.pose_at(min(scan.stamp_ns + int(i) * step_ns, poses.end_ns)) for i in instants]
    pose = np.stack(moves)[of_point]
    return np.einsum("nij,nj->ni", pose[:, :3, :3], scan.points) + pose[:, :3, 3]


def quaternion(rotation):
    """x y z w; rotations of a drive turn by less than half a turn."""
    w = math.sqrt(max(0.0, 1 + np.trace(rotation))) / 2
    r = rotation
    return np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 4 * w * w]) / (4 * w)


def pose_instants(scans, poses):
    return sorted({poses.begin_ns, poses.end_ns, *(s.stamp_ns for s in scans if s.stamp_ns >= poses.begin_ns)})


XYZI = [(name, "<f4") for name in ("x", "y", "z", "intensity")]


def write_boreas(folder, scans, poses):
    (folder / "lidar").mkdir()
    (folder / "applanix").mkdir()
    middle_ns = 50_000_000
    for scan in scans:
        columns = [*XYZI, ("laser", "<f4"), ("t", "<f4")]
        rows = rows_of(scan, columns, laser=scan.ring, t=scan.time_s - middle_ns * 1e-9)
        rows.tofile(folder / "lidar" / f"{(EPOCH_NS + scan.stamp_ns + middle_ns) // 1000}.bin")
    names = "GPSTime easting northing altitude vel_east vel_north vel_up roll pitch heading".split()
    with (folder / "applanix" / "lidar_poses.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(names)
        for ns in pose_instants(scans, poses):
            pose = poses.pose_at(ns)
            r = pose[:3, :3].T  # the rotation of the axes: about z by the heading, then y, then x
            angles = math.atan2(r[2, 1], r[2, 2]), -math.asin(r[2, 0]), math.atan2(r[1, 0], r[0, 0])
            table.writerow([(EPOCH_NS + ns) // 1000, *pose[:3, 3], 0, 0, 0, *angles])
    return {}


def write_helipr(folder, scans, poses, lidar, columns, values):
    (folder / "LiDAR" / lidar).mkdir(parents=True)
    (folder / "LiDAR_GT").mkdir()
    for scan in scans:
        rows = rows_of(scan, columns, ring=scan.ring, **values(scan))
        rows.tofile(folder / "LiDAR" / lidar / f"{EPOCH_NS + scan.stamp_ns}.bin")
    with (folder / "LiDAR_GT" / f"{lidar}_gt.txt").open("w") as file:
        for ns in pose_instants(scans, poses):
            pose = poses.pose_at(ns)
            print(EPOCH_NS + ns, *pose[:3, 3], *quaternion(pose[:3, :3]), file=file)
    return {"lidar": lidar}


def write_helipr_velodyne(folder, scans, poses):
    columns = [*XYZI, ("ring", "<u2"), ("time", "<f4")]
    return write_helipr(folder, scans, poses, "Velodyne", columns, lambda scan: {"time": scan.time_s})


def write_helipr_ouster(folder, scans, poses):
    columns = [*XYZI, ("t", "<u4"), ("reflectivity", "<u2"), ("ring", "<u2"), ("ambient", "<u2")]
    return write_helipr(folder, scans, poses, "Ouster", columns, lambda scan: {"t": np.nan_to_num(scan.time_s) * 1e9})


def write_argoverse(folder, scans, poses):
    feather = pytest.importorskip("pyarrow.feather")
    pyarrow = pytest.importorskip("pyarrow")

    def write(file, **columns):
        file.parent.mkdir(parents=True, exist_ok=True)
        feather.write_feather(pyarrow.table(columns), file)

    half = math.sqrt(0.5)  # the sensor is 1.6 m above the ego frame and turned to the left
    mounting = np.array([[0, -1, 0, 1.3], [1, 0, 0, 0], [0, 0, 1, 1.6], [0, 0, 0, 1.0]])
    write(
        folder / "calibration" / "egovehicle_SE3_sensor.feather",
        **{"sensor_name": ["up_lidar"], "qw": [half], "qx": [0.0], "qy": [0.0], "qz": [half]},
        **{"tx_m": [1.3], "ty_m": [0.0], "tz_m": [1.6]},
    )
    instants = pose_instants(scans, poses)
    ego = [poses.pose_at(ns) @ np.linalg.inv(mounting) for ns in instants]
    turns = np.array([quaternion(pose[:3, :3]) for pose in ego])
    write(
        folder / "city_SE3_egovehicle.feather",
        timestamp_ns=[EPOCH_NS + ns for ns in instants],
        **{f"q{name}": turns[:, i] for i, name in enumerate("xyzw")},
        **{f"t{name}_m": [pose[i, 3] for pose in ego] for i, name in enumerate("xyz")},
    )
    for scan in scans:
        in_ego = moved_to(scan, poses, scan.stamp_ns) @ mounting[:3, :3].T + mounting[:3, 3]
        kept = compact(scan)
        write(
            folder / "sensors" / "lidar" / f"{EPOCH_NS + scan.stamp_ns}.feather",
            **{axis: in_ego[kept, i].astype(np.float32) for i, axis in enumerate("xyz")},
            laser_number=scan.ring[kept].astype(np.uint8),
            offset_ns=(scan.time_s[kept] * 1e9).astype(np.int32),
        )
    return {}


def write_nuscenes(folder, scans, poses):
    tables = folder / "v1.0-mini"
    tables.mkdir()
    (folder / "sweeps").mkdir()
    turn_ns = 50_000_000
    sweeps, ego = [], []
    for k, scan in enumerate(scans):
        end_ns = scan.stamp_ns + turn_ns
        rows = rows_of(scan, [*XYZI, ("ring", "<f4")], moved_to(scan, poses, end_ns), ring=scan.ring)
        stamp_us = (EPOCH_NS + end_ns) // 1000
        name = f"sweeps/log__LIDAR_TOP__{stamp_us}.pcd.bin"
        rows.tofile(folder / name)
        tokens = {"sample_token": "s", "ego_pose_token": f"e{k}", "calibrated_sensor_token": "c"}
        sweeps.append({"token": f"d{k}", "timestamp": stamp_us, "filename": name, **tokens})
        pose = poses.pose_at(min(end_ns, poses.end_ns))
        x, y, z, w = quaternion(pose[:3, :3])
        ego.append({"token": f"e{k}", "translation": pose[:3, 3].tolist(), "rotation": [w, x, y, z]})
    for name, rows in {
        "sample_data": sweeps,
        "ego_pose": ego,
        "calibrated_sensor": [{"token": "c", "translation": [0, 0, 0], "rotation": [1, 0, 0, 0]}],
        "scene": [{"token": "x", "name": "scene-0001"}],
        "sample": [{"token": "s", "scene_token": "x"}],
    }.items():
        (tables / f"{name}.json").write_text(json.dumps(rows))
    return {"scene": "scene-0001"}


def write_helimos(folder, scans, poses):
    (folder / "velodyne").mkdir()
    (folder / "labels").mkdir()
    with (folder / "poses.txt").open("w") as file:
        for k, scan in enumerate(scans):
            rows_of(scan, XYZI, moved_to(scan, poses, scan.stamp_ns)).tofile(folder / "velodyne" / f"{k:06d}.bin")
            print(*poses.pose_at(scan.stamp_ns)[:3].reshape(-1), file=file)
    labels = np.full(compact(scans[3]).sum(), 0x70009, "<u4")
    labels[:5] = 251
    labels.tofile(folder / "labels" / "000003.label")
    return {}


WRITERS = [
    ("boreas", write_boreas, 0.99),
    ("helipr", write_helipr_velodyne, 0.99),
    ("helipr", write_helipr_ouster, 0.99),
    ("argoverse2", write_argoverse, 0.98),
    ("helimos", write_helimos, 0.95),
]


@pytest.mark.parametrize(("format", "write", "likeness"), WRITERS)
def test_a_data_set_gives_the_labels_of_the_native_recording(
    format, write, likeness, scans, poses, posed_result, tmp_path
):
    folder = tmp_path / "drive"
    folder.mkdir()
    options = write(folder, scans, poses)
    recording = mapless.open(folder, sensor="VLP-16", **options)
    assert (recording.format, len(recording)) == (format, len(scans))
    pose = recording.trajectory.pose_at(recording[5].stamp_ns)
    np.testing.assert_allclose(pose, poses.pose_at(scans[5].stamp_ns), atol=0.02)
    result = mapless.detect(folder, tmp_path / "out", sensor="VLP-16", **options)
    found = np.concatenate([result.moving(k) for k in result.scans])
    expected = np.concatenate([posed_result.moving(k)[compact(scans[k])] for k in result.scans])
    assert iou(found, expected) > likeness


def test_a_scene_of_nuscenes_is_read(scans, poses, tmp_path):
    options = write_nuscenes(tmp_path, scans[:6], poses)
    with pytest.raises(mapless.InputError, match="choose a scene with --scene: scene-0001"):
        mapless.open(tmp_path)
    recording = mapless.open(tmp_path, sensor="VLP-16", **options)
    assert (recording.format, len(recording)) == ("nuscenes", 6)
    assert any("compensated already, to the end of the turn" in note for note in recording.notes)
    np.testing.assert_array_equal(recording[2].ring, scans[2].ring[compact(scans[2])])
    end_ns = EPOCH_NS + scans[2].stamp_ns + 50_000_000
    np.testing.assert_allclose(
        recording.trajectory.pose_at(end_ns), poses.pose_at(scans[2].stamp_ns + 50_000_000), atol=1e-6
    )


def test_labels_of_helimos_are_those_of_the_frames_that_have_them(scans, poses, tmp_path):
    write_helimos(tmp_path, scans, poses)
    recording = mapless.open(tmp_path, sensor="VLP-16")
    assert recording.labels(2) is None
    labels = recording.labels(3)
    assert len(labels) == compact(scans[3]).sum()
    assert (labels[:5] == 251).all() and (labels[5:] == 9).all()


def test_two_lidars_of_helipr_are_listed(scans, poses, tmp_path):
    write_helipr_velodyne(tmp_path, scans[:2], poses)
    (tmp_path / "LiDAR" / "Ouster").mkdir()
    (tmp_path / "LiDAR" / "Ouster" / "1.bin").write_bytes(bytes(26))
    with pytest.raises(mapless.InputError, match="Ouster and Velodyne: choose one with --lidar"):
        mapless.open(tmp_path)
    with pytest.raises(mapless.InputError, match="Aeva and Avia are no spinning lidars"):
        mapless.open(tmp_path, lidar="Aeva")


@pytest.mark.parametrize(
    ("name", "package", "format", "options"),
    [
        ("argoverse2/val/*", "pyarrow", "argoverse2", {}),
        ("argoverse2/val/*", "pyarrow", "argoverse2", {"lidar": "down_lidar"}),
        ("nuscenes_sample", "numpy", "nuscenes", {"stationary": True}),
    ],
)
def test_real_samples_run_end_to_end(name, package, format, options, tmp_path):
    path = next(iter(sorted(DATA.glob(name))), None)
    if path is None:
        pytest.skip(f"{DATA / name}: not there")
    pytest.importorskip(package)
    recording = mapless.open(path, **{flag: text for flag, text in options.items() if flag != "stationary"})
    assert recording.format == format
    assert recording[0].ring.max() == 31
    result = mapless.detect(path, tmp_path / "out", **options)
    assert [len(result.label(k)) for k in result.scans] == [len(scan) for scan in recording]


def damaged_boreas(folder):
    (folder / "lidar").mkdir()
    (folder / "applanix").mkdir()
    np.zeros(24, "<f4").tofile(folder / "lidar" / "1000000.bin")
    row = "easting,northing,altitude,roll,pitch,heading,GPSTime\n" + "0,0,0,0,0,0,{}\n"
    (folder / "applanix" / "lidar_poses.csv").write_text(row.format("inf"))


def damaged_helipr(folder):
    (folder / "LiDAR" / "Velodyne").mkdir(parents=True)
    (folder / "LiDAR_GT").mkdir()
    np.zeros(22, "u1").tofile(folder / "LiDAR" / "Velodyne" / "1000000000.bin")
    (folder / "LiDAR_GT" / "Velodyne_gt.txt").write_text(f"{10**30} 0 0 0 0 0 0 1\n" f"{10**31} 0 0 0 0 0 0 1\n")


def damaged_argoverse(folder):
    pyarrow = pytest.importorskip("pyarrow")
    feather = pytest.importorskip("pyarrow.feather")
    (folder / "sensors" / "lidar").mkdir(parents=True)
    (folder / "calibration").mkdir()
    for name in ("city_SE3_egovehicle", "calibration/egovehicle_SE3_sensor", "sensors/lidar/1"):
        feather.write_feather(pyarrow.table({"other": [1]}), str(folder / f"{name}.feather"))


def damaged_nuscenes(folder):
    (folder / "v1.0-mini").mkdir()
    for name in ("sample_data", "scene"):
        (folder / "v1.0-mini" / f"{name}.json").write_text("[" * 100_000)


@pytest.mark.parametrize("make", [damaged_boreas, damaged_helipr, damaged_argoverse, damaged_nuscenes])
def test_a_damaged_data_set_is_refused_by_name(make, tmp_path):
    make(tmp_path)
    with pytest.raises(mapless.InputError, match=str(tmp_path)):
        mapless.open(tmp_path)

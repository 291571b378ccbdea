"""Captures and data sets that are damaged or mistaken are refused with the file, the field, its value and what to do."""

import json
import struct

import numpy as np
import pytest

import mapless
from test_datasets import write_argoverse, write_nuscenes
from test_packets import vlp_16_packets, write_capture

SCANS = 4
ETHERNET = bytes(12) + b"\x08\x00"


def frame(payload, header=ETHERNET, address=201):
    udp = struct.pack(">HHHH", 2368, 2368, 8 + len(payload), 0) + payload
    source = bytes([192, 168, 1, address])
    return header + struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0, source, bytes(4)) + udp


def write_frames(path, link, frames):
    data = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, link)
    for time_us, content in frames:
        seconds, rest_us = divmod(int(time_us), 1_000_000)
        data += struct.pack("<IIII", seconds, rest_us, len(content), len(content)) + content
    path.write_bytes(data)
    return path


@pytest.fixture
def velodyne():
    pytest.importorskip("velodyne_decoder")
    return list(vlp_16_packets(2))


@pytest.mark.parametrize(
    ("link", "header"),
    [(101, b""), (113, bytes(14) + b"\x08\x00"), (276, b"\x08\x00" + bytes(18)), (0, struct.pack("<I", 2))],
    ids=["raw IP", "any", "any, version 2", "loopback"],
)
def test_captures_of_every_usual_link_are_read(link, header, velodyne, tmp_path):
    expected = mapless.open(write_capture(tmp_path / "ethernet.pcap", velodyne))
    path = write_frames(tmp_path / "drive.pcap", link, [(time, frame(data, header)) for time, data in velodyne])
    np.testing.assert_array_equal(mapless.open(path)[1].points, expected[1].points)


def test_a_capture_of_another_link_is_refused_with_its_type(velodyne, tmp_path):
    path = write_frames(tmp_path / "drive.pcap", 105, [(time, frame(data)) for time, data in velodyne])
    with pytest.raises(mapless.InputError, match="link type = 105.*record on Ethernet"):
        mapless.open(path)


def test_two_sensors_in_a_capture_are_named(velodyne, tmp_path):
    frames = [(time, frame(data, address=201 + i)) for time, data in velodyne for i in range(2)]
    with pytest.raises(mapless.InputError, match=r"two Velodyne sensors, from 192.168.1.201 to port 2368 and 192.168.1.202"):
        mapless.open(write_frames(tmp_path / "drive.pcap", 1, frames))


def standing(packets):
    return [(t, b"".join(data[k : k + 2] + bytes(2) + data[k + 4 : k + 100] for k in range(0, 1200, 100)) + data[1200:]) for t, data in packets]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (standing, "azimuth: those of the first 150 packets do not change"),
        (lambda packets: packets[::-1], "azimuth: those of the first 150 packets decrease 149 times"),
        (lambda packets: [(t, data[:-1] + b"\x99") for t, data in packets], "drive.pcap: packet: .*Model ID in packet: 153"),
        (lambda packets: [(t, bytes(2) + data[2:]) for t, data in packets[:3]] + packets[3:], None),
    ],
    ids=["standing", "reversed", "unknown model", "three damaged"],
)
def test_packets_that_are_no_turns_are_refused(spoil, message, velodyne, tmp_path):
    path = write_capture(tmp_path / "drive.pcap", spoil(velodyne))
    if message is None:
        assert len(mapless.open(path)) > 0
        return
    with pytest.raises(mapless.InputError, match=message):
        mapless.open(path)


def changed_row(name, **values):
    def change(folder):
        file = folder / "v1.0-mini" / f"{name}.json"
        rows = json.loads(file.read_text())
        rows[-1].update(values)
        file.write_text(json.dumps(rows))

    return change


def table(name, text):
    return lambda folder: (folder / "v1.0-mini" / f"{name}.json").write_text(text)


NUSCENES = [
    (changed_row("sample_data", timestamp=None), r"sample_data.json: row 3 timestamp = None: expected a time in us"),
    (changed_row("sample_data", timestamp=10**300), r"sample_data.json: row 3 timestamp = 10*: expected a time in us"),
    (changed_row("sample_data", timestamp=7), r"sample_data.json: d3 timestamp = 7 us: not that in filename = sweeps/log__LIDAR"),
    (changed_row("sample_data", filename=3), r"sample_data.json: row 3 filename = 3: expected text"),
    (changed_row("sample_data", token="d1"), r"sample_data.json: row 3 token = d1: of another row"),
    (changed_row("sample_data", ego_pose_token="x"), r"ego_pose.json: token = x: no row has it"),
    (changed_row("sample", scene_token="y"), r"v1.0-mini: no sweep of LIDAR_TOP in scene-0001"),
    (changed_row("ego_pose", rotation=[0, 0, 0, 0]), r"ego_pose.json: token = e3: .*quaternion x y z w = \[0, 0, 0, 0\]"),
    (changed_row("ego_pose", translation=[1, None, 2]), r"ego_pose.json: token = e3: position = \[1, None, 2\]"),
    (changed_row("calibrated_sensor", translation=[float("nan"), 0, 0]), r"calibrated_sensor.json: token = c: position = \[nan"),
    (table("ego_pose", "{"), r"ego_pose.json: no table of nuScenes"),
    (table("ego_pose", "[7]"), r"ego_pose.json: row 0 token = 7: expected text"),
    (lambda folder: (folder / "v1.0-mini" / "scene.json").unlink(), r"scene.json: no table of nuScenes"),
    (lambda folder: max((folder / "sweeps").iterdir()).unlink(), r"pcd.bin: no such file; fetch it again"),
]


@pytest.mark.parametrize(("spoil", "message"), NUSCENES, ids=[message[:40] for _, message in NUSCENES])
def test_tables_of_nuscenes_are_refused_by_row_and_field(spoil, message, scans, poses, tmp_path):
    options = write_nuscenes(tmp_path, scans[:SCANS], poses)
    spoil(tmp_path)
    with pytest.raises(mapless.InputError, match=message):
        recording = mapless.open(tmp_path, sensor="VLP-16", **options)
        recording[SCANS - 1]  # is read when it is asked for


def changed_column(name, column, change):
    def apply(folder):
        pyarrow = pytest.importorskip("pyarrow")
        from pyarrow import feather

        file = max((folder / "sensors" / "lidar").iterdir()) if name == "sweep" else folder / f"{name}.feather"
        columns = {key: np.array(values) for key, values in feather.read_table(file, memory_map=False).to_pydict().items()}
        found = change(columns.pop(column))
        feather.write_feather(pyarrow.table({**columns, **({} if found is None else {column: found})}), str(file))

    return apply


def first(value):
    return lambda values: np.concatenate([[value], values[1:]])


POSES, MOUNTING = "city_SE3_egovehicle", "calibration/egovehicle_SE3_sensor"
ARGOVERSE = [
    (changed_column("sweep", "offset_ns", lambda values: None), r"0.feather: column offset_ns: missing; its columns are x, y"),
    (changed_column("sweep", "laser_number", lambda values: None), r"0.feather: column laser_number: missing"),
    (changed_column("sweep", "x", lambda values: None), r"0.feather: column x: missing"),
    (changed_column("sweep", "x", lambda values: values.astype(str)), r"column x = string: expected floating numbers"),
    (changed_column("sweep", "offset_ns", first(np.nan)), r"column offset_ns = double: expected whole ns, none missing"),
    (changed_column("sweep", "laser_number", first(-1)), r"row 0 laser_number = -1: not one of the 64 lasers"),
    (changed_column(POSES, "tx_m", first(np.nan)), r"city_SE3_egovehicle.feather: row 0 tx_m = nan: not a number"),
    (changed_column(POSES, "timestamp_ns", lambda values: values * 1e-9), r"column timestamp_ns = double: expected whole ns"),
    (changed_column(MOUNTING, "qw", lambda values: None), r"egovehicle_SE3_sensor.feather: column qw: missing"),
    (changed_column(MOUNTING, "sensor_name", lambda values: np.array(["camera"])), r"sensor_name up_lidar: no row has it"),
    (changed_column(MOUNTING, "tx_m", lambda values: values * 1e308 * 10), r"row 0 tx_m = inf: not a number"),
]


@pytest.mark.parametrize(("spoil", "message"), ARGOVERSE, ids=[message[:40] for _, message in ARGOVERSE])
def test_tables_of_argoverse_are_refused_by_column_and_row(spoil, message, scans, poses, tmp_path):
    write_argoverse(tmp_path, scans[:SCANS], poses)
    spoil(tmp_path)
    with pytest.raises(mapless.InputError, match=message):
        recording = mapless.open(tmp_path, sensor="VLP-16")
        recording[SCANS - 1]


def ouster_metadata(**values):
    metadata = {
        "config_params": {"lidar_mode": "512x10"},
        "lidar_data_format": {"columns_per_frame": 512, "columns_per_packet": 16, "pixels_per_column": 4},
        "beam_intrinsics": {"beam_altitude_angles": [20.0, 10.0, -10.0, -20.0], "beam_azimuth_angles": [0.0] * 4},
    }
    for name, value in values.items():
        part = next(part for part in metadata.values() if name in part)
        part[name] = value
    return json.dumps(metadata)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "drive.json: no metadata of an Ouster"),
        ("[" * 100_000, "drive.json: no metadata of an Ouster"),
        ("[]", "drive.json: no metadata of an Ouster: not an object"),
        (ouster_metadata(columns_per_packet=0), "drive.json: columns_per_packet = 0: expected 1 to 128"),
        (ouster_metadata(columns_per_frame=10**9), "drive.json: columns_per_frame = 1000000000: expected 1 to 4096"),
        (ouster_metadata(lidar_mode="1024x10"), "lidar_mode has 1024 columns, columns_per_frame = 512"),
        (ouster_metadata(beam_altitude_angles=[float("nan")] * 4), "beam_altitude_angles: expected finite degrees"),
        (ouster_metadata(beam_altitude_angles=[-20, -10, 10, 20]), "= -20 to 20: expected from the top down"),
        (ouster_metadata(beam_altitude_angles=[0.35, 0.17, -0.17, -0.35]), "= 0.35 to -0.35: expected degrees: are they radians"),
    ],
)
def test_metadata_of_an_ouster_are_refused_by_field(text, message, tmp_path):
    pytest.importorskip("ouster.sdk")
    (tmp_path / "drive.json").write_text(text)
    write_capture(tmp_path / "drive.pcap", [(0, bytes(6464))], 7502)
    with pytest.raises(mapless.InputError, match=message):
        mapless.open(tmp_path / "drive.pcap")

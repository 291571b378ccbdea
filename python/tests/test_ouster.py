"""Captures of an Ouster written by its SDK from a simulated drive: packets (pcap with metadata) and OSF."""

import json
import pathlib
import zlib

import numpy as np
import pytest

import mapless
from comparison import iou, without_empty_rays

core = pytest.importorskip("ouster.sdk.core")
pytest.importorskip("more_itertools")
from ouster.sdk import osf, pcap  # noqa: E402

BEAMS, COLUMNS = 64, 512  # of the SDK's default sensor in this mode
COLUMN_S = 0.1 / COLUMNS
VALID = 1  # status of a column
RECEIVED_NS = np.uint64(1_790_000_000_000_000_000)  # by the computer, when the sensor's clock was 0


@pytest.fixture(scope="module")
def info():
    """With the ports of packets, which the default does not have."""
    metadata = json.loads(core.SensorInfo.from_default(core.LidarMode._512x10).to_json_string())
    metadata["config_params"] |= {"udp_port_lidar": 7502, "udp_port_imu": 7503}
    return core.SensorInfo(json.dumps(metadata))


@pytest.fixture(scope="module")
def ouster_drive(info, tmp_path_factory) -> pathlib.Path:
    """Ten scans of that sensor among 12,000 moving points, simulated by its metadata, without rays known to hit nothing, which packets do not say."""
    folder = tmp_path_factory.mktemp("ouster")
    (folder / "sensor.json").write_text(info.to_json_string())
    mapless.simulate("highway", folder / "native", sensor=folder / "sensor.json", duration_s=1.0)
    without_empty_rays(folder / "native")
    return folder / "native"


@pytest.fixture(scope="module")
def frames(info, ouster_drive):
    """The scans as the SDK holds them: ranges of beams, from the top, by columns."""
    lut = core.XYZLut(info, False)
    near, far = (lut(np.full((BEAMS, COLUMNS), mm, np.uint32)).reshape(-1, 3) for mm in (1000, 2000))
    beams, origins = far - near, 2 * near - far  # a point is origin + range [m] x beam
    out = []
    for k, scan in enumerate(mapless.open(ouster_drive)):
        hit = np.isfinite(scan.points).all(axis=1)
        column = np.round(scan.time_s[hit] / COLUMN_S).astype(int)
        pixel = (BEAMS - 1 - scan.ring[hit].astype(int)) * COLUMNS + column
        range_m = np.einsum("ij,ij->i", scan.points[hit] - origins[pixel], beams[pixel])
        assert np.abs(origins[pixel] + range_m[:, None] * beams[pixel] - scan.points[hit]).max() < 0.002
        ranges = np.zeros(BEAMS * COLUMNS, np.uint32)
        ranges[pixel] = np.round(range_m * 1e3)
        frame = core.LidarFrame(info)
        frame.field("RANGE")[:] = ranges.reshape(BEAMS, COLUMNS)
        frame.timestamp[:] = scan.stamp_ns + np.round(np.arange(COLUMNS) * COLUMN_S * 1e9).astype(np.uint64)
        frame.status[:] = VALID
        frame.measurement_id[:] = np.arange(COLUMNS)
        frame.frame_id = k + 1
        received_ns = RECEIVED_NS + frame.timestamp[:: COLUMNS // len(frame.packet_timestamp)]
        frame.packet_timestamp[:] = received_ns
        out.append((frame, pixel, np.flatnonzero(hit)))
    return out


def write_pcap(path, info, frames):
    packets = []
    for frame, _, _ in frames:
        packets += core.frame_to_packets(frame, core.PacketFormat(info), info.init_id, int(info.sn))
    pcap.record(packets, str(path))
    path.with_suffix(".json").write_text(info.to_json_string())


def write_osf(path, info, frames):
    writer = osf.Writer(str(path), [info])
    for frame, _, _ in frames:
        writer.save(0, frame)
    writer.close()


@pytest.mark.parametrize("write", [write_pcap, write_osf])
def test_a_capture_gives_the_labels_of_the_native_recording(write, info, ouster_drive, frames, tmp_path):
    path = tmp_path / f"drive.{write.__name__.removeprefix('write_')}"
    write(path, info, frames)
    scan, (_, pixel, records) = mapless.open(path)[3], frames[3]
    as_measured = mapless.open(ouster_drive)[3]
    np.testing.assert_allclose(scan.points[pixel], as_measured.points[records], atol=1e-3)
    offset_s = (scan.stamp_ns - as_measured.stamp_ns) * 1e-9
    np.testing.assert_allclose(scan.time_s[pixel] + offset_s, as_measured.time_s[records], atol=1e-6)
    expected = mapless.detect(ouster_drive, tmp_path / "native", odometry=True)
    found = mapless.detect(path, tmp_path / "out")
    assert found.scans == expected.scans
    native = np.concatenate([expected.moving(k)[records] for k, (_, _, records) in enumerate(frames)])
    assert native.any()
    # Ranges are whole millimetres.
    assert iou(np.concatenate([found.moving(k)[pixel] for k, (_, pixel, _) in enumerate(frames)]), native) > 0.99


@pytest.mark.parametrize("at", [40, 2000, -8], ids=["header", "scan", "end"])
def test_a_damaged_osf_is_refused_by_the_bytes(at, info, frames, tmp_path):
    path = tmp_path / "drive.osf"
    write_osf(path, info, frames[:2])
    data = bytearray(path.read_bytes())
    data[at] ^= 1
    path.write_bytes(data)
    with pytest.raises(mapless.InputError, match=r"drive.osf: damaged between bytes \d+ and \d+; copy"):
        mapless.open(path)


def test_an_osf_that_is_cut_is_refused_and_one_that_was_not_closed_is_read(info, frames, tmp_path):
    path = tmp_path / "drive.osf"
    write_osf(path, info, frames[:2])
    whole = path.read_bytes()
    path.write_bytes(whole[:63] + b"\xff" + whole[64:])  # the size of the second block
    with pytest.raises(mapless.InputError, match="damaged after byte 60; copy"):
        mapless.open(path)
    path.write_bytes(whole[:-100])
    with pytest.raises(mapless.InputError, match=f"cut short: {len(whole) - 100} of {len(whole)} bytes; copy"):
        mapless.open(path)
    # The header as the writer begins with it: status 1, and no place of the metadata, no length.
    header = bytearray(whole[:56])
    header[0x1F] = 1
    header[0x28:0x38] = bytes(16)
    path.write_bytes(header + zlib.crc32(header).to_bytes(4, "little") + whole[60:-100])
    assert len(mapless.open(path)) == 2


def test_the_metadata_may_be_given_as_the_sensor(info, frames, tmp_path):
    write_pcap(tmp_path / "drive.pcap", info, frames[:2])
    metadata = (tmp_path / "drive.json").rename(tmp_path / "elsewhere.json")
    assert len(mapless.open(tmp_path / "drive.pcap", sensor=metadata)) == 2

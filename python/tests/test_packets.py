"""Packet captures: Velodyne packets written here byte by byte, and real captures where they lie."""

import math
import pathlib
import struct

import numpy as np
import pytest

import mapless

DATA = pathlib.Path("/work/shared/data")
CYCLE_US, FIRING_US = 55.296, 2.304  # of a VLP-16, from its manual
RANGE_M, STEP_M = 10.0, 0.002


def real(name):
    path = next(iter(sorted(DATA.glob(name))), None)
    if path is None:
        pytest.skip(f"{DATA / name}: not there")
    return path


def vlp_16_packets(turns):
    """Every laser sees a surface at 10 m; two cycles a block, twelve blocks a packet."""
    cycles = round(turns * 0.1e6 / CYCLE_US) // 24 * 24
    for first in range(0, cycles, 24):
        data = b""
        for block in range(12):
            azimuth = round((first + 2 * block) * CYCLE_US * 36000 / 1e5) % 36000
            data += struct.pack("<HH", 0xEEFF, azimuth) + struct.pack("<HB", round(RANGE_M / STEP_M), 100) * 32
        yield first * CYCLE_US, data + struct.pack("<LBB", round(first * CYCLE_US), 0x37, 0x22)


def write_capture(path, payloads, port=2368):
    """UDP over IPv4 over Ethernet in a pcap file."""
    out = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)
    for time_us, payload in payloads:
        udp = struct.pack(">HHHH", port, port, 8 + len(payload), 0) + payload
        ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0, bytes(4), bytes(4)) + udp
        frame = bytes(12) + b"\x08\x00" + ip
        out += struct.pack("<IIII", int(time_us // 1e6), int(time_us % 1e6), len(frame), len(frame)) + frame
    path.write_bytes(out)
    return path


def test_points_of_velodyne_packets_lie_where_the_lasers_point(tmp_path):
    pytest.importorskip("velodyne_decoder")
    recording = mapless.open(write_capture(tmp_path / "drive.pcap", vlp_16_packets(3)))
    assert (recording.format, recording.sensor) == ("velodyne", "VLP-16")
    scan = recording[1]
    # The manual's lasers start up to 11.2 mm above and below the middle.
    offset_m = 0.012
    np.testing.assert_allclose(np.linalg.norm(scan.points, axis=1), RANGE_M, atol=offset_m)
    elevation = np.degrees(np.arcsin(scan.points[:, 2] / RANGE_M))
    np.testing.assert_allclose(elevation, 2.0 * scan.ring - 15, atol=np.degrees(offset_m / RANGE_M))
    # Laser 0 fires at the start of a cycle, at the azimuth of its block: clockwise from x.
    first = scan.ring == 0
    time_s = (scan.stamp_ns - recording[0].stamp_ns) * 1e-9 + scan.time_s[first]
    azimuth = np.arctan2(scan.points[first, 1], scan.points[first, 0])
    turned = (azimuth + 2 * math.pi * time_s / 0.1 + math.pi) % (2 * math.pi) - math.pi
    assert np.abs(turned - np.median(turned)).max() < math.radians(0.02)  # azimuths in hundredths of a degree


def test_lost_packets_leave_the_others_where_they_are(tmp_path):
    pytest.importorskip("velodyne_decoder")
    packets = list(vlp_16_packets(3))
    whole = mapless.open(write_capture(tmp_path / "whole.pcap", packets))
    lossy = mapless.open(write_capture(tmp_path / "lossy.pcap", packets[:100] + packets[110:]))
    assert len(lossy) == len(whole)
    missing = sum(len(whole[k]) for k in range(len(whole))) - sum(len(lossy[k]) for k in range(len(lossy)))
    assert missing == 10 * 12 * 32
    assert len(lossy[2]) == len(whole[2])
    np.testing.assert_array_equal(lossy[2].points, whole[2].points)


@pytest.mark.parametrize(
    ("payload", "port", "message"),
    [
        (b"\xee\xff" + bytes(1078), 2368, "packets of a Hesai sensor"),
        (bytes(6464), 7502, "packets of an Ouster sensor: give its metadata with --meta"),
        (bytes(100), 5000, "1 of 100 bytes to port 5000"),
    ],
)
def test_other_captures_are_refused_with_what_is_in_them(payload, port, message, tmp_path):
    pytest.importorskip("velodyne_decoder")
    with pytest.raises(mapless.InputError, match=message):
        mapless.open(write_capture(tmp_path / "other.pcap", [(0, payload)], port))


def test_a_missing_package_is_named_with_the_command_that_installs_it(tmp_path, monkeypatch):
    capture = write_capture(tmp_path / "drive.pcap", vlp_16_packets(0.1))
    monkeypatch.setitem(__import__("sys").modules, "dpkt", None)
    with pytest.raises(mapless.InputError, match=r"pip install 'mapless\[velodyne\]'"):
        mapless.open(capture)
    (tmp_path / "drive.json").write_text("{}")
    monkeypatch.setitem(__import__("sys").modules, "ouster.sdk", None)
    with pytest.raises(mapless.InputError, match=r"pip install 'mapless\[ouster\]'"):
        mapless.open(capture)


@pytest.mark.parametrize(
    ("name", "package", "lasers", "scans"),
    [
        ("mrpt_velodyne/sample_velodyne_hdl32.pcap", "velodyne_decoder", 32, 3),
        ("mrpt_velodyne/sample_velodyne_vlp16_gps.pcap", "velodyne_decoder", 16, 4),
        ("nebula/velodyne_vlp32/1713492677464078412", "velodyne_decoder", 32, 5),
        ("nebula/velodyne_vls128/*/*.db3", "velodyne_decoder", 128, 4),  # its metadata.yaml is not complete
        ("ouster_sdk/OS-1-128_v2.3.0_1024x10_lb_n3.pcap", "ouster.sdk", 128, 3),
    ],
)
def test_real_captures_run_end_to_end(name, package, lasers, scans, tmp_path):
    path = real(name)
    pytest.importorskip(package)
    recording = mapless.open(path)
    assert len(recording) == scans
    assert recording[1].ring.max() == lasers - 1
    survey = mapless._verbs.run_verb("info", str(path))
    assert "cannot be read" not in survey
    if recording.format == "ouster":
        assert recording.sensor == path.stem.removesuffix("_lb_n3")  # its beams are those of the metadata
    result = mapless.detect(path, tmp_path / "out")
    assert [len(result.label(k)) for k in result.scans] == [len(scan) for scan in recording]


def test_an_osf_of_the_sdk_gives_the_labels_of_its_capture(tmp_path):
    capture = real("ouster_sdk/OS-1-128_v2.3.0_1024x10_lb_n3.pcap")
    pytest.importorskip("ouster.sdk")
    from ouster.sdk import open_source, osf

    frames = open_source(str(capture), meta=[str(capture.with_name("OS-1-128_v2.3.0_1024x10.json"))])
    writer = osf.Writer(str(tmp_path / "drive.osf"), frames.sensor_info)
    for turn in frames:
        writer.save(0, turn[0])
    writer.close()
    results = [mapless.detect(path, tmp_path / path.suffix[1:]) for path in (capture, tmp_path / "drive.osf")]
    assert results[0].scans == results[1].scans == [0, 1, 2]
    for k in results[0].scans:
        np.testing.assert_array_equal(results[0].label(k), results[1].label(k))


def test_a_bag_with_incomplete_metadata_is_refused_with_the_way_out():
    pytest.importorskip("rosbags")
    with pytest.raises(mapless.InputError, match="or give one of its files: 1614315746471294674_0.db3"):
        mapless.open(real("nebula/velodyne_vls128/*/metadata.yaml").parent)

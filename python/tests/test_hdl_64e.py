"""Packets of an HDL-64E of a simulated drive, written here byte by byte. The firing times and the status bytes are those that
velodyne-decoder reads, not an account of their own."""

import struct

import numpy as np
import pytest

import mapless
from comparison import compact, iou, without_empty_rays
from test_packets import write_capture

pytest.importorskip("velodyne_decoder")
import yaml  # noqa: E402

LASERS, COLUMNS, SCANS = 64, 2082, 14  # six firings of 48 us a packet, 347 packets a turn
FIRING_S = 0.1 / COLUMNS
STEP_M = 0.002
BLOCKS = (b"\xff\xee", b"\xff\xdd")  # upper and lower lasers
STATUS = "HMSDNYGTV"  # of every 16 packets; the other seven send values of the calibration
CALIBRATION_BYTES = 1820


def firing_us(number):
    """When a laser fires within a firing: those of the upper and the lower block together, four of them every 6 us."""
    return 6.0 * (number % 32 // 4) + 1.2 * (number % 4)


def rounded(sensor):
    """The sensor with 2082 columns a turn, firing times, and what the calibration in the packets resolves: .01 degrees
    and mm."""
    lasers = []
    for row, laser in enumerate(sorted(sensor["lasers"], key=lambda laser: round(laser["elevation_deg"], 2))):
        up, turn = np.radians([laser["elevation_deg"], laser["azimuth_offset_deg"]])
        x, y, z = laser["origin_m"]
        across_m, above_m = round(float(y * np.cos(turn) - x * np.sin(turn)), 3), round(float(z / np.cos(up)), 3)
        number = (row + 32) % 64  # in the packets: 0 to 31 are the upper block
        elevation_deg, rot_deg = round(laser["elevation_deg"], 2), round(laser["azimuth_offset_deg"], 2)
        offset_deg = rot_deg - 360 * firing_us(number) * 1e-6 / 0.1  # the hub has turned on when the laser fires
        up, turn = np.radians([elevation_deg, offset_deg])
        forward_m = -above_m * np.sin(up)
        origin = [forward_m * np.cos(turn) - across_m * np.sin(turn), forward_m * np.sin(turn) + across_m * np.cos(turn)]
        model = {"elevation_deg": elevation_deg, "azimuth_offset_deg": offset_deg, "firing_offset_us": firing_us(number)}
        model["origin_m"] = [float(number) for number in (*origin, above_m * np.cos(up))]
        lasers.append({"number": number, "rot_deg": rot_deg, "above_m": above_m, "across_m": across_m, "model": model})
    return {**sensor, "columns": COLUMNS, "lasers": lasers}


@pytest.fixture(scope="module")
def native(tmp_path_factory):
    """Folder, sensor and labels of a recording whose rays that hit nothing give no evidence, as in packets. The sensor
    stands: the turns of a capture begin a packet later, and scans of a drive cut elsewhere are decided otherwise."""
    folder = tmp_path_factory.mktemp("hdl64e")
    mapless.simulate("crossing", folder / "usual", sensor="HDL-64E-S2", duration_s=0.1)
    sensor = rounded(yaml.safe_load((folder / "usual" / "sensor.yaml").read_text()))
    lasers = [laser["model"] for laser in sensor["lasers"]]
    (folder / "sensor.yaml").write_text(yaml.safe_dump({**sensor, "lasers": lasers}))
    mapless.simulate("crossing", folder / "drive", sensor=folder / "sensor.yaml", duration_s=SCANS / 10)
    without_empty_rays(folder / "drive")
    return folder / "drive", sensor, mapless.detect(folder / "drive", folder / "out", odometry=True)


def moving_by_firing(result, recording, begin_ns):
    """(SCANS * COLUMNS, LASERS): 1 where a return moves, 0 where it stands, -1 without a return."""
    out = np.full((SCANS * COLUMNS, LASERS), -1, np.int8)
    for k in result.scans:
        scan = recording[k]
        # The lasers of a firing follow each other within its 48 us; stamps of packets are whole us.
        column = np.floor(((scan.stamp_ns - begin_ns) * 1e-9 + scan.time_s) / FIRING_S + 0.02)
        hit = compact(scan) & (column >= 0) & (column < len(out))
        out[column[hit].astype(int), scan.ring[hit]] = result.moving(k)[hit]
    return out


@pytest.fixture(scope="module")
def capture(native, tmp_path_factory):
    drive, sensor, _ = native
    return write_capture(tmp_path_factory.mktemp("packets") / "drive.pcap", packets(drive, sensor))


def test_packets_of_an_hdl_64e_give_the_labels_of_the_native_recording(native, capture, tmp_path):
    drive, _, expected = native
    recording = mapless.open(capture)
    assert len(recording) == SCANS
    result = mapless.detect(capture, tmp_path / "out")
    begin_ns = mapless.open(drive)[0].stamp_ns
    found = moving_by_firing(result, recording, begin_ns)
    expected = moving_by_firing(expected, mapless.open(drive), begin_ns)
    both = (found >= 0) & (expected >= 0)
    assert both.sum() > 0.999 * (expected >= 0).sum()
    # Packets have ranges in steps of 2 mm. Along own odometry these alone change the labels of drives by .0003 to .06.
    assert iou(found[both] == 1, expected[both] == 1) > 0.98


def test_a_calibration_file_gives_the_points_that_the_calibration_in_the_packets_gives(native, capture, tmp_path):
    by_packets, by_file = (
        mapless.open(capture, sensor=sensor) for sensor in ("", calibration_file(tmp_path / "unit.yaml", native[1]))
    )
    # The beams are recovered: points are turned by the times within a firing, which the file does not say.
    assert by_file.sensor == by_packets.sensor == "estimated from the points"
    np.testing.assert_allclose(by_file[5].points, by_packets[5].points, atol=1e-3)


def by_number(sensor):
    return sorted(sensor["lasers"], key=lambda laser: laser["number"])


def calibration_values(sensor):
    """The 1820 bytes of calibration: start, thresholds, 28 bytes a laser, and the length that an S2 sends as the end."""
    data = b"UNIT#" + bytes(2)
    for i, laser in enumerate(by_number(sensor)):
        angles = [round(100 * angle) for angle in (laser["model"]["elevation_deg"], laser["rot_deg"])]
        offsets = [round(1000 * laser[key]) for key in ("above_m", "across_m")]
        data += struct.pack("<BhhhhhhhhhBB", i, *angles, 0, 0, 0, *offsets, 0, 0, 0, 255) + bytes(7)
    data = data[:-7] + bytes([24, 1, 2, 3, 4, 5, 0])  # when it was calibrated
    return data + struct.pack("<hHH", 600, 0, 35999) + bytes(13) + struct.pack("<H", CALIBRATION_BYTES)


def calibration_file(path, sensor):
    """The same as a YAML file of Velodyne."""
    lasers = [
        {
            "laser_id": i,
            "vert_correction": float(np.radians(laser["model"]["elevation_deg"])),
            "rot_correction": float(np.radians(laser["rot_deg"])),
            "vert_offset_correction": laser["above_m"],
            "horiz_offset_correction": laser["across_m"],
            "dist_correction": 0.0,
            "dist_correction_x": 0.0,
            "dist_correction_y": 0.0,
            "focal_distance": 0.0,
            "focal_slope": 0.0,
        }
        for i, laser in enumerate(by_number(sensor))
    ]
    path.write_text(yaml.safe_dump({"num_lasers": LASERS, "distance_resolution": STEP_M, "lasers": lasers}))
    return path


def ranges_of(scan, sensor):
    """(LASERS, COLUMNS) [m] from the origin of each laser; NaN without a return; and hub azimuth of each column."""
    azimuth = np.radians(sensor["start_azimuth_deg"]) - 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    points = scan.points.astype(np.float64).reshape(LASERS, COLUMNS, 3)
    x, y, z = np.moveaxis(np.array([laser["model"]["origin_m"] for laser in sensor["lasers"]])[:, None, :], -1, 0)
    origin = np.stack([x * np.cos(azimuth) - y * np.sin(azimuth), x * np.sin(azimuth) + y * np.cos(azimuth), z + 0 * azimuth], -1)
    return np.linalg.norm(points - origin, axis=-1), azimuth


def packets(drive, sensor):
    values = calibration_values(sensor)
    rows, sent = np.argsort([laser["number"] for laser in sensor["lasers"]]), 0
    for scan in mapless.open(drive):
        ranges, azimuth = ranges_of(scan, sensor)
        raw = np.nan_to_num(np.round(ranges / STEP_M)).astype(int)[rows]
        hundredths = np.round(-np.degrees(azimuth) * 100).astype(int) % 36000
        for first in range(0, COLUMNS, 6):
            data = b""
            for column in range(first, first + 6):
                for half, start in enumerate(BLOCKS):
                    block = [part for distance in raw[32 * half : 32 * half + 32, column] for part in (distance, 100)]
                    data += start + struct.pack("<H" + "HB" * 32, hundredths[column], *block)
            time_us = scan.stamp_ns * 1e-3 + first * FIRING_S * 1e6
            yield time_us, data + struct.pack("<LBB", round(time_us), *status_of(sent, values))
            sent += 1


def status_of(packet, values):
    """Kind and value of the status in this packet."""
    cycle, place = divmod(packet, 16)
    if place < len(STATUS):
        return ord(STATUS[place]), 1
    kind = 0xF0 + place - len(STATUS)
    return kind, values[(7 * cycle + place - len(STATUS)) % CALIBRATION_BYTES]

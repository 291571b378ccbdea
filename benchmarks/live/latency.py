#!/usr/bin/env python3
"""Plays a simulated drive to `mapless live` at the pace of the sensor, over DDS on the loopback interface, and prints the
latency that the node states: from the arrival of the newest cloud that the labels of a cloud need (the next one, with
--causal its own) to the labels; and the processor time and memory of the node. Needs numpy and cyclonedds from PyPI.

usage: latency.py MAPLESS DRIVE [--rate HZ] [OPTION OF mapless live ...]

    mapless simulate town2 -o drive --sensor OS1-128 --duration-s 20
    python3 benchmarks/live/latency.py mapless drive --sensor OS1-128
"""

import os
import pathlib
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "live"))
import live_client  # noqa: E402
import numpy as np  # noqa: E402
from live_client import EPOCH_NS, FIELDS, NS_PER_S, Client  # noqa: E402
from ros2_types import Header, PointCloud2, PointField  # noqa: E402

PCD = np.dtype([("x", "f4"), ("y", "f4"), ("z", "f4"), ("t", "u4"), ("code", "u1"), ("intensity", "u1")])
POINT = np.dtype(
    [("x", "f4"), ("y", "f4"), ("z", "f4"), ("intensity", "f4"), ("ring", "u2"), ("time", "f4")]
)  # as the Velodyne driver packs it


def cloud(file, ns):
    text, _, data = file.read_bytes().partition(b"DATA binary\n")
    header = dict(line.split(" ", 1) for line in text.decode().splitlines() if " " in line)
    scan = np.frombuffer(data, PCD)
    points = np.zeros(len(scan), POINT)
    for axis in "xyz":
        points[axis] = np.where(scan["code"] == 0, scan[axis], np.nan)
    points["ring"] = np.arange(len(scan)) // int(header["WIDTH"])
    points["time"] = scan["t"] * 1e-9
    return PointCloud2(
        header=Header(live_client.stamp(ns), "lidar"),
        height=1,
        width=len(points),
        fields=[PointField(name, offset, kind, 1) for name, offset, kind in FIELDS],
        is_bigendian=False,
        point_step=POINT.itemsize,
        row_step=POINT.itemsize * len(points),
        data=points.tobytes(),
        is_dense=False,
    )


def main():
    mapless, drive, *options = sys.argv[1:]
    rate = 10.0
    if "--rate" in options:
        at = options.index("--rate")
        rate = float(options[at + 1])
        del options[at : at + 2]
    node = subprocess.Popen([mapless, "live", *options])
    try:
        client = Client({"points_labelled": PointCloud2})  # the node makes nothing that nobody reads
        client.wait_for_node()
        start = time.monotonic()
        for k, file in enumerate(sorted((pathlib.Path(drive) / "scans").iterdir())):
            message = cloud(file, EPOCH_NS + round(k * NS_PER_S / rate))
            time.sleep(max(0.0, start + k / rate - time.monotonic()))
            client.points.write(message)
            client.collect(1)
            client.received["points_labelled"].clear()
        time.sleep(1)
        node.send_signal(signal.SIGINT)
        _, status, usage = os.wait4(node.pid, 0)
        node.returncode = os.waitstatus_to_exitcode(status)
        user_ms, system_ms = (1e3 * seconds / (k + 1) for seconds in (usage.ru_utime, usage.ru_stime))
        print(f"processor time of the node {user_ms:.1f} ms a cloud, of the system for it {system_ms:.1f} ms")
        print(f"largest memory of the node {usage.ru_maxrss / 1024:.0f} MB")
        sys.exit(node.returncode)
    finally:
        node.kill()


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Two lidars on one vehicle, a `mapless live` each: the first estimates the motion and writes it to tf, the second is
labelled along it, on a clock of its own.

usage: live_rig_client.py MAPLESS RIG      RIG: of mapless simulate --rig, VLP-16 named roof and bumper
"""

import json
import pathlib
import re
import signal
import subprocess
import sys

from live_client import (
    DRIVER,
    EPOCH_NS,
    NS_PER_S,
    STATIC,
    Client,
    PointCloud2,
    TFMessage,
    check_labels,
    cloud_of,
    read_scan,
    transform,
)

BEHIND_NS = 3 * NS_PER_S // 2  # the clock of the bumper
SENSORS = ("roof", "bumper")


def place_of(rig, name):
    """Position and orientation of a sensor on the vehicle."""
    line = re.search(rf'name: "{name}".*?(position_m: .*?\]).*?(quaternion_xyzw: .*?\])', rig, re.DOTALL)
    return [number for part in line.groups() for number in json.loads(part.split(": ")[1])]


def node(command, name, *options):
    topics = ["--points", f"{name}/points", "--prefix", f"{name}/"]
    return subprocess.Popen([command, "live", "--sensor", "VLP-16", *topics, *options])


def run(rig):
    client = Client({f"{name}/points_labelled": PointCloud2 for name in SENSORS})
    clouds = {name: client.writer(f"{name}/points", PointCloud2, DRIVER) for name in SENSORS}
    static = client.writer("tf_static", TFMessage, STATIC)
    text = (rig / "rig.yaml").read_text()
    static.write(TFMessage([transform("base_link", name, EPOCH_NS, place_of(text, name)) for name in SENSORS]))
    client.wait_until(lambda: all(writer.get_matched_subscriptions() for writer in clouds.values()))
    client.wait_until(lambda: all(reader.get_matched_publications() for reader in client.readers.values()))
    count = len(list((rig / "roof" / "scans").iterdir()))
    truth = {name: {} for name in SENSORS}
    for k in range(count):
        for name in SENSORS:
            points, moving = read_scan(rig / name, k)
            ns = EPOCH_NS + k * NS_PER_S // 10 - (BEHIND_NS if name == "bumper" else 0)
            truth[name][ns] = points, moving
            clouds[name].write(cloud_of(points, ns, name))
        client.collect(100)
    for _ in range(20):
        client.collect(100)
    for name in SENSORS:
        received = client.received[f"{name}/points_labelled"]
        check_labels(received, truth[name])
        assert len(received) >= count - 3, f"{name}: {len(received)} of {count}"


def main():
    command, rig = sys.argv[1], pathlib.Path(sys.argv[2])
    nodes = [
        node(command, "roof", "--publish-tf", "--base-frame", "base_link"),
        # The start of the odometry, too, is labelled where its clouds wait for it.
        node(command, "bumper", "--motion=tf", f"--clock-offset-s={BEHIND_NS / NS_PER_S}", "--pose-wait-s=9"),
    ]
    try:
        run(rig)
        for one in nodes:
            one.send_signal(signal.SIGINT)
        assert [one.wait(timeout=30) for one in nodes] == [0, 0], "an exit code after SIGINT is not 0"
    finally:
        for one in nodes:
            one.kill()
    print("two lidars: passed")


if __name__ == "__main__":
    main()

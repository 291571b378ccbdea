#!/usr/bin/env python3
"""Drives `mapless live` as a driver and as a user of ROS 2 do, with another DDS library on the loopback interface:
clouds of a simulated drive and its poses go in, and what comes out is compared with the truth.

usage: live_client.py MAPLESS DRIVE MOTION      DRIVE: of mapless simulate, VLP-16; MOTION: tf or own
"""

import os
import pathlib
import random
import signal
import struct
import subprocess
import sys
import tempfile

# Participants announce themselves every second: by default it is every 30 s, so that where the first announcement meets
# nobody, or is lost, nothing is found for as long.
LOOPBACK = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<Peers><Peer Address="127.0.0.1"/></Peers><SPDPInterval>1s</SPDPInterval></Discovery>
<Internal><SocketReceiveBufferSize max="4MB"/></Internal></Domain></CycloneDDS>"""
os.environ["CYCLONEDDS_URI"] = LOOPBACK
DOMAIN = random.SystemRandom().randrange(100, 200)  # other tests may run
os.environ["ROS_DOMAIN_ID"] = str(DOMAIN)

from cyclonedds.core import Policy, Qos  # noqa: E402
from cyclonedds.domain import DomainParticipant  # noqa: E402
from cyclonedds.pub import DataWriter  # noqa: E402
from cyclonedds.sub import DataReader  # noqa: E402
from cyclonedds.topic import Topic  # noqa: E402
from cyclonedds.util import duration  # noqa: E402
from ros2_types import (  # noqa: E402
    Detection3DArray,
    DiagnosticArray,
    EmptyReply,
    EmptyRequest,
    Float64,
    Header,
    Imu,
    Odometry,
    PointCloud2,
    Point,
    PointField,
    Pose,
    PoseWithCovariance,
    Quaternion,
    TFMessage,
    Time,
    Transform,
    TransformStamped,
    TriggerReply,
    TriggerRequest,
    Twist,
    TwistWithCovariance,
    Vector3,
)

EPOCH_NS = 1_790_000_000_000_000_000
NS_PER_S = 1_000_000_000
STEP = 22
MOVING_CLASS = 251
RELIABLE = Policy.Reliability.Reliable(duration(milliseconds=100))
DRIVER = Qos(RELIABLE, Policy.Durability.Volatile, Policy.History.KeepLast(5))
USER = Qos(RELIABLE, Policy.Durability.Volatile, Policy.History.KeepLast(50))
STATIC = Qos(RELIABLE, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
FIELDS = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7), ("ring", 16, 4), ("time", 18, 7)]

OUTPUTS = {"points_labelled": PointCloud2, "points_static": PointCloud2, "points_moving": PointCloud2}
OUTPUTS |= {"objects": Detection3DArray, "odometry": Odometry, "diagnostics": DiagnosticArray}
OUTPUTS |= {"debug/processing_time_ms": Float64}


def stamp(ns):
    return Time(sec=ns // NS_PER_S, nanosec=ns % NS_PER_S)


def read_scan(drive, k):
    """Points as the Velodyne driver packs them, and whether each moves in truth."""
    text, _, data = (drive / "scans" / f"{k:06d}.pcd").read_bytes().partition(b"DATA binary\n")
    header = dict(line.split(" ", 1) for line in text.decode().splitlines() if " " in line)
    assert header["FIELDS"] == "x y z t code intensity", header["FIELDS"]
    width = int(header["WIDTH"])  # columns; a row is a laser
    labels = (drive / "labels" / f"{k:06d}.label").read_bytes()
    points, moving = bytearray(), []
    for i, (x, y, z, t, code, _) in enumerate(struct.iter_unpack("<fffIBB", data)):
        if code != 0 or i % 2:  # no return, or left out: 200 kB fit into the default buffer of a socket
            continue
        points += struct.pack("<ffffHf", x, y, z, 1.0, i // width, t * 1e-9)
        moving.append(struct.unpack_from("<I", labels, 4 * i)[0] & 0xFFFF == MOVING_CLASS)
    return bytes(points), moving


def cloud_of(points, ns, frame="lidar"):
    return PointCloud2(
        header=Header(stamp(ns), frame),
        height=1,
        width=len(points) // STEP,
        fields=[PointField(name, offset, kind, 1) for name, offset, kind in FIELDS],
        is_bigendian=False,
        point_step=STEP,
        row_step=len(points),
        data=points,
        is_dense=True,
    )


def poses_of(drive):
    """TUM rows: time, position, orientation of the sensor in the world."""
    for line in (drive / "trajectory.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        t, *numbers = (float(word) for word in line.split())
        yield EPOCH_NS + round(t * NS_PER_S), numbers


def transform(parent, child, ns, numbers):
    x, y, z, qx, qy, qz, qw = numbers
    motion = Transform(Vector3(x, y, z), Quaternion(qx, qy, qz, qw))
    return TransformStamped(Header(stamp(ns), parent), child, motion)


def measurements_of(drive):
    """What an inertial sensor and wheels in the place of the lidar measure: stamp, Imu, Odometry."""
    poses = list(poses_of(drive))
    for (ns, a), (later, b) in zip(poses, poses[1:], strict=False):
        dt = (later - ns) / NS_PER_S
        speed = sum((q - p) ** 2 for p, q in zip(a[:3], b[:3], strict=True)) ** 0.5 / dt
        (ax, ay, az, aw), (bx, by, bz, bw) = a[3:], b[3:]
        # The vector of conj(a) b, which is half of a small angle.
        turn = (
            aw * bx - ax * bw - ay * bz + az * by,
            aw * by - ay * bw - az * bx + ax * bz,
            aw * bz - az * bw - ax * by + ay * bx,
        )
        sign = 2 if aw * bw + ax * bx + ay * by + az * bz > 0 else -2
        angular = Vector3(*(sign * part / dt for part in turn))
        zero, upright = Vector3(0.0, 0.0, 0.0), Quaternion(0.0, 0.0, 0.0, 1.0)
        header, nine, many = Header(stamp((ns + later) // 2), "lidar"), [0.0] * 9, [0.0] * 36
        imu = Imu(header, upright, nine, angular, nine, zero, nine)
        pose = PoseWithCovariance(Pose(Point(0.0, 0.0, 0.0), upright), many)
        twist = TwistWithCovariance(Twist(Vector3(speed, 0.0, 0.0), angular), many)
        yield ns, imu, Odometry(header, "lidar", pose, twist)


def stamp_of(message):
    return message.header.stamp.sec * NS_PER_S + message.header.stamp.nanosec


class Client:
    def __init__(self, read=OUTPUTS, driver=True):
        self.participant = DomainParticipant(DOMAIN)
        if driver:
            self.drive()
        self.kinds = read
        self.readers = {
            name: DataReader(self.participant, Topic(self.participant, f"rt/{name}", kind), qos=USER)
            for name, kind in read.items()
        }
        self.received = {name: [] for name in read}

    def drive(self):
        self.points = self.writer("points", PointCloud2, DRIVER)
        self.tf = self.writer("tf", TFMessage, DRIVER)
        self.imu = self.writer("imu", Imu, DRIVER)
        self.wheels = self.writer("wheel_odometry", Odometry, DRIVER)
        self.tf_static = self.writer("tf_static", TFMessage, STATIC)

    def writer(self, name, kind, qos):
        return DataWriter(self.participant, Topic(self.participant, f"rt/{name}", kind), qos=qos)

    def call(self, service, request_kind, reply_kind):
        """The reply, as a client of rmw_cyclonedds gets it; that to another client's request is not ours."""
        requests = Topic(self.participant, f"rq/{service}Request", request_kind)
        replies = Topic(self.participant, f"rr/{service}Reply", reply_kind)
        writer = DataWriter(self.participant, requests, qos=DRIVER)
        reader = DataReader(self.participant, replies, qos=USER)
        self.wait_until(lambda: writer.get_matched_subscriptions() and reader.get_matched_publications())
        request = request_kind(client=0x0123456789ABCDEF, number=7)
        writer.write(request)
        for reply in reader.take_iter(timeout=duration(seconds=10)):
            assert (reply.client, reply.number) == (request.client, request.number), reply
            return reply
        sys.exit(f"service {service} does not reply")

    def collect(self, milliseconds):
        """What has come, at once where labels (of the first reader) have come, else after so long."""
        first = next(iter(self.readers))
        for message in self.readers[first].take_iter(timeout=duration(milliseconds=milliseconds)):
            self.received[first].append(message)
            break
        for name, reader in self.readers.items():
            self.received[name] += [m for m in reader.take(N=50) if isinstance(m, self.kinds[name])]

    def wait_until(self, is_found):
        for _ in range(300):
            if is_found():
                return
            self.collect(100)
        sys.exit("mapless live was not found within 30 s")

    def wait_for_node(self):
        labelled = self.readers["points_labelled"]
        self.wait_until(lambda: self.points.get_matched_subscriptions() and labelled.get_matched_publications())


def check_labels(received, truth):
    found = {True: [0, 0], False: [0, 0]}
    for message in received:
        names = [field.name for field in message.fields]
        assert names == [*(name for name, _, _ in FIELDS), "object_id", "moving", "probability"], names
        points, moving = truth[stamp_of(message)]
        data, step = bytes(message.data), message.point_step
        assert message.width == len(moving) and len(data) == step * message.width
        for i, is_moving in enumerate(moving):
            point = data[i * step : (i + 1) * step]
            assert point[:STEP] == points[i * STEP : (i + 1) * STEP], "a field has changed on its way"
            assert (point[28] == 1) == (struct.unpack_from("<I", point, 24)[0] != 0)
            found[is_moving][point[28] == 1] += 1
    recall = found[True][1] / sum(found[True])
    precision = found[True][1] / (found[True][1] + found[False][1])
    print(f"{len(received)} labelled clouds, precision {precision:.3f}, recall {recall:.3f}")
    assert precision > 0.7 and recall > 0.5


def diagnostics_after(client, count):
    """The message and values of the first diagnostics, which come once a second, that count at least `count` clouds."""
    for _ in range(100):
        status = client.received["diagnostics"][-1].status[0]
        values = {value.key: value.value for value in status.values}
        if int(values["clouds"]) >= count:
            break
        client.collect(100)
    return status.message, values


def check_services(client, static_map):
    """The map is written; without its folder, and after a reset, the reply says why it is not."""

    def save():
        reply = client.call("labeller/save_static_map", TriggerRequest, TriggerReply)
        print(reply.message)
        assert "\n" not in reply.message
        return reply

    saved = save()
    assert saved.success
    header, _, _ = static_map.read_bytes().partition(b"DATA binary\n")
    points = dict(line.split(" ", 1) for line in header.decode().splitlines())["POINTS"]
    assert f"{static_map}: {points} points" in saved.message and int(points) > 1000
    static_map.unlink()
    static_map.parent.rmdir()  # fails where anything is left beside the map
    saved = save()
    assert not saved.success and "No such file" in saved.message
    client.call("labeller/reset", EmptyRequest, EmptyReply)
    client.wait_until(lambda: "no cloud with labels" in save().message)


def run(client, drive, own_odometry):
    count = len(list((drive / "scans").iterdir()))
    truth = {}
    if not own_odometry:
        client.tf_static.write(TFMessage([transform("base_link", "lidar", EPOCH_NS, (0, 0, 0, 0, 0, 0, 1))]))
        for ns, numbers in poses_of(drive):
            client.tf.write(TFMessage([transform("odom", "base_link", ns, numbers)]))
            client.collect(1)
    measured = list(measurements_of(drive)) if own_odometry else []
    for k in range(count):
        while measured and measured[0][0] < EPOCH_NS + (k + 1) * NS_PER_S // 10:
            _, imu, wheels = measured.pop(0)
            client.imu.write(imu)
            client.wheels.write(wheels)
        points, moving = read_scan(drive, k)
        ns = EPOCH_NS + k * NS_PER_S // 10
        truth[ns] = points, moving
        client.points.write(cloud_of(points, ns))
        client.collect(100)
    for _ in range(100):
        if len(client.received["points_labelled"]) >= count - 3:
            break
        client.collect(100)
    check_labels(client.received["points_labelled"], truth)
    assert len(client.received["points_labelled"]) >= count - 3
    assert len(client.received["objects"]) >= count - 3
    assert any(message.detections for message in client.received["objects"])
    moved = sum(message.width for message in client.received["points_moving"])
    stood = sum(message.width for message in client.received["points_static"])
    assert 0 < moved < stood
    assert bool(client.received["odometry"]) == own_odometry
    times = [message.data for message in client.received["debug/processing_time_ms"]]
    assert len(times) > count / 2 and all(0 < time < 5000 for time in times), times
    message, values = diagnostics_after(client, count)
    print(f"diagnostics: {message}: {values}")
    assert values["dropped"] == "0", values
    assert (int(values["measurements"]) > 10 * count) == own_odometry, values
    assert values["motion"] == "good", values


def main():
    command, drive, motion = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    static_map = pathlib.Path(tempfile.mkdtemp()) / "map.pcd"
    options = ["--static-map-file", str(static_map)]
    options += ["--use-imu", "--use-wheel-odometry"] if motion == "own" else []
    node = subprocess.Popen([command, "live", "--sensor", "VLP-16", "--motion", motion, *options])
    try:
        client = Client()
        client.wait_for_node()
        run(client, drive, own_odometry=motion == "own")
        check_services(client, static_map)
        node.send_signal(signal.SIGINT)
        assert node.wait(timeout=30) == 0, "the exit code after SIGINT is not 0"
    finally:
        node.kill()
    print(f"motion {motion}: passed")


if __name__ == "__main__":
    main()

"""ROS 1 bags, rosbag2 folders (sqlite3, MCAP) and MCAP files with sensor_msgs/PointCloud2, read by rosbags."""

from __future__ import annotations

import pathlib
import threading
from collections.abc import Iterator
from typing import Any

from mapless._core import InputError
from mapless._fields import Fields
from mapless._recording import CloudSource
from mapless.readers.options import Options
from mapless.readers import velodyne
from mapless.readers.bag_motion import measurements_of_bag
from mapless.readers.bag_poses import poses_of_bag
from mapless.readers.clouds import fields_of_cloud, first_instant_ns
from mapless.readers.point_cloud2 import cloud_of

CLOUD_TYPE = "sensor_msgs/msg/PointCloud2"
PACKET_TYPE = "velodyne_msgs/msg/VelodyneScan"
LIVOX = "a Livox sensor, whose pattern does not repeat; mapless needs a spinning lidar"
PACKETS = "packets that no library of mapless decodes; replay the bag through the driver and record its PointCloud2"
UNREADABLE_TYPES = {
    "livox_ros_driver/msg/CustomMsg": LIVOX,
    "livox_ros_driver2/msg/CustomMsg": LIVOX,
    "pandar_msgs/msg/PandarScan": PACKETS,
    "nebula_msgs/msg/NebulaPackets": PACKETS,
    "ouster_sensor_msgs/msg/PacketMsg": PACKETS,
    "ouster_ros/msg/PacketMsg": PACKETS,
}
# Bags of ROS 2 before Iron do not define their types.
VELODYNE_TYPES = {
    PACKET_TYPE: "std_msgs/Header header\nvelodyne_msgs/VelodynePacket[] packets",
    "velodyne_msgs/msg/VelodynePacket": "builtin_interfaces/Time stamp\nuint8[1206] data",
}
READABLE_TYPES = (CLOUD_TYPE, PACKET_TYPE)
SUFFIXES = {".bag": "rosbag1", ".mcap": "mcap", ".db3": "rosbag2"}


def open_reader(path: pathlib.Path) -> Any:
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError:
        raise InputError(f"{path}: bags are read by the package rosbags: pip install 'mapless[bags]'") from None
    paths = sorted(path.glob("*.bag")) if path.is_dir() and not (path / "metadata.yaml").exists() else [path]
    store = get_typestore(Stores.ROS2_HUMBLE)  # PointCloud2 has not changed since
    for name, text in VELODYNE_TYPES.items():
        store.register(get_types_from_msg(text, name))
    try:
        reader = AnyReader(paths, default_typestore=store)
        reader.open()
    except (AnyReaderError, OSError, ValueError, AssertionError, KeyError) as error:
        parts = sorted(file.name for file in path.glob("*") if file.suffix in (".db3", ".mcap"))
        instead = f", or give one of its files: {', '.join(parts)}" if parts else ""
        raise InputError(f"{path}: not a complete bag: {error}; 'ros2 bag reindex' may repair it{instead}") from None
    return reader


def choose_topic(reader: Any, path: pathlib.Path, wanted: str | None) -> str:
    """Of clouds; of packets that can be decoded where there are no clouds."""
    of_type = {kind: sorted({c.topic for c in reader.connections if c.msgtype == kind}) for kind in READABLE_TYPES}
    clouds: list[str] = next((topics for topics in of_type.values() if topics), [])
    if wanted is not None and any(wanted in topics for topics in of_type.values()):
        return wanted
    if wanted is not None:
        raise InputError(f"{path}: topic {wanted}: not one of its PointCloud2 topics: {', '.join(clouds) or 'none'}")
    if len(clouds) > 1:
        raise InputError(f"{path}: several PointCloud2 topics: {', '.join(clouds)}; choose one with --topic")
    if not clouds:
        for connection in reader.connections:
            if connection.msgtype in UNREADABLE_TYPES:
                raise InputError(f"{path}: {connection.topic} is of {UNREADABLE_TYPES[connection.msgtype]}")
        topics = ", ".join(sorted({f"{c.topic} ({c.msgtype})" for c in reader.connections}))
        raise InputError(f"{path}: no PointCloud2 topic; its topics are {topics or 'none'}")
    return clouds[0]


def stamp_of(message: Any) -> int:
    return int(message.header.stamp.sec) * 1_000_000_000 + int(message.header.stamp.nanosec)


class Bag(CloudSource):
    def __init__(self, path: pathlib.Path, options: Options) -> None:
        self.path = str(path)
        self.format = "rosbag2" if path.is_dir() else SUFFIXES[path.suffix]
        self._reader = open_reader(path)
        self.topic = choose_topic(self._reader, path, options.topic)
        self._connections = [c for c in self._reader.connections if c.topic == self.topic]
        self._lock = threading.Lock()
        self._packets: velodyne.PacketMessages | None = None
        if self._connections[0].msgtype == PACKET_TYPE:
            self._packets = velodyne.PacketMessages(self._first_message().packets, self.path, options.sensor)
        self._messages: Iterator[Any] = iter(())
        self._next = -1  # the scan that _messages gives next
        self._received_ns: list[int] = []
        self.starts_ns = []
        self._index()
        if self._packets is not None:
            self.sensor, self.recovers_sensor = self._packets.sensor, self._packets.recovers_sensor
        frame = str(self._first_message().header.frame_id)
        if options.pose_topic is not None:
            self.trajectory, note = poses_of_bag(self._reader, self.path, options, frame)
            self.notes.append(note)
        span_ns = (self.starts_ns[0], self.starts_ns[-1])
        self.measurements, of_motion = measurements_of_bag(self._reader, self.path, options, frame, span_ns)
        self.notes += of_motion

    def read(self, k: int) -> Fields:
        fields, _ = self._fields(self._message(k), k)
        return fields

    def scan_name(self, k: int) -> str:
        return f"{self.path} {self.topic} message {k}"

    def _index(self) -> None:
        """Reads every message once, for the instant of its first point."""
        notes: list[str] = []
        for k, (connection, received_ns, data) in enumerate(self._reader.messages(self._connections)):
            self._received_ns.append(received_ns)
            fields, found = self._fields(self._reader.deserialize(data, connection.msgtype), k)
            self.starts_ns.append(first_instant_ns(fields))
            notes += [note for note in found if note not in notes]
        if not self.starts_ns:
            raise InputError(f"{self.path}: topic {self.topic}: no messages")
        self.notes = [f"scans: messages of topic {self.topic}", *notes]
        if self._packets is None:
            self.notes.append("points are taken as measured, not motion-compensated: PointCloud2 does not define this")

    def _fields(self, message: Any, k: int) -> tuple[Fields, list[str]]:
        if self._packets is not None:
            return self._packets.fields(message.packets, self.scan_name(k))
        stamp_ns = stamp_of(message)
        name = self.scan_name(k)
        fields, notes = fields_of_cloud(cloud_of(message, name), stamp_ns or self._received_ns[k], message.height, name)
        if stamp_ns == 0:
            notes.append("times: of scans from when they were received: their stamps are 0")
        return fields, notes

    def _first_message(self) -> Any:
        for connection, _, data in self._reader.messages(self._connections):
            return self._reader.deserialize(data, connection.msgtype)
        raise InputError(f"{self.path}: topic {self.topic}: no messages")

    def _message(self, k: int) -> Any:
        with self._lock:
            if k != self._next:
                received_ns = self._received_ns[k]
                self._messages = iter(self._reader.messages(self._connections, start=received_ns))
                for _ in range(k - self._received_ns.index(received_ns)):
                    next(self._messages)
            connection, _, data = next(self._messages)
            self._next = k + 1
        return self._reader.deserialize(data, connection.msgtype)


class BagReader:
    formats = ("rosbag1", "rosbag2", "mcap")

    def fits(self, path: pathlib.Path) -> bool:
        if path.is_dir():
            return (path / "metadata.yaml").exists() or any(path.glob("*.bag"))
        return path.is_file() and path.suffix in SUFFIXES

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        return Bag(path, options)

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
from mapless.readers.point_cloud2 import cloud_of, fields_of_cloud, first_instant_ns

CLOUD_TYPE = "sensor_msgs/msg/PointCloud2"
UNREADABLE_TYPES = {
    "livox_ros_driver/msg/CustomMsg": "a Livox sensor, whose pattern does not repeat; mapless needs a spinning lidar",
    "livox_ros_driver2/msg/CustomMsg": "a Livox sensor, whose pattern does not repeat; mapless needs a spinning lidar",
    "velodyne_msgs/msg/VelodyneScan": "packets; replay the bag through the driver and record its PointCloud2",
}
SUFFIXES = {".bag": "rosbag1", ".mcap": "mcap", ".db3": "rosbag2"}


def open_reader(path: pathlib.Path) -> Any:
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(f"{path}: bags are read by the package rosbags: pip install 'mapless[bags]'") from None
    paths = sorted(path.glob("*.bag")) if path.is_dir() and not (path / "metadata.yaml").exists() else [path]
    try:
        # Bags of ROS 2 before Iron have no definitions of their types; those of PointCloud2 have not changed.
        reader = AnyReader(paths, default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        reader.open()
    except (AnyReaderError, OSError, ValueError, AssertionError, KeyError) as error:
        raise InputError(f"{path}: not a complete bag: {error}; 'ros2 bag reindex' may repair it") from None
    return reader


def choose_topic(reader: Any, path: pathlib.Path, wanted: str | None) -> str:
    clouds: list[str] = sorted({c.topic for c in reader.connections if c.msgtype == CLOUD_TYPE})
    if wanted is not None and wanted in clouds:
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
        self._messages: Iterator[Any] = iter(())
        self._next = -1  # the scan that _messages gives next
        self._received_ns: list[int] = []
        self.starts_ns = []
        self._index()

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
        self.notes.append("points are taken as measured, not motion-compensated: PointCloud2 does not define this")

    def _fields(self, message: Any, k: int) -> tuple[Fields, list[str]]:
        stamp_ns = stamp_of(message)
        name = self.scan_name(k)
        fields, notes = fields_of_cloud(cloud_of(message, name), stamp_ns or self._received_ns[k], message.height, name)
        if stamp_ns == 0:
            notes.append("times: of scans from when they were received: their stamps are 0")
        return fields, notes

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

    def open(self, path: pathlib.Path, options: Options) -> CloudSource:
        return Bag(path, options)

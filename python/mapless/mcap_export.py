"""A labelled drive as one MCAP file: clouds, poses and boxes, for Foxglove, Lichtblick and Rerun.

/points   sensor_msgs/msg/PointCloud2 in the frame of the sensor at the start of each scan, motion-compensated:
          x, y, z, label (0 unknown, 9 static, 251 dynamic), object (its number), record (number in the input), and probability
          where the result has it
/tf       tf2_msgs/msg/TFMessage: world from sensor at these instants
/objects  foxglove.SceneUpdate: of each moving object its box and velocity, in the world, as objects.csv has them
"""

from __future__ import annotations

import argparse
import decimal
import os
import pathlib
import sys
import tempfile
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from mapless._core import InputError
from mapless._result import Result
from mapless._verbs import CommandError, run_verb

NOT_DONE = 3  # exit code (docs/reliability.md)
WORLD, SENSOR = "world", "lidar"
SCANS_AT_ONCE = 16  # written as PCD files, some 50 MB, before they are read
POSES_PER_SCAN = 10  # rows of trajectory.txt (docs/formats.md)
# Type of a PCD field: NumPy's name, and PointField's number in ROS 2.
PCD_TYPES = {("F", "4"): ("<f4", 7), ("F", "8"): ("<f8", 8), ("U", "4"): ("<u4", 6)}
# Colours that colour-blind people tell apart (Okabe and Ito), as the page of `mapless view` has them.
COLOURS = ["#f0a514", "#56b4e9", "#00b282", "#eb6414", "#d682b2", "#ded032", "#4682f0", "#a0dc78"]


def export_mcap(
    recording: str | os.PathLike[str],
    result: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    scans: str = "",
    every: int = 1,
    options: Sequence[str] = (),
) -> int:
    """Writes the MCAP file and returns the number of its scans. `scans`: "A:B", both included; `options`: how the
    recording is to be read, as words of the command line."""
    labelled = Result(result)
    numbers = _selected(labelled.scans, scans)[::every]
    starts = _starts_ns(labelled)
    poses = dict(zip(labelled.scans, labelled.poses(), strict=True))
    objects = labelled.objects()
    partial = pathlib.Path(f"{os.fspath(output)}.partial")
    with partial.open("wb") as file:
        writer = McapDrive(file)
        for number, names, types, points in _clouds(recording, result, numbers, every, options):
            writer.add_pose(starts[number], poses[number])
            writer.add_points(starts[number], names, types, points)
            writer.add_objects(starts[number], objects[objects["scan"] == number])
        writer.finish()
    partial.replace(output)
    return len(numbers)


def _selected(numbers: list[int], scans: str) -> list[int]:
    first, _, last = scans.partition(":") if ":" in scans else (scans, "", scans)
    chosen = [n for n in numbers if (not first or n >= int(first)) and (not last or n <= int(last))]
    if not chosen:
        raise InputError(f"--scans {scans}: no such scan; the result has {numbers[0]} to {numbers[-1]}")
    return chosen


def _starts_ns(result: Result) -> dict[int, int]:
    """Start of each labelled scan: a float64 has not the digits of nanoseconds since 1970."""
    rows = (result.path / "trajectory.txt").read_text(encoding="ascii").splitlines()
    times = [row.split()[0] for row in rows if row and not row.startswith("#")][::POSES_PER_SCAN]
    return {n: int(decimal.Decimal(t) * 10**9) for n, t in zip(result.scans, times, strict=False)}


def _clouds(
    recording: str | os.PathLike[str], result: str | os.PathLike[str], numbers: list[int], every: int, options: Sequence[str]
) -> Iterator[tuple[int, list[str], list[int], npt.NDArray[Any]]]:
    """Number, names and types of the fields, and points of each scan."""
    for at in range(0, len(numbers), SCANS_AT_ONCE):
        some = numbers[at : at + SCANS_AT_ONCE]
        with tempfile.TemporaryDirectory(prefix="mapless_") as folder:
            run_verb(
                "export", os.fspath(recording), os.fspath(result), "--what", "labelled", "--frame", "sensor",
                "--scans", f"{some[0]}:{some[-1]}", "--every", str(every), "-o", folder, *options,
            )
            for number in some:
                yield (number, *_read_pcd(pathlib.Path(folder) / f"{number:06}.pcd"))


def _read_pcd(file: pathlib.Path) -> tuple[list[str], list[int], npt.NDArray[Any]]:
    content = file.read_bytes()
    data = content.index(b"DATA binary\n") + len(b"DATA binary\n")
    header = {words[0]: words[1:] for words in map(str.split, content[:data].decode("ascii").splitlines())}
    types = [PCD_TYPES[kind, size] for kind, size in zip(header["TYPE"], header["SIZE"], strict=True)]
    fields = np.dtype([(name, kind) for name, (kind, _) in zip(header["FIELDS"], types, strict=True)])
    return header["FIELDS"], [number for _, number in types], np.frombuffer(content, fields, offset=data)


class McapDrive:
    """Writes the messages of scans, in their order. Needs `pip install 'mapless[mcap]'`."""

    def __init__(self, file: Any) -> None:
        try:
            from foxglove_schemas_protobuf import SceneUpdate_pb2
            from mcap.writer import Writer
            from mcap_protobuf.schema import register_schema
            from rosbags.typesys import Stores, get_typestore
        except ModuleNotFoundError as missing:
            raise InputError(f"MCAP files need a package that is not installed ({missing.name}): pip install 'mapless[mcap]'") from missing
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        self._types = self._store.types
        self._scene = SceneUpdate_pb2
        self._writer: Any = Writer(file)
        self._writer.start(profile="", library="mapless")
        self._points = self._ros_channel("/points", "sensor_msgs/msg/PointCloud2")
        self._tf = self._ros_channel("/tf", "tf2_msgs/msg/TFMessage")
        schema = register_schema(self._writer, SceneUpdate_pb2.SceneUpdate)
        self._objects = self._writer.register_channel("/objects", "protobuf", schema)
        self._shown: set[int] = set()

    def finish(self) -> None:
        self._writer.finish()

    def add_points(self, time_ns: int, names: list[str], types: list[int], points: npt.NDArray[Any]) -> None:
        field, cloud = self._types["sensor_msgs/msg/PointField"], self._types["sensor_msgs/msg/PointCloud2"]
        offsets = [points.dtype.fields[name][1] for name in names]  # type: ignore[index]
        fields = [field(name=n, offset=o, datatype=t, count=1) for n, o, t in zip(names, offsets, types, strict=True)]
        step = points.dtype.itemsize
        data = np.frombuffer(points.tobytes(), np.uint8)
        self._add(
            self._points, time_ns, "sensor_msgs/msg/PointCloud2",
            cloud(header=self._header(time_ns, SENSOR), height=1, width=len(points), fields=fields, is_bigendian=False,
                  point_step=step, row_step=step * len(points), data=data, is_dense=True),
        )

    def add_pose(self, time_ns: int, T_0v: npt.NDArray[np.float64]) -> None:
        vector, transform = self._types["geometry_msgs/msg/Vector3"], self._types["geometry_msgs/msg/Transform"]
        stamped, quaternion = self._types["geometry_msgs/msg/TransformStamped"], self._types["geometry_msgs/msg/Quaternion"]
        x, y, z, w = quaternion_of(T_0v[:3, :3])
        pose = transform(translation=vector(*map(float, T_0v[:3, 3])), rotation=quaternion(x, y, z, w))
        one = stamped(header=self._header(time_ns, WORLD), child_frame_id=SENSOR, transform=pose)
        self._add(self._tf, time_ns, "tf2_msgs/msg/TFMessage", self._types["tf2_msgs/msg/TFMessage"](transforms=[one]))

    def add_objects(self, time_ns: int, rows: npt.NDArray[Any]) -> None:
        """Rows of objects.csv of one scan. Boxes of the scan before that are not in it are taken away."""
        update = self._scene.SceneUpdate()
        for row in rows:
            self._add_entity(update.entities.add(), time_ns, row)
        now = {int(i) for i in rows["id"]}
        for gone in sorted(self._shown - now):
            deletion = update.deletions.add()
            deletion.id = str(gone)
            deletion.timestamp.FromNanoseconds(time_ns)
        self._shown = now
        self._writer.add_message(self._objects, time_ns, update.SerializeToString(), time_ns)

    def _add_entity(self, entity: Any, time_ns: int, row: Any) -> None:
        entity.timestamp.FromNanoseconds(time_ns)
        entity.frame_id, entity.id = WORLD, str(row["id"])
        colour = COLOURS[(int(row["id"]) - 1) % len(COLOURS)]
        cube = entity.cubes.add()
        centre, size = [row[f"{a}_m"] for a in "xyz"], [row[f"extent_{a}_m"] for a in "xyz"]
        _set(cube.pose.position, centre)
        cube.pose.orientation.w = 1
        _set(cube.size, size)
        _paint(cube.color, colour, 0.35)
        velocity = np.array([row[f"v{a}_mps"] for a in "xyz"])
        speed = float(np.linalg.norm(velocity))
        text = entity.texts.add()
        _set(text.pose.position, [centre[0], centre[1], centre[2] + size[2] / 2 + 0.4])
        text.pose.orientation.w = 1
        text.billboard, text.scale_invariant, text.font_size = True, True, 14
        text.text = f"{row['id']}  {speed:.1f} m/s"
        _paint(text.color, colour, 1)
        if speed > 0:
            arrow = entity.arrows.add()  # its way in one second, along x of its pose
            _set(arrow.pose.position, centre)
            _set(arrow.pose.orientation, _turn_of_x(velocity / speed), "xyzw")
            arrow.shaft_length, arrow.shaft_diameter = 0.8 * speed, 0.1
            arrow.head_length, arrow.head_diameter = 0.2 * speed, 0.3
            _paint(arrow.color, colour, 1)
        for key in ("vx_mps", "vy_mps", "vz_mps", "std_vx_mps", "std_vy_mps", "std_vz_mps", "age_scans", "points"):
            pair = entity.metadata.add()
            pair.key, pair.value = key, f"{row[key]:g}"

    def _ros_channel(self, topic: str, name: str) -> int:
        definition = self._store.generate_msgdef(name, ros_version=2)[0].encode()
        schema = self._writer.register_schema(name, "ros2msg", definition)
        channel: int = self._writer.register_channel(topic, "cdr", schema)
        return channel

    def _add(self, channel: int, time_ns: int, name: str, message: Any) -> None:
        self._writer.add_message(channel, time_ns, bytes(self._store.serialize_cdr(message, name)), time_ns)

    def _header(self, time_ns: int, frame: str) -> Any:
        stamp = self._types["builtin_interfaces/msg/Time"](sec=time_ns // 10**9, nanosec=time_ns % 10**9)
        return self._types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def _set(message: Any, values: Sequence[float], names: str = "xyz") -> None:
    for name, value in zip(names, values, strict=True):
        setattr(message, name, float(value))


def _paint(colour: Any, code: str, opacity: float) -> None:
    _set(colour, [int(code[k : k + 2], 16) / 255 for k in (1, 3, 5)] + [opacity], "rgba")


def _turn_of_x(direction: npt.NDArray[np.float64]) -> list[float]:
    """Quaternion x, y, z, w that turns the x axis into a unit vector."""
    half = np.array([1 + direction[0], 0, -direction[2], direction[1]])  # w, then x cross direction
    norm = np.linalg.norm(half)
    w, x, y, z = half / norm if norm > 1e-9 else (0, 0, 0, 1)
    return [float(x), float(y), float(z), float(w)]


def quaternion_of(R: npt.NDArray[np.float64]) -> tuple[float, float, float, float]:
    """x, y, z, w of a rotation: the eigenvector of the largest eigenvalue of Bar-Itzhack's matrix (2000)."""
    K = np.array([
        [R[0, 0] - R[1, 1] - R[2, 2], R[1, 0] + R[0, 1], R[2, 0] + R[0, 2], R[2, 1] - R[1, 2]],
        [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], R[2, 1] + R[1, 2], R[0, 2] - R[2, 0]],
        [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
        [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]],
    ])  # fmt: skip
    x, y, z, w = np.linalg.eigh(K)[1][:, -1]
    return float(x), float(y), float(z), float(w)


def main(arguments: list[str]) -> int:
    """`mapless export IN OUT --what labelled --cloud-format mcap -o FILE`; exit code."""
    parser = argparse.ArgumentParser(prog="mapless export --cloud-format mcap", allow_abbrev=False)
    parser.add_argument("recording")
    parser.add_argument("result")
    parser.add_argument("-o", "--output", required=True, help="MCAP file to write")
    parser.add_argument("--cloud-format", choices=["mcap"], required=True)
    parser.add_argument("--what", choices=["labelled"], default="labelled")
    parser.add_argument("--scans", default="", metavar="A:B")
    parser.add_argument("--every", type=int, default=1, metavar="N")
    options, reading = parser.parse_known_args(arguments)
    try:
        count = export_mcap(
            options.recording, options.result, options.output, scans=options.scans, every=options.every, options=reading
        )
    except CommandError as error:
        print(f"mapless: error: {error}", file=sys.stderr)
        return error.exit_code
    except (InputError, OSError, ValueError) as error:
        print(f"mapless: error: {error}", file=sys.stderr)
        return NOT_DONE
    size = os.path.getsize(options.output) * 1e-6
    print(f"{options.output}: {count} scans, {size:.1f} MB; topics /points, /tf, /objects")
    return 0

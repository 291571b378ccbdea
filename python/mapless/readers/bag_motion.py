"""Angular velocity by an IMU and speed by wheels from topics of a bag, as measurements of the lidar."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from mapless._core import InputError
from mapless._fields import Array
from mapless._recording import Measurement
from mapless.readers.bag_poses import STATIC_TOPIC, Frames, chain_to, edges_of, messages_of, pose_along
from mapless.readers.options import Options

IMU = "sensor_msgs/msg/Imu"
# Where the message holds the frame whose twist it gives, in the axes of that frame, and the twist.
TWIST_OF: dict[str, Callable[[Any], tuple[str, Any]]] = {
    "geometry_msgs/msg/TwistStamped": lambda m: (m.header.frame_id, m.twist),
    "geometry_msgs/msg/TwistWithCovarianceStamped": lambda m: (m.header.frame_id, m.twist.twist),
    "nav_msgs/msg/Odometry": lambda m: (m.child_frame_id, m.twist.twist),
}
# The widest range of gyroscopes of robots, 2000 degrees a second; larger numbers are degrees.
MOST_RADPS = 35.0
# A lidar on the fastest of vehicles; larger numbers are km/h or mm/s.
MOST_SPEED_MPS = 200.0
# A turn of the slowest lidar: the last scan may go on for so long after its start.
LONGEST_TURN_NS = 200_000_000


def measurements_of_bag(
    reader: Any, path: str, options: Options, frame: str, span_ns: tuple[int, int]
) -> tuple[list[Measurement], list[str]]:
    """The measurements on --imu-topic and --speed-topic, and a note each. `frame`: of the clouds. `span_ns`: starts of
    the first and of the last scan."""
    measurements: list[Measurement] = []
    notes: list[str] = []
    for flag, topic, kinds, read in (
        ("--imu-topic", options.imu_topic, (IMU,), _turns),
        ("--speed-topic", options.speed_topic, tuple(TWIST_OF), _speeds),
    ):
        if topic is None:
            continue
        where = f"{path}: {flag} {topic}"
        _require_kind(reader, topic, kinds, where)
        found = list(read(messages_of(reader, topic), _Places(reader, frame.lstrip("/"), where)))
        _require_some_within(found, span_ns, where)
        measurements += found
        what = "angular velocities" if flag == "--imu-topic" else "speeds"
        notes.append(f"motion: {len(found)} {what} of frame {frame.lstrip('/')} from topic {topic}, for the odometry")
    return measurements, notes


class _Places:
    """Where frames are on the lidar, by the static transforms of the bag."""

    def __init__(self, reader: Any, lidar: str, where: str) -> None:
        self.where = where
        self._lidar = lidar
        static = edges_of(messages_of(reader, STATIC_TOPIC))
        self._static: dict[Frames, Array] = {frames: poses[-1][1] for frames, poses in static.items()}
        self._known: dict[str, Array] = {}

    def of(self, frame: str) -> Array:
        """Lidar from `frame`, (4, 4)."""
        frame = frame.lstrip("/")
        if frame not in self._known:
            self._known[frame] = self._find(frame)
        return self._known[frame]

    def _find(self, frame: str) -> Array:
        (top, top_from_frame), (top_of_lidar, top_from_lidar) = self._to_top(frame), self._to_top(self._lidar)
        if top != top_of_lidar:
            known = ", ".join(f"{above} -> {below}" for above, below in self._static) or "none"
            raise InputError(
                f"{self.where}: no static transforms place frame {frame or '(empty)'} on {self._lidar or '(empty)'}, that "
                f"of the clouds; those of {STATIC_TOPIC} are {known}; give its measurements as a file: --imu or --speed"
            )
        place: Array = np.linalg.inv(top_from_lidar) @ top_from_frame
        return place

    def _to_top(self, frame: str) -> tuple[str, Array]:
        chain = chain_to(self._static, frame, None) or []
        return (chain[-1][0] if chain else frame), pose_along(chain, self._static, {}, 0)


def _turns(messages: Iterator[tuple[str, Any]], places: _Places) -> Iterator[Measurement]:
    for _, message in messages:
        if message.angular_velocity_covariance[0] < 0:
            raise InputError(f"{places.where}: its first covariance is -1: this sensor measures no angular velocity")
        turn = _vector(message.angular_velocity, places)
        if np.abs(turn).max() > MOST_RADPS:
            raise InputError(
                f"{places.where}: an angular velocity of {np.abs(turn).max():g} rad/s, beyond {MOST_RADPS:g}: are they "
                "degrees a second? sensor_msgs/Imu has radians a second"
            )
        x, y, z = places.of(message.header.frame_id)[:3, :3] @ turn
        yield Measurement(_stamp_ns(message), (float(x), float(y), float(z)))


def _speeds(messages: Iterator[tuple[str, Any]], places: _Places) -> Iterator[Measurement]:
    for kind, message in messages:
        frame, twist = TWIST_OF[kind](message)
        # The origin of the lidar, in the frame of the wheels, moves along on a rigid body.
        lidar = np.linalg.inv(places.of(frame))[:3, 3]
        speed = float(np.linalg.norm(_vector(twist.linear, places) + np.cross(_vector(twist.angular, places), lidar)))
        if speed > MOST_SPEED_MPS:
            raise InputError(f"{places.where}: a speed of {speed:g} m/s, beyond {MOST_SPEED_MPS:g}; twists have metres a second")
        yield Measurement(_stamp_ns(message), None, speed)


def _vector(vector: Any, places: _Places) -> Array:
    numbers = np.array([vector.x, vector.y, vector.z], dtype=np.float64)
    if not np.isfinite(numbers).all():
        raise InputError(f"{places.where}: a velocity that is not finite")
    return numbers


def _stamp_ns(message: Any) -> int:
    return int(message.header.stamp.sec) * 1_000_000_000 + int(message.header.stamp.nanosec)


def _require_kind(reader: Any, topic: str, kinds: tuple[str, ...], where: str) -> None:
    of_kind = sorted({c.topic for c in reader.connections if c.msgtype in kinds})
    if topic not in of_kind:
        names = ", ".join(kind.replace("/msg/", "/") for kind in kinds)
        raise InputError(f"{where}: not one of its topics of {names}: {', '.join(of_kind) or 'none'}")


def _require_some_within(found: list[Measurement], span_ns: tuple[int, int], where: str) -> None:
    begin, end = span_ns[0], span_ns[1] + LONGEST_TURN_NS
    if any(begin <= one.stamp_ns < end for one in found):
        return
    stamps = [one.stamp_ns * 1e-9 for one in found]
    theirs = f"from {min(stamps):.3f} to {max(stamps):.3f} s" if stamps else "there are none"
    raise InputError(
        f"{where}: no message within the scans, which start from {begin * 1e-9:.3f} to {span_ns[1] * 1e-9:.3f} s; its stamps: "
        f"{theirs}; both need one clock"
    )

"""Poses of the sensor from a topic of a bag: odometry, poses, or transforms."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from mapless._core import InputError, Trajectory
from mapless._fields import Array
from mapless.readers.options import Options
from mapless.readers.poses import matrix, trajectory_of

TRANSFORMS = "tf2_msgs/msg/TFMessage"
STATIC_TOPIC = "/tf_static"
# Where the message holds position and orientation; frames are header.frame_id and child_frame_id.
POSE_OF: dict[str, Callable[[Any], tuple[Any, Any]]] = {
    "nav_msgs/msg/Odometry": lambda m: (m.pose.pose.position, m.pose.pose.orientation),
    "geometry_msgs/msg/PoseStamped": lambda m: (m.pose.position, m.pose.orientation),
    "geometry_msgs/msg/PoseWithCovarianceStamped": lambda m: (m.pose.pose.position, m.pose.pose.orientation),
    "geometry_msgs/msg/TransformStamped": lambda m: (m.transform.translation, m.transform.rotation),
}

Frames = tuple[str, str]  # parent, child


def messages_of(reader: Any, topic: str) -> Iterator[tuple[str, Any]]:
    connections = [c for c in reader.connections if c.topic == topic]
    for connection, _, data in reader.messages(connections) if connections else ():
        yield connection.msgtype, reader.deserialize(data, connection.msgtype)


def edges_of(messages: Iterable[tuple[str, Any]]) -> dict[Frames, list[tuple[int, Array]]]:
    """Stamp [ns] and pose, parent from child, of every pair of frames."""
    edges: dict[Frames, list[tuple[int, Array]]] = {}
    for kind, message in messages:
        parts = message.transforms if kind == TRANSFORMS else [message]
        get = POSE_OF["geometry_msgs/msg/TransformStamped" if kind == TRANSFORMS else kind]
        for part in parts:
            position, rotation = get(part)
            stamp_ns = part.header.stamp.sec * 1_000_000_000 + part.header.stamp.nanosec
            frames = (part.header.frame_id.lstrip("/"), getattr(part, "child_frame_id", "").lstrip("/"))
            try:
                turn = (rotation.x, rotation.y, rotation.z, rotation.w)
                pose = matrix((position.x, position.y, position.z), turn, f"{stamp_ns} ns")
            except InputError:  # refused where it is used: frames that nobody asks for may be wrong
                pose = np.full((4, 4), np.nan)
            edges.setdefault(frames, []).append((stamp_ns, pose))
    return edges


def chain_to(edges: Iterable[Frames], child: str, parent: str | None) -> list[Frames] | None:
    """The edges from `child` up to `parent`, or to the top; None: they do not lead there."""
    parents = {below: above for above, below in edges}
    chain: list[Frames] = []
    while child in parents and child != parent and len(chain) <= len(parents):
        chain.append((parents[child], child))
        child = parents[child]
    return chain if parent in (None, child) and chain else None


def pose_along(chain: list[Frames], static: dict[Frames, Array], moving: dict[Frames, Trajectory], ns: int) -> Array:
    """Top from bottom of the chain."""
    pose: Array = np.eye(4)
    for frames in chain:
        pose = (moving[frames].pose_at(ns) if frames in moving else static[frames]) @ pose
    return pose


def poses_of_bag(reader: Any, path: str, options: Options, frame: str) -> tuple[Trajectory, str]:
    """The trajectory of frame `frame`, that of the clouds, and a note."""
    topic = options.pose_topic
    assert topic is not None
    kinds = {c.topic: c.msgtype for c in reader.connections}
    readable = sorted(name for name, kind in kinds.items() if kind in POSE_OF or kind == TRANSFORMS)
    if topic not in readable:
        raise InputError(
            f"{path}: --pose-topic {topic}: not one of its topics of odometry, poses or transforms: "
            f"{', '.join(readable) or 'none'}"
        )
    frame = frame.lstrip("/")
    edges = edges_of(messages_of(reader, topic))
    static = {frames: poses[-1][1] for frames, poses in edges_of(messages_of(reader, STATIC_TOPIC)).items()}
    if kinds[topic] != TRANSFORMS and len(edges) == 1:
        ((parent, child),) = edges
        if child in ("", frame):
            edges = {(parent, frame): edges[parent, child]}
        options = Options(world_frame=options.world_frame or parent)
    static = {frames: pose for frames, pose in static.items() if frames not in edges}
    chain = chain_to([*static, *edges], frame, options.world_frame)
    if chain is None or not any(frames in edges for frames in chain):
        known = ", ".join(f"{above} -> {below}" for above, below in [*edges, *static]) or "none"
        raise InputError(
            f"{path}: --pose-topic {topic}: no poses of frame {frame}, that of the clouds, in frame "
            f"{options.world_frame or 'any'}; its transforms are {known}"
        )
    return joined(chain, edges, static, path), (
        f"poses: of frame {frame} in {chain[-1][0]} from topic {topic}"
        + (f" and {STATIC_TOPIC}" if any(frames in static for frames in chain) else "")
    )


def joined(
    chain: list[Frames], edges: dict[Frames, list[tuple[int, Array]]], static: dict[Frames, Array], path: str
) -> Trajectory:
    """Sampled at the stamps of the moving edge that has most of them, where all others have a pose."""
    moving = {
        frames: trajectory_of(edges[frames], f"{path}: poses of {frames[1]} in {frames[0]}")
        for frames in chain
        if frames in edges
    }
    stamps = {ns for ns, _ in max((edges[frames] for frames in moving), key=len)}
    begin = max(t.begin_ns for t in moving.values())
    end = min(t.end_ns for t in moving.values())
    timed = [(ns, pose_along(chain, static, moving, ns)) for ns in sorted(stamps) if begin <= ns <= end]
    return trajectory_of(timed, path)

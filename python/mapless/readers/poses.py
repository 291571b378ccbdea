"""Poses of datasets as trajectories."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from mapless._core import InputError, Trajectory
from mapless._fields import Array

# Poses at 10 Hz end up to a turn before the last point: the last velocity is taken to go on for so long.
EXTRAPOLATION_S = 0.15


def matrix(position: Sequence[float], quaternion: Sequence[float]) -> Array:
    """(4, 4) pose of a position [m] and a quaternion x y z w, of any length."""
    x, y, z, w = np.asarray(quaternion, dtype=np.float64) / np.linalg.norm(quaternion)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = position
    return pose


def trajectory_of(timed: Iterable[tuple[int, Array]], name: str) -> Trajectory:
    """Of stamps [ns] and poses world from sensor, in any order; of several at one stamp the last."""
    poses = dict(timed)
    try:
        stamps = np.array(sorted(poses), dtype=np.int64)
    except OverflowError:
        raise InputError(f"{name}: a time of {max(poses, key=abs)} ns: beyond 64 bits") from None
    if len(stamps) < 2:
        raise InputError(f"{name}: {len(stamps)} poses: expected two or more")
    matrices = np.stack([poses[int(ns)] for ns in stamps]).astype(np.float64)
    return Trajectory(stamps, matrices, EXTRAPOLATION_S)

"""Poses of datasets as trajectories."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from mapless._core import InputError, Trajectory
from mapless._fields import Array

# Poses at 10 Hz end up to a turn before the last point: the last velocity is taken to go on for so long.
EXTRAPOLATION_S = 0.15


def matrix(position: Sequence[float], quaternion: Sequence[float], where: str) -> Array:
    """(4, 4) pose of a position [m] and a quaternion x y z w, of any length but 0. `where`: for messages."""
    try:
        numbers = np.array([*position, *quaternion], dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    length = np.linalg.norm(numbers[3:])
    if numbers.shape != (7,) or len(position) != 3 or not np.isfinite(numbers).all() or length == 0:
        raise InputError(
            f"{where}: position = {str(position):.80}, quaternion x y z w = {str(quaternion):.80}: expected three and four "
            "finite numbers, the four not all 0; correct the pose, or leave it out"
        )
    x, y, z, w = numbers[3:] / length
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = numbers[:3]
    return pose


def trajectory_of(timed: Iterable[tuple[int, Array]], name: str) -> Trajectory:
    """Of stamps [ns] and poses world from sensor, in any order; of several at one stamp the last."""
    poses = dict(timed)
    try:
        stamps = np.array(sorted(poses), dtype=np.int64)
    except OverflowError:
        most = str(max(poses, key=abs))
        raise InputError(f"{name}: time = {most:.30} ns: beyond 64 bits; give times in the unit of the format") from None
    if len(stamps) < 2:
        raise InputError(f"{name}: {len(stamps)} poses: expected two or more")
    matrices = np.stack([poses[int(ns)] for ns in stamps]).astype(np.float64)
    try:
        return Trajectory(stamps, matrices, EXTRAPOLATION_S)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None

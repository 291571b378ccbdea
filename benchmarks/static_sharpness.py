#!/usr/bin/env python3
"""How sharp the static world of a KITTI raw drive is, seen with several trajectories: mean distance of the points of a
scan from the nearest ones of the scan before, every point put into the world at its own instant.

usage: static_sharpness.py DRIVE TRAJECTORY ...   (labels in DRIVE/labels_derived, where there are any)

A trajectory is a TUM file (rows t x y z qx qy qz qw, t in seconds since 1970), or a KITTI file (12 numbers
a row, one row a scan, of the middle of the scan). Between poses it is interpolated, beyond the last ones continued at
constant velocity. Left out are points labelled as moving (251 and above), beyond 40 m, or nearer than 3 m; points
farther than 0.5 m from any of the scan before were not seen in it and do not count. The third figure is of points that
are labelled as static (9) alone. Needs NumPy and SciPy.
"""

import datetime
import pathlib
import sys

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

FARTHEST_M, NEAREST_M, SEEN_BEFORE_M, STRIDE = 40, 3, 0.5, 7
STATIC, FIRST_MOVING = 9, 251


def stamps(file):
    """Every line in seconds since 1970, taken as UTC: the clock of our own trajectories."""
    out = []
    for line in file.read_text().split("\n"):
        if not line.strip():
            continue
        moment, fraction = line.strip().split(".")
        of_day = datetime.datetime.fromisoformat(moment)
        out.append(of_day.replace(tzinfo=datetime.timezone.utc).timestamp() + float("0." + fraction))
    return np.array(out)


class Trajectory:
    """World from sensor, at times since the middle of the first scan."""

    def __init__(self, times, positions, rotations):
        self.times, self.positions, self.rotations = times, positions, rotations

    def at(self, times):
        """Positions and rotations; the first and last intervals go on beyond their ends."""
        i = np.clip(np.searchsorted(self.times, times) - 1, 0, len(self.times) - 2)
        share = (times - self.times[i]) / (self.times[i + 1] - self.times[i])
        way = self.positions[i + 1] - self.positions[i]
        turn = (self.rotations[i].inv() * self.rotations[i + 1]).as_rotvec()
        rotations = self.rotations[i] * Rotation.from_rotvec(share[:, None] * turn)
        return self.positions[i] + share[:, None] * way, rotations


def read_trajectory(file, middles):
    rows = np.loadtxt(file)
    if rows.shape[1] == 8:
        return Trajectory(rows[:, 0] - middles[0], rows[:, 1:4], Rotation.from_quat(rows[:, 4:]))
    poses = rows.reshape(-1, 3, 4)
    return Trajectory(middles - middles[0], poses[:, :, 3], Rotation.from_matrix(poses[:, :, :3]))


class Drive:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        velodyne = self.folder / "velodyne_points"
        self.files = sorted((velodyne / "data").glob("*.bin"))
        self.middles = stamps(velodyne / "timestamps.txt")
        self.starts = stamps(velodyne / "timestamps_start.txt")
        self.ends = stamps(velodyne / "timestamps_end.txt")

    def scan(self, k):
        """Points, their times since the middle of the first scan, and their labels."""
        points = np.fromfile(self.files[k], np.float32).reshape(-1, 4)[:, :3].astype(np.float64)
        part = 0.5 * (1 - np.arctan2(points[:, 1], points[:, 0]) / np.pi)
        times = self.starts[k] + part * (self.ends[k] - self.starts[k]) - self.middles[0]
        labels = self.folder / "labels_derived" / f"{k:06d}.label"
        known = np.fromfile(labels, np.uint32) if labels.exists() else np.zeros(len(points), np.uint32)
        ranges = np.linalg.norm(points, axis=1)
        use = (known < FIRST_MOVING) & (ranges < FARTHEST_M) & (ranges > NEAREST_M)
        return points[use], times[use], known[use]


def in_world(trajectory, points, times):
    positions, rotations = trajectory.at(times)
    return rotations.apply(points) + positions


def sharpness(drive, trajectory):
    """Distances, and which of them are of labelled static points."""
    distances, labelled = [], []
    before = None
    for k in range(len(drive.files)):
        points, times, labels = drive.scan(k)
        world = in_world(trajectory, points, times)
        if before is not None:
            found, _ = before.query(world[::STRIDE], distance_upper_bound=SEEN_BEFORE_M)
            seen = np.isfinite(found)
            distances.append(found[seen])
            labelled.append(labels[::STRIDE][seen] == STATIC)
        before = cKDTree(world)
    return np.concatenate(distances), np.concatenate(labelled)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    drive = Drive(sys.argv[1])
    print("trajectory | mean [mm] | median [mm] | mean of labelled static [mm] | points")
    for file in sys.argv[2:]:
        distances, labelled = sharpness(drive, read_trajectory(file, drive.middles))
        of_static = 1e3 * distances[labelled].mean() if labelled.any() else float("nan")
        mean, median = 1e3 * distances.mean(), 1e3 * np.median(distances)
        print(f"{file} | {mean:.2f} | {median:.2f} | {of_static:.2f} | {len(distances)}", flush=True)


if __name__ == "__main__":
    main()

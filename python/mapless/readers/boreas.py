"""Sequences of Boreas: a Velodyne of 128 lasers, uncompensated, with times and rings of points and poses of the sensor."""

from __future__ import annotations

import csv
import pathlib
from functools import partial

import numpy as np

from mapless._core import InputError
from mapless._fields import Array
from mapless._recording import CloudSource
from mapless.readers.options import Options
from mapless.readers.poses import trajectory_of
from mapless.readers.scan_files import ScanFiles, read_rows, sorted_files

POINT = np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity", "laser_number", "time")])
POSES = pathlib.Path("applanix") / "lidar_poses.csv"
NS_PER_US = 1_000


def pose_of(row: dict[str, str]) -> Array:
    """World (east, north, up) from sensor. The angles are those of the rotation of the sensor's axes: each factor is the
    transpose of the usual one."""
    cosines, sines = {}, {}
    for name in ("roll", "pitch", "heading"):
        cosines[name], sines[name] = np.cos(float(row[name])), np.sin(float(row[name]))
    roll, pitch, heading = np.eye(3), np.eye(3), np.eye(3)
    roll[1:, 1:] = [[cosines["roll"], sines["roll"]], [-sines["roll"], cosines["roll"]]]
    pitch[::2, ::2] = [[cosines["pitch"], -sines["pitch"]], [sines["pitch"], cosines["pitch"]]]
    heading[:2, :2] = [[cosines["heading"], sines["heading"]], [-sines["heading"], cosines["heading"]]]
    pose = np.eye(4)
    pose[:3, :3] = roll @ pitch @ heading
    pose[:3, 3] = [float(row[name]) for name in ("easting", "northing", "altitude")]
    return pose


class BoreasReader:
    formats = ("boreas",)

    def fits(self, path: pathlib.Path) -> bool:
        return (path / "lidar").is_dir() and ((path / "applanix").is_dir() or (path / "calib" / "T_applanix_lidar.txt").exists())

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        files = sorted_files(path / "lidar", ".bin")
        if not files or not all(file.stem.isdigit() for file in files):
            raise InputError(f"{path}: no lidar/*.bin named by their times in us")
        stamps_ns = [int(file.stem) * NS_PER_US for file in files]
        read = partial(read_rows, dtype=POINT, remedy="fetch it again")
        notes = [
            "scans: files of lidar, named by the middle of the scan in us; times of points count from it",
            "points are as measured, not motion-compensated",
        ]
        source = ScanFiles("boreas", path, files, read, stamps_ns, notes)
        if (path / POSES).is_file():
            with (path / POSES).open(newline="", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            try:
                timed = [(int(float(row["GPSTime"])) * NS_PER_US, pose_of(row)) for row in rows]
            except (KeyError, TypeError, ValueError) as error:
                raise InputError(f"{path / POSES}: no poses of Boreas: {error}") from None
            source.trajectory = trajectory_of(timed, str(path / POSES))
            source.notes.append(f"trajectory: {POSES}, of the sensor")
        return source

"""Sequences of HeLiPR: its Ouster and its Velodyne, uncompensated, with times and rings of points and poses."""

from __future__ import annotations

import pathlib
from functools import partial

import numpy as np

from mapless._core import InputError
from mapless._recording import CloudSource
from mapless.readers.options import Options
from mapless.readers.poses import matrix, trajectory_of
from mapless.readers.scan_files import ScanFiles, read_rows, sorted_files

XYZI = [(name, "<f4") for name in ("x", "y", "z", "intensity")]
POINTS = {
    "Ouster": np.dtype([*XYZI, ("t", "<u4"), ("reflectivity", "<u2"), ("ring", "<u2"), ("ambient", "<u2")]),
    "Velodyne": np.dtype([*XYZI, ("ring", "<u2"), ("time", "<f4")]),
}
OTHERS = "Aeva and Avia are no spinning lidars"


class HeliprReader:
    formats = ("helipr",)

    def fits(self, path: pathlib.Path) -> bool:
        return any((path / "LiDAR" / name).is_dir() for name in POINTS)

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        found = [name for name in POINTS if any((path / "LiDAR" / name).glob("*.bin"))]
        lidar = options.lidar or (found[0] if len(found) == 1 else None)
        if lidar is None:
            there = f"recordings of {' and '.join(found)}: choose one with --lidar" if found else "no LiDAR/Ouster/*.bin"
            raise InputError(f"{path}: {there}")
        if lidar not in POINTS:
            raise InputError(f"{path}: --lidar {lidar}: expected one of {', '.join(POINTS)}; {OTHERS}")
        files = sorted_files(path / "LiDAR" / lidar, ".bin")
        if not files or not all(file.stem.isdigit() for file in files):
            raise InputError(f"{path}: no LiDAR/{lidar}/*.bin named by their times in ns")
        read = partial(read_rows, dtype=POINTS[lidar], remedy="fetch it again")
        notes = [f"scans: files of LiDAR/{lidar}, named by their times in ns", "points are as measured, not compensated"]
        source = ScanFiles("helipr", path, files, read, [int(file.stem) for file in files], notes)
        poses = path / "LiDAR_GT" / f"{lidar}_gt.txt"
        if poses.is_file():
            timed = []
            for i, line in enumerate(poses.read_text(encoding="utf-8").splitlines()):
                try:
                    stamp, *numbers = line.split()
                    values = [float(number) for number in numbers]
                    stamp_ns = int(stamp)
                except ValueError:
                    raise InputError(f"{poses}:{i + 1}: not a time in ns, a position and a quaternion x y z w") from None
                timed.append((stamp_ns, matrix(values[:3], values[3:7], f"{poses}:{i + 1}")))
            source.trajectory = trajectory_of(timed, str(poses))
            source.notes.append(f"trajectory: {poses.name}, of the sensor")
        return source

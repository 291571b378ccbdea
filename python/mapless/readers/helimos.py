"""Sequences of HeLiMOS: clouds of HeLiPR with labels, motion-compensated, as SemanticKITTI but without times."""

from __future__ import annotations

import pathlib
from functools import partial

import numpy as np

from mapless._core import InputError
from mapless._fields import Array
from mapless._recording import CloudSource
from mapless.readers.options import Options
from mapless.readers.poses import trajectory_of
from mapless.readers.scan_files import ScanFiles, read_rows, read_semantic_kitti_labels, sorted_files

POINT = np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity")])
# Its sensors turn at 10 Hz; the files have no times.
PERIOD_NS = 100_000_000


def numbered_poses(file: pathlib.Path) -> list[Array]:
    """(4, 4) each, of rows of twelve numbers; of the camera of calib.txt, where it has one, taken to the sensor."""
    try:
        rows = np.loadtxt(file, ndmin=2)
        poses = [np.vstack([row.reshape(3, 4), [0, 0, 0, 1]]) for row in rows]
        calibration = file.parent / "calib.txt"
        lines = calibration.read_text(encoding="utf-8").splitlines() if calibration.is_file() else []
        text = next((line.split()[1:] for line in lines if line.startswith("Tr:")), None)
        if text is None:
            return poses
        camera_from_sensor = np.vstack([np.array(text, dtype=np.float64).reshape(3, 4), [0, 0, 0, 1]])
    except ValueError as error:
        raise InputError(f"{file}: no poses of twelve numbers a line: {error}") from None
    sensor_from_camera = np.linalg.inv(camera_from_sensor)
    return [sensor_from_camera @ pose @ camera_from_sensor for pose in poses]


class HelimosSequence(ScanFiles):
    def read_labels(self, k: int) -> list[int] | None:
        file = self.files[k]
        return read_semantic_kitti_labels(file.parent.parent / "labels" / f"{file.stem}.label")


class HelimosReader:
    formats = ("helimos",)

    def fits(self, path: pathlib.Path) -> bool:
        """As KITTI odometry, but without the times that the reader of KITTI needs."""
        return (path / "poses.txt").is_file() and not (path / "times.txt").exists() and any(path.glob("velodyne/*.bin"))

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        files = sorted_files(path / "velodyne", ".bin")
        if not files or not all(file.stem.isdigit() for file in files):
            raise InputError(f"{path}: no velodyne/NNNNNN.bin")
        stamps_ns = [int(file.stem) * PERIOD_NS for file in files]
        notes = [
            "scans: 10 a second by their numbers, for the files have no times",
            "compensated already, taken to be to the start of the scan: taken back to the measured rays with the poses",
            "trajectory: poses.txt",
        ]
        read = partial(read_rows, dtype=POINT, remedy="fetch it again")
        source = HelimosSequence("helimos", path, files, read, stamps_ns, notes, compensated_after_ns=0)
        poses = numbered_poses(path / "poses.txt")
        if len(poses) <= int(files[-1].stem):
            raise InputError(f"{path / 'poses.txt'}: {len(poses)} lines: expected one for each scan, {files[-1].stem} too")
        source.trajectory = trajectory_of(((k * PERIOD_NS, pose) for k, pose in enumerate(poses)), f"{path} poses.txt")
        return source

"""Logs of Argoverse 2: sweeps of two 32-beam sensors in one file, moved to the stamp of the sweep, with poses."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np

from mapless._core import InputError
from mapless._fields import FROM_STAMP, Array, Fields
from mapless._recording import CloudSource
from mapless.readers.options import Options
from mapless.readers.poses import matrix, trajectory_of
from mapless.readers.scan_files import sorted_files

LIDARS = ("up_lidar", "down_lidar")
LASERS = 32  # of each; laser_number counts those of up_lidar first


def read_table(file: pathlib.Path) -> Any:
    try:
        from pyarrow import ArrowInvalid, feather
    except ImportError:
        raise InputError(f"{file}: read by the package pyarrow: pip install 'mapless[argoverse2]'") from None
    try:
        return feather.read_table(file)
    except (ArrowInvalid, OSError) as error:
        raise InputError(f"{file}: no table of Argoverse 2: {error}") from None


def poses_of(file: pathlib.Path, key: str) -> dict[Any, Array]:
    """Poses by the column `key`."""
    rows = read_table(file).to_pylist()
    return {
        row[key]: matrix((row["tx_m"], row["ty_m"], row["tz_m"]), (row["qx"], row["qy"], row["qz"], row["qw"]))
        for row in rows
    }


class ArgoverseLog(CloudSource):
    """One of the two sensors; the points of the other one keep their place, without a return."""

    format = "argoverse2"

    def __init__(self, path: pathlib.Path, lidar: str) -> None:
        if lidar not in LIDARS:
            raise InputError(f"--lidar {lidar}: expected one of {', '.join(LIDARS)}")
        self.path = str(path)
        self._files = sorted_files(path / "sensors" / "lidar", ".feather")
        if not self._files:
            raise InputError(f"{path}: no sensors/lidar/*.feather")
        self._first_laser = LIDARS.index(lidar) * LASERS
        mounting = poses_of(path / "calibration" / "egovehicle_SE3_sensor.feather", "sensor_name")
        if lidar not in mounting:
            raise InputError(f"{path}: {lidar} is not in its calibration")
        self._sensor_from_ego = np.linalg.inv(mounting[lidar])
        ego = poses_of(path / "city_SE3_egovehicle.feather", "timestamp_ns")
        self.trajectory = trajectory_of(((ns, pose @ mounting[lidar]) for ns, pose in ego.items()), f"{path} poses")
        self._stamps_ns = [int(file.stem) for file in self._files]
        self.starts_ns = [self._first_instant_ns(k) for k in range(len(self._files))]
        self.notes = [
            f"scans: sweeps, the points of {lidar}; --lidar {LIDARS[1 - LIDARS.index(lidar)]} takes the other sensor's",
            "times: of points from offset_ns; rings: from laser_number",
            "compensated already, to the stamp of the sweep: taken back to the measured rays with the poses of the log",
        ]

    def read(self, k: int) -> Fields:
        table = self._table(k)
        ego = np.column_stack([np.asarray(table[axis], dtype=np.float64) for axis in "xyz"])
        own = self._is_own(table)
        points = ego @ self._sensor_from_ego[:3, :3].T + self._sensor_from_ego[:3, 3]
        points[~own] = np.nan
        x, y, z = points.astype(np.float32).T
        ring = np.where(own, np.asarray(table["laser_number"]).astype(np.int32) - self._first_laser, 0).astype(np.uint16)
        time = np.asarray(table["offset_ns"])
        stamp_ns = self._stamps_ns[k]
        return Fields(x, y, z, stamp_ns, ring, time, "ns", FROM_STAMP, compensated_to_ns=stamp_ns)

    def scan_name(self, k: int) -> str:
        return str(self._files[k])

    def _table(self, k: int) -> Any:
        return read_table(self._files[k])

    def _is_own(self, table: Any) -> Array:
        laser = np.asarray(table["laser_number"])
        own: Array = (laser >= self._first_laser) & (laser < self._first_laser + LASERS)
        return own

    def _first_instant_ns(self, k: int) -> int:
        table = self._table(k)
        times = np.asarray(table["offset_ns"])[self._is_own(table)]
        if times.size == 0:
            raise InputError(f"{self._files[k]}: no point of lasers {self._first_laser} and the {LASERS - 1} after it")
        return self._stamps_ns[k] + int(times.min())


class ArgoverseReader:
    formats = ("argoverse2",)

    def fits(self, path: pathlib.Path) -> bool:
        return (path / "city_SE3_egovehicle.feather").is_file()

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        return ArgoverseLog(path, options.lidar or LIDARS[0])

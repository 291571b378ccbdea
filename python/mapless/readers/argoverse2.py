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


def numbers_of(table: Any, column: str, file: pathlib.Path, kinds: str, expected: str) -> Array:
    """A column of numbers of these kinds of NumPy, all finite. Raises InputError."""
    if column not in table.column_names:
        raise InputError(
            f"{file}: column {column}: missing; its columns are {', '.join(table.column_names)}: not of Argoverse 2?"
        )
    numbers: Array = np.asarray(table[column])
    if numbers.dtype.kind not in kinds:  # also: integers with missing values become floats
        raise InputError(f"{file}: column {column} = {table[column].type}: expected {expected}, none missing")
    is_float = numbers.dtype.kind == "f"
    wrong = np.flatnonzero(~np.isfinite(numbers)) if is_float else np.empty(0, dtype=np.intp)
    if wrong.size:
        raise InputError(f"{file}: row {wrong[0]} {column} = {numbers[wrong[0]]}: not a number; fetch the file again")
    return numbers


def positions_of(table: Any, axis: str, file: pathlib.Path) -> Array:
    """NaN is a point without a return."""
    if axis not in table.column_names or np.asarray(table[axis]).dtype.kind != "f":
        numbers_of(table, axis, file, "f", "floating numbers")
    return np.asarray(table[axis], dtype=np.float64)


def poses_of(file: pathlib.Path, key: str, kinds: str, expected: str) -> dict[Any, Array]:
    """Poses by the column `key`, of these kinds."""
    table = read_table(file)
    keys = numbers_of(table, key, file, kinds, expected).tolist()
    columns = [numbers_of(table, name, file, "f", "floating numbers") for name in ("tx_m", "ty_m", "tz_m")]
    turns = [numbers_of(table, f"q{name}", file, "f", "floating numbers") for name in "xyzw"]
    rows = zip(keys, np.column_stack(columns).tolist(), np.column_stack(turns).tolist())
    return {key: matrix(position, turn, f"{file}: row {i}") for i, (key, position, turn) in enumerate(rows)}


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
        mounting = poses_of(path / "calibration" / "egovehicle_SE3_sensor.feather", "sensor_name", "OU", "text")
        if lidar not in mounting:
            raise InputError(f"{path}/calibration/egovehicle_SE3_sensor.feather: sensor_name {lidar}: no row has it")
        self._sensor_from_ego = np.linalg.inv(mounting[lidar])
        ego = poses_of(path / "city_SE3_egovehicle.feather", "timestamp_ns", "iu", "whole ns")
        self.trajectory = trajectory_of(((ns, pose @ mounting[lidar]) for ns, pose in ego.items()), f"{path} poses")
        if (odd := next((file for file in self._files if not file.stem.isdigit()), None)) is not None:
            raise InputError(f"{odd}: its name is not a time in ns")
        self._stamps_ns = [int(file.stem) for file in self._files]
        self.starts_ns = [self._first_instant_ns(k) for k in range(len(self._files))]
        self.notes = [
            f"scans: sweeps, the points of {lidar}; --lidar {LIDARS[1 - LIDARS.index(lidar)]} takes the other sensor's",
            "times: of points from offset_ns; rings: from laser_number",
            "compensated already, to the stamp of the sweep: taken back to the measured rays with the poses of the log",
        ]

    def read(self, k: int) -> Fields:
        table, file = read_table(self._files[k]), self._files[k]
        ego = np.column_stack([positions_of(table, axis, file) for axis in "xyz"])
        own = self._is_own(table, file)
        points = ego @ self._sensor_from_ego[:3, :3].T + self._sensor_from_ego[:3, 3]
        points[~own] = np.nan
        x, y, z = points.astype(np.float32).T
        laser = numbers_of(table, "laser_number", file, "iu", "whole numbers")
        ring = np.where(own, laser.astype(np.int64) - self._first_laser, 0).astype(np.uint16)
        time = numbers_of(table, "offset_ns", file, "iu", "whole ns")
        stamp_ns = self._stamps_ns[k]
        return Fields(x, y, z, stamp_ns, ring, time, "ns", FROM_STAMP, compensated_to_ns=stamp_ns)

    def scan_name(self, k: int) -> str:
        return str(self._files[k])

    def _is_own(self, table: Any, file: pathlib.Path) -> Array:
        laser = numbers_of(table, "laser_number", file, "iu", "whole numbers")
        if (wrong := np.flatnonzero((laser < 0) | (laser >= len(LIDARS) * LASERS))).size:
            raise InputError(f"{file}: row {wrong[0]} laser_number = {laser[wrong[0]]}: not one of the 64 lasers")
        own: Array = (laser >= self._first_laser) & (laser < self._first_laser + LASERS)
        return own

    def _first_instant_ns(self, k: int) -> int:
        table, file = read_table(self._files[k]), self._files[k]
        times = numbers_of(table, "offset_ns", file, "iu", "whole ns")[self._is_own(table, file)]
        if times.size == 0:
            raise InputError(f"{file}: laser_number: no point of {self._first_laser} and the {LASERS - 1} after it")
        return self._stamps_ns[k] + int(times.min())


class ArgoverseReader:
    formats = ("argoverse2",)

    def fits(self, path: pathlib.Path) -> bool:
        return (path / "city_SE3_egovehicle.feather").is_file()

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        return ArgoverseLog(path, options.lidar or LIDARS[0])

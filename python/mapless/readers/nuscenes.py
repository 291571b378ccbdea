"""Scenes of nuScenes: an HDL-32E with rings and no times of points, moved to the end of its turn, with poses."""

from __future__ import annotations

import json
import pathlib
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from mapless._core import InputError
from mapless._fields import Array
from mapless._recording import CloudSource
from mapless.readers.options import Options
from mapless.readers.poses import matrix, trajectory_of
from mapless.readers.scan_files import ScanFiles, read_rows, sorted_files

POINT = np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity", "ring")])
SUFFIX = ".pcd.bin"  # no PCD file
CHANNEL = "LIDAR_TOP"
NS_PER_US = 1_000
# The sensor turns at 20 Hz; the stamp is the end of the turn.
TURN_NS = 50_000_000
# The year 2096: in ns, within 64 bits.
MOST_US = 4_000_000_000_000_000
SENSOR = "HDL-32E"


def stamp_of(file: pathlib.Path) -> int:
    """In ns: names are LOG__LIDAR_TOP__MICROSECONDS.pcd.bin."""
    text = file.name.removesuffix(SUFFIX).rpartition("__")[2]
    if not text.isdigit():
        raise InputError(f"{file}: its name does not end in a time in us and {SUFFIX}")
    return int(text) * NS_PER_US


def tables_of(path: pathlib.Path) -> pathlib.Path | None:
    return next((file.parent for file in sorted(path.glob("v1.0-*/sample_data.json"))), None)


class Table(dict[str, Any]):
    """Rows of a table by their tokens, which hold these fields. Raises InputError."""

    def __init__(self, folder: pathlib.Path, name: str, /, **fields: Callable[[Any], bool]) -> None:
        self._file = folder / f"{name}.json"
        try:
            rows = json.loads(self._file.read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError) as error:
            raise InputError(f"{self._file}: no table of nuScenes: {error!s:.200}") from None
        if not isinstance(rows, list):
            raise InputError(f"{self._file}: no table of nuScenes: not a list of rows")
        for i, row in enumerate(rows):
            for field, fits in {"token": is_text, **fields}.items():
                found = row.get(field) if isinstance(row, dict) else row
                if not isinstance(row, dict) or not fits(found):
                    raise InputError(f"{self._file}: row {i} {field} = {found!r:.80}: {EXPECTED[fits]}; fetch the table again")
            if row["token"] in self:
                raise InputError(f"{self._file}: row {i} token = {row['token']}: of another row, too; fetch the table again")
            self[row["token"]] = row

    def __missing__(self, token: str) -> Any:
        raise InputError(f"{self._file}: token = {token}: no row has it, but another table names it; fetch the tables again")


def is_text(value: Any) -> bool:
    return isinstance(value, str)


def is_time_us(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < MOST_US


def is_list(value: Any) -> bool:
    return isinstance(value, list)


EXPECTED: dict[Callable[[Any], bool], str] = {
    is_text: "expected text",
    is_time_us: "expected a time in us",
    is_list: "expected a list of numbers",
}


def pose_of(row: Any, where: str) -> Array:
    """Its quaternion is w x y z."""
    return matrix(row["translation"], [*row["rotation"][1:], *row["rotation"][:1]], where)


class Poses(Table):
    def __init__(self, folder: pathlib.Path, name: str) -> None:
        super().__init__(folder, name, translation=is_list, rotation=is_list)

    def pose(self, token: str) -> Array:
        return pose_of(self[token], f"{self._file}: token = {token}")


def scenes_of(tables: pathlib.Path) -> dict[str, str]:
    """Tokens of the scenes by name."""
    return {scene["name"]: token for token, scene in Table(tables, "scene", name=is_text).items()}


def sweeps_of(tables: pathlib.Path, name: str) -> list[Any]:
    """Of the lidar in a scene, key frames among them, in the order of time: rows of sample_data."""
    scene = scenes_of(tables)[name]
    samples = {token for token, row in Table(tables, "sample", scene_token=is_text).items() if row["scene_token"] == scene}
    texts = dict.fromkeys(("filename", "sample_token", "ego_pose_token", "calibrated_sensor_token"), is_text)
    sweeps = [
        sweep
        for sweep in Table(tables, "sample_data", timestamp=is_time_us, **texts).values()
        if sweep["sample_token"] in samples and CHANNEL in sweep["filename"] and sweep["filename"].endswith(SUFFIX)
    ]
    return sorted(sweeps, key=lambda sweep: int(sweep["timestamp"]))


def require_stamps_of_names(tables: pathlib.Path, sweeps: list[Any]) -> None:
    for sweep in sweeps:
        if stamp_of(pathlib.Path(sweep["filename"])) != sweep["timestamp"] * NS_PER_US:
            raise InputError(
                f"{tables}/sample_data.json: {sweep['token']} timestamp = {sweep['timestamp']} us: not that in filename = "
                f"{sweep['filename']}; fetch the tables again"
            )


class NuScenesReader:
    formats = ("nuscenes",)

    def fits(self, path: pathlib.Path) -> bool:
        return path.is_dir() and (tables_of(path) is not None or any(path.glob(f"*{CHANNEL}*{SUFFIX}")))

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        tables = tables_of(path)
        if tables is None:
            return self._source(path, sorted_files(path, SUFFIX), "trajectory: none, without the tables of the data set")
        return self._scene(path, tables, options.scene)

    def _scene(self, path: pathlib.Path, tables: pathlib.Path, name: str | None) -> CloudSource:
        names = scenes_of(tables)
        if name not in names:
            raise InputError(f"{path}: choose a scene with --scene: {', '.join(sorted(names))}")
        sweeps = sweeps_of(tables, name)
        if not sweeps:
            raise InputError(f"{tables}: no sweep of {CHANNEL} in {name}")
        require_stamps_of_names(tables, sweeps)
        ego, sensors = Poses(tables, "ego_pose"), Poses(tables, "calibrated_sensor")
        source = self._source(path, [path / sweep["filename"] for sweep in sweeps], f"trajectory: of the poses of {name}")
        source.trajectory = trajectory_of(
            (
                (
                    int(sweep["timestamp"]) * NS_PER_US,
                    ego.pose(sweep["ego_pose_token"]) @ sensors.pose(sweep["calibrated_sensor_token"]),
                )
                for sweep in sweeps
            ),
            f"{path} {name}",
        )
        return source

    def _source(self, path: pathlib.Path, files: list[pathlib.Path], trajectory: str) -> ScanFiles:
        notes = [
            "scans: sweeps, named by the end of their turn in us",
            "compensated already, to the end of the turn",
            trajectory,
        ]
        read = partial(read_rows, dtype=POINT, remedy="fetch it again")
        starts = [stamp_of(file) - TURN_NS for file in files]
        return ScanFiles("nuscenes", path, files, read, starts, notes, compensated_after_ns=TURN_NS)

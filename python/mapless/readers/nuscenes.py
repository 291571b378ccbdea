"""Scenes of nuScenes: an HDL-32E with rings and no times of points, moved to the end of its turn, with poses."""

from __future__ import annotations

import json
import pathlib
from functools import partial
from typing import Any

import numpy as np

from mapless._core import InputError
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
SENSOR = "HDL-32E"


def stamp_of(file: pathlib.Path) -> int:
    """In ns: names are LOG__LIDAR_TOP__MICROSECONDS.pcd.bin."""
    text = file.name.removesuffix(SUFFIX).rpartition("__")[2]
    if not text.isdigit():
        raise InputError(f"{file}: its name does not end in a time in us and {SUFFIX}")
    return int(text) * NS_PER_US


def tables_of(path: pathlib.Path) -> pathlib.Path | None:
    return next((file.parent for file in sorted(path.glob("v1.0-*/sample_data.json"))), None)


def by_token(folder: pathlib.Path, name: str) -> dict[str, Any]:
    return {row["token"]: row for row in json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))}


def pose_of(row: Any) -> Any:
    w, x, y, z = row["rotation"]
    return matrix(row["translation"], (x, y, z, w))


def scenes_of(tables: pathlib.Path) -> dict[str, str]:
    """Tokens of the scenes by name."""
    return {scene["name"]: token for token, scene in by_token(tables, "scene").items()}


def sweeps_of(tables: pathlib.Path, name: str) -> list[Any]:
    """Of the lidar in a scene, key frames among them, in the order of time: rows of sample_data."""
    scene = scenes_of(tables)[name]
    samples = {token for token, sample in by_token(tables, "sample").items() if sample["scene_token"] == scene}
    sweeps = [
        sweep
        for sweep in by_token(tables, "sample_data").values()
        if sweep["sample_token"] in samples and CHANNEL in sweep["filename"] and sweep["filename"].endswith(SUFFIX)
    ]
    return sorted(sweeps, key=lambda sweep: int(sweep["timestamp"]))


class NuScenesReader:
    formats = ("nuscenes",)

    def fits(self, path: pathlib.Path) -> bool:
        return path.is_dir() and (tables_of(path) is not None or any(path.glob(f"*{CHANNEL}*{SUFFIX}")))

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        tables = tables_of(path)
        if tables is None:
            return self._source(path, sorted_files(path, SUFFIX), "trajectory: none, without the tables of the data set")
        try:
            return self._scene(path, tables, options.scene)
        except InputError:
            raise
        except (KeyError, ValueError, OSError) as error:
            raise InputError(f"{tables}: not the tables of nuScenes: {error!r}") from None

    def _scene(self, path: pathlib.Path, tables: pathlib.Path, name: str | None) -> CloudSource:
        names = scenes_of(tables)
        if name not in names:
            raise InputError(f"{path}: choose a scene with --scene: {', '.join(sorted(names))}")
        sweeps = sweeps_of(tables, name)
        ego, sensors = by_token(tables, "ego_pose"), by_token(tables, "calibrated_sensor")
        source = self._source(path, [path / sweep["filename"] for sweep in sweeps], f"trajectory: of the poses of {name}")
        source.trajectory = trajectory_of(
            (
                (
                    int(sweep["timestamp"]) * NS_PER_US,
                    pose_of(ego[sweep["ego_pose_token"]]) @ pose_of(sensors[sweep["calibrated_sensor_token"]]),
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

"""nuScenes: the points of key frames from 3 to 50 m, moving within a box whose attribute says that it moves."""

from __future__ import annotations

import pathlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from mapless._core import InputError
from mapless.protocols.counts import ComparedScan, Mask, Range, read_found
from mapless.readers.nuscenes import POINT, Poses, Table, pose_of, scenes_of, sweeps_of, tables_of

MOVING_ATTRIBUTES = ("vehicle.moving", "cycle.with_rider", "pedestrian.moving")
NEAREST_M, FARTHEST_M = 3.0, 50.0

Points = npt.NDArray[np.float64]


def within(points_0: Points, box: Any) -> Mask:
    """Points inside a box of the world; its size is width, length, height."""
    pose = pose_of(box, f"box {box['token']}")
    local = (points_0 - pose[:3, 3]) @ pose[:3, :3]
    width, length, height = box["size"]
    inside: Mask = np.asarray((np.abs(local) <= np.array([length, width, height]) / 2).all(axis=1))
    return inside


class NuScenes:
    """Predictions: SCENE, results of `mapless detect DATA --scene SCENE`."""

    ranges: tuple[Range, ...] = ((3.0, 10.0), (10.0, 20.0), (20.0, 40.0), (40.0, 50.0))

    def places(self, truth: pathlib.Path, predictions: pathlib.Path) -> dict[str, pathlib.Path]:
        return {name: predictions / name for name in sorted(scenes_of(self._tables(truth)))}

    def compared(self, name: str, truth: pathlib.Path, predictions: pathlib.Path) -> Iterator[ComparedScan]:
        tables = self._tables(truth)
        ego, sensors = Poses(tables, "ego_pose"), Poses(tables, "calibrated_sensor")
        attributes = {token for token, row in Table(tables, "attribute").items() if row["name"] in MOVING_ATTRIBUTES}
        boxes: dict[str, list[Any]] = {}
        for box in Table(tables, "sample_annotation").values():
            if attributes.intersection(box["attribute_tokens"]):
                boxes.setdefault(box["sample_token"], []).append(box)
        for k, sweep in enumerate(sweeps_of(tables, name)):
            if not sweep["is_key_frame"]:
                continue
            file = truth / sweep["filename"]
            rows = np.fromfile(file, dtype=POINT)
            points = np.column_stack([rows[axis] for axis in "xyz"]).astype(np.float64)
            pose = ego.pose(sweep["ego_pose_token"]) @ sensors.pose(sweep["calibrated_sensor_token"])
            points_0 = points @ pose[:3, :3].T + pose[:3, 3]
            moving = np.zeros(len(points), dtype=bool)
            for box in boxes.get(sweep["sample_token"], []):
                moving |= within(points_0, box)
            label = predictions / "labels" / f"{k:06d}.label"
            if not label.is_file():
                raise InputError(f"{label}: missing: {file.name} is a key frame of {name}")
            found = read_found(label, len(points), str(file))
            range_m: Points = np.linalg.norm(points, axis=1)
            used = (range_m >= NEAREST_M) & (range_m <= FARTHEST_M)
            yield ComparedScan(moving[used], found[used], range_m[used])

    @staticmethod
    def _tables(truth: pathlib.Path) -> pathlib.Path:
        tables = tables_of(truth)
        if tables is None:
            raise InputError(f"{truth}: no v1.0-*/sample_data.json: give the folder of nuScenes")
        return tables

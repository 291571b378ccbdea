"""The result of `mapless detect` as arrays and tables."""

from __future__ import annotations

import csv
import json
import os
import pathlib
from typing import Any

import numpy as np
import numpy.typing as npt

from mapless._core import InputError

MOVING = 251


class Result:
    """A folder that `mapless detect` has written (docs/formats.md). `len` is the number of labelled scans."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = pathlib.Path(path)
        files = sorted((self.path / "labels").glob("*.label"))
        if not files:
            raise InputError(f"{self.path}: no result: no labels/*.label in it; give the output of mapless detect")
        self.scans = [int(file.stem) for file in files]
        """numbers of the labelled scans in the recording, increasing"""

    def __len__(self) -> int:
        return len(self.scans)

    def label(self, scan: int) -> npt.NDArray[np.uint32]:
        """(N,) label of every record: 251 moving, 9 static, 0 no return; the high 16 bits number the object."""
        file = self.path / "labels" / f"{scan:06d}.label"
        if not file.exists():
            raise InputError(f"{file}: no labels of scan {scan}; the result has {self.scans[0]} to {self.scans[-1]}")
        return np.fromfile(file, dtype="<u4")

    def moving(self, scan: int) -> npt.NDArray[np.bool_]:
        """(N,) whether each record belongs to a moving object."""
        moving: npt.NDArray[np.bool_] = (self.label(scan) & 0xFFFF) == MOVING
        return moving

    def probability(self, scan: int) -> npt.NDArray[np.float32]:
        """(N,) probability that each record moves; NaN: not known. Needs a result of `detect --probability`."""
        file = self.path / "probability" / f"{scan:06d}.f32"
        if not file.exists():
            raise InputError(f"{file}: no probabilities of scan {scan}; label with mapless detect --probability")
        return np.fromfile(file, dtype="<f4")

    def objects(self) -> npt.NDArray[Any]:
        """objects.csv as a structured array: one row per moving object and scan, fields as its columns."""
        with (self.path / "objects.csv").open(newline="", encoding="utf-8") as file:
            names, *rows = list(csv.reader(file))
        types = [(name, np.int64 if name in ("scan", "id", "points", "age_scans") else np.float64) for name in names]
        return np.array([tuple(row) for row in rows], dtype=types)

    def poses(self) -> npt.NDArray[np.float64]:
        """(len, 4, 4) world from sensor at the start of each labelled scan."""
        rows = np.loadtxt(self.path / "poses_kitti.txt", ndmin=2).reshape(-1, 3, 4)
        return np.concatenate([rows, np.tile([[[0.0, 0.0, 0.0, 1.0]]], (len(rows), 1, 1))], axis=1)

    def trajectory(self) -> npt.NDArray[np.float64]:
        """(M, 8) rows of trajectory.txt (TUM): time [s], position [m], quaternion x y z w."""
        return np.loadtxt(self.path / "trajectory.txt", ndmin=2)

    def summary(self) -> dict[str, Any]:
        """summary.json."""
        summary: dict[str, Any] = json.loads((self.path / "summary.json").read_text(encoding="utf-8"))
        return summary

"""Counts of moving points, summed over scans and then divided."""

from __future__ import annotations

import dataclasses
import pathlib
from typing import Any

import numpy as np
import numpy.typing as npt

from mapless._core import InputError

CLASS_BITS = 0xFFFF  # the high bits number instances
MOVING = (251, 259)

Mask = npt.NDArray[np.bool_]
Range = tuple[float, float]
"""nearest and farthest, which is not in it [m]"""


@dataclasses.dataclass
class ComparedScan:
    """The points of a scan that count."""

    truth: Mask
    found: Mask
    range_m: npt.NDArray[np.float64] | None = None
    """None: not known, the clouds are not there"""


@dataclasses.dataclass
class Counts:
    tp: int = 0
    fp: int = 0
    fn: int = 0
    tn: int = 0

    def add(self, truth: Mask, found: Mask) -> None:
        self.tp += int((truth & found).sum())
        self.fp += int((~truth & found).sum())
        self.fn += int((truth & ~found).sum())
        self.tn += int((~truth & ~found).sum())

    def figures(self) -> dict[str, Any]:
        def share(part: int, whole: int) -> float | None:
            return part / whole if whole else None

        return {
            "iou": share(self.tp, self.tp + self.fp + self.fn),
            "precision": share(self.tp, self.tp + self.fp),
            "recall": share(self.tp, self.tp + self.fn),
            **dataclasses.asdict(self),
        }


@dataclasses.dataclass
class Totals:
    """Counts are summed over scans and then divided; the mean of the scans' IoU is given beside."""

    ranges: tuple[Range, ...]
    all: Counts = dataclasses.field(default_factory=Counts)
    by_range: list[Counts] = dataclasses.field(init=False)
    scan_ious: list[float] = dataclasses.field(default_factory=list)
    scans: int = 0
    with_ranges: int = 0

    def __post_init__(self) -> None:
        self.by_range = [Counts() for _ in self.ranges]

    def add(self, compared: ComparedScan) -> None:
        truth, found, range_m = compared.truth, compared.found, compared.range_m
        scan = Counts()
        scan.add(truth, found)
        self.all.add(truth, found)
        self.scans += 1
        iou = scan.figures()["iou"]
        if iou is not None:
            self.scan_ious.append(iou)
        if range_m is None:
            return
        self.with_ranges += 1
        for (nearest, farthest), counts in zip(self.ranges, self.by_range, strict=True):
            at = (range_m >= nearest) & (range_m < farthest)
            counts.add(truth[at], found[at])

    def report(self) -> dict[str, Any]:
        mean = sum(self.scan_ious) / len(self.scan_ious) if self.scan_ious else None
        ranges = {f"{near:g}-{far:g}": c.figures() for (near, far), c in zip(self.ranges, self.by_range, strict=True)}
        return {
            "scans": self.scans,
            **self.all.figures(),
            "mean_iou_of_scans": mean,
            "ranges_m": ranges if self.with_ranges == self.scans else None,
        }


def is_moving(labels: npt.NDArray[np.uint32]) -> Mask:
    classes = labels & CLASS_BITS
    moving: Mask = (classes >= MOVING[0]) & (classes <= MOVING[1])
    return moving


def numbered(folder: pathlib.Path) -> dict[int, pathlib.Path]:
    return {int(file.stem): file for file in folder.glob("*.label") if file.stem.isdigit()}


def read_found(file: pathlib.Path, count: int, truth: str) -> Mask:
    """Whether the points of a scan move by a label file; `truth`: what says that it has `count` points."""
    labels = np.fromfile(file, dtype="<u4")
    if len(labels) != count:
        raise InputError(f"{file}: {len(labels)} labels: expected {count}, as {truth} has")
    return is_moving(labels)

"""Public evaluations of moving points: which sequences and scans count, what the ids mean, and the figures.

    mapless evaluate --protocol semantickitti dataset/sequences predictions/sequences

docs/protocols.md says for each which files to download and which commands give the row.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import pathlib
import re
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from mapless._core import InputError

CLASS_BITS = 0xFFFF  # the high bits number instances
MOVING = (251, 259)
UNLABELLED = (0, 1)  # unlabelled, outlier
RANGES_M = ((0.0, 10.0), (10.0, 20.0), (20.0, 40.0), (40.0, float("inf")))
NOT_DONE, DONE = 3, 0  # exit codes of the command

Mask = npt.NDArray[np.bool_]


@dataclasses.dataclass(frozen=True)
class Protocol:
    sequences: tuple[str, ...]
    unlabelled: str
    """ignored or static: what points of the ids 0 and 1 count as"""
    list_name: str | None = None
    """file of a sequence that lists the scans that count; None: every scan with a label"""


PROTOCOLS = {
    "semantickitti": Protocol(("08",), "ignored"),
    "kitti-road-mos": Protocol(tuple(str(n) for n in range(30, 42)), "static"),
    "helimos": Protocol(("02", "03"), "ignored", "test.txt"),  # Ouster and Velodyne; 00 and 01 are no spinning lidars
}


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

    all: Counts = dataclasses.field(default_factory=Counts)
    by_range: list[Counts] = dataclasses.field(default_factory=lambda: [Counts() for _ in RANGES_M])
    scan_ious: list[float] = dataclasses.field(default_factory=list)
    scans: int = 0
    with_ranges: int = 0

    def add(self, truth: Mask, found: Mask, range_m: npt.NDArray[np.float64] | None) -> None:
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
        for (nearest, farthest), counts in zip(RANGES_M, self.by_range, strict=True):
            at = (range_m >= nearest) & (range_m < farthest)
            counts.add(truth[at], found[at])

    def report(self) -> dict[str, Any]:
        mean = sum(self.scan_ious) / len(self.scan_ious) if self.scan_ious else None
        ranges = {f"{near:g}-{far:g}": c.figures() for (near, far), c in zip(RANGES_M, self.by_range, strict=True)}
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


def scans_of(protocol: Protocol, sequence: pathlib.Path) -> dict[int, pathlib.Path]:
    """Label files of the scans that count, by number."""
    labels = numbered(sequence / "labels")
    if protocol.list_name is None:
        return dict(sorted(labels.items()))
    file = sequence / protocol.list_name
    if not file.is_file():
        raise InputError(f"{file}: missing: it lists the scans that count")
    listed = [re.findall(r"\d+", line)[-1:] for line in file.read_text(encoding="utf-8").splitlines()]
    numbers = [int(number[0]) for number in listed if number]
    without = next((n for n in numbers if n not in labels), None)
    if without is not None:
        raise InputError(f"{file}: scan {without} has no label in {sequence / 'labels'}")
    return {n: labels[n] for n in numbers}


def ranges_of(sequence: pathlib.Path, file: pathlib.Path, count: int) -> npt.NDArray[np.float64] | None:
    """Of the points of a scan; None where the clouds are not there."""
    cloud = sequence / "velodyne" / f"{file.stem}.bin"
    if not cloud.is_file():
        return None
    points = np.fromfile(cloud, dtype="<f4").reshape(-1, 4)
    if len(points) != count:
        raise InputError(f"{cloud}: {len(points)} points: expected one for each of the {count} labels")
    ranges: npt.NDArray[np.float64] = np.linalg.norm(points[:, :3].astype(np.float64), axis=1)
    return ranges


def compared(
    protocol: Protocol, sequence: pathlib.Path, predictions: pathlib.Path
) -> Iterator[tuple[Mask, Mask, npt.NDArray[np.float64] | None]]:
    """True and found motion, and range, of the points of each scan that count."""
    found_files = numbered(predictions)
    scans = scans_of(protocol, sequence)
    if not scans:
        raise InputError(f"{sequence}: no labels/NNNNNN.label")
    for number, file in scans.items():
        if number not in found_files:
            raise InputError(f"{predictions}: no prediction of scan {number}, which counts")
        truth, found = (np.fromfile(path, dtype="<u4") for path in (file, found_files[number]))
        if len(truth) != len(found):
            raise InputError(f"{found_files[number]}: {len(found)} labels: expected {len(truth)}, as {file} has")
        used = np.ones(len(truth), dtype=bool)
        if protocol.unlabelled == "ignored":
            used = ~np.isin(truth & CLASS_BITS, UNLABELLED)
        ranges = ranges_of(sequence, file, len(truth))
        yield is_moving(truth)[used], is_moving(found)[used], None if ranges is None else ranges[used]


def evaluate_protocol(name: str, truth: pathlib.Path, predictions: pathlib.Path) -> dict[str, Any]:
    """`truth`: folder of NN/labels (and NN/velodyne, for the ranges); `predictions`: of NN/predictions. Sequences of the
    protocol without predictions are left out and named; there must be one."""
    protocol = PROTOCOLS[name]
    total, rows = Totals(), {}
    for sequence in protocol.sequences:
        if not (predictions / sequence / "predictions").is_dir():
            continue
        own = Totals()
        for scan in compared(protocol, truth / sequence, predictions / sequence / "predictions"):
            own.add(*scan)
            total.add(*scan)
        rows[sequence] = own.report()
    if not rows:
        wanted = ", ".join(protocol.sequences)
        raise InputError(f"{predictions}: no NN/predictions of the sequences of {name}: {wanted}")
    left_out = [sequence for sequence in protocol.sequences if sequence not in rows]
    return {"protocol": name, "left_out": left_out, "sequences": rows, "total": total.report()}


def table(report: dict[str, Any]) -> str:
    def text(value: float | None) -> str:
        return "-" if value is None else f"{100 * value:.1f}"

    def row(name: str, r: dict[str, Any], scans: str, mean: str) -> str:
        figures = "".join(f"{text(r[key]):>11}" for key in ("iou", "precision", "recall"))
        return f"{name:<10}{scans:>7}{figures}{mean:>10}{r['tp']:>12}{r['fp']:>12}{r['fn']:>12}{r['tn']:>14}"

    head = ("sequence", "scans", "IoU [%]", "prec. [%]", "recall [%]", "mean IoU", "TP", "FP", "FN", "TN")
    lines = ["{:<10}{:>7}{:>11}{:>11}{:>11}{:>10}{:>12}{:>12}{:>12}{:>14}".format(*head)]
    for name, r in {**report["sequences"], "total": report["total"]}.items():
        lines.append(row(name, r, str(r["scans"]), text(r["mean_iou_of_scans"])))
    for name, r in (report["total"]["ranges_m"] or {}).items():
        lines.append(row(f"{name} m", r, "", ""))
    if report["left_out"]:
        lines.append(f"without predictions, left out: {', '.join(report['left_out'])}")
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="mapless evaluate", description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--protocol", required=True, choices=sorted(PROTOCOLS))
    parser.add_argument("--json", action="store_true", help="the figures as JSON")
    parser.add_argument("truth", type=pathlib.Path, help="folder of NN/labels, and NN/velodyne for the ranges")
    parser.add_argument("predictions", type=pathlib.Path, help="folder of NN/predictions")
    given = parser.parse_args(arguments)
    try:
        report = evaluate_protocol(given.protocol, given.truth, given.predictions)
    except (InputError, OSError, ValueError) as error:
        print(f"mapless: error: {error}", file=sys.stderr)
        return NOT_DONE
    print(json.dumps(report, indent=1) if given.json else table(report))
    return DONE

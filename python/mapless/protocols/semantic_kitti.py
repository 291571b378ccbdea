"""Sequences in the layout of SemanticKITTI: NN/labels, NN/velodyne and NN/predictions."""

from __future__ import annotations

import dataclasses
import pathlib
import re
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from mapless._core import InputError
from mapless.protocols.counts import CLASS_BITS, ComparedScan, Range, is_moving, numbered, read_found

UNLABELLED = (0, 1)  # unlabelled, outlier


@dataclasses.dataclass(frozen=True)
class Sequences:
    names: tuple[str, ...]
    unlabelled: str
    """ignored or static: what points of the ids 0 and 1 count as"""
    list_name: str | None = None
    """file of a sequence that lists the scans that count; None: every scan with a label"""
    ranges: tuple[Range, ...] = ((0.0, 10.0), (10.0, 20.0), (20.0, 40.0), (40.0, float("inf")))

    def places(self, truth: pathlib.Path, predictions: pathlib.Path) -> dict[str, pathlib.Path]:
        """Where the predictions of each sequence should be."""
        return {name: predictions / name / "predictions" for name in self.names}

    def compared(self, name: str, truth: pathlib.Path, predictions: pathlib.Path) -> Iterator[ComparedScan]:
        """The scans of a sequence that count."""
        sequence = truth / name
        found_files = numbered(predictions)
        scans = scans_of(self, sequence)
        if not scans:
            raise InputError(f"{sequence}: no labels/NNNNNN.label")
        for number, file in scans.items():
            if number not in found_files:
                raise InputError(f"{predictions}: no prediction of scan {number}, which counts")
            labels = np.fromfile(file, dtype="<u4")
            found = read_found(found_files[number], len(labels), str(file))
            used = np.ones(len(labels), dtype=bool)
            if self.unlabelled == "ignored":
                used = ~np.isin(labels & CLASS_BITS, UNLABELLED)
            ranges = ranges_of(sequence, file, len(labels))
            yield ComparedScan(is_moving(labels)[used], found[used], None if ranges is None else ranges[used])


def scans_of(protocol: Sequences, sequence: pathlib.Path) -> dict[int, pathlib.Path]:
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


SEMANTIC_KITTI = Sequences(("08",), "ignored")
KITTI_ROAD_MOS = Sequences(tuple(str(n) for n in range(30, 42)), "static")
# Ouster and Velodyne; 00 and 01 are no spinning lidars.
HELIMOS = Sequences(("02", "03"), "ignored", "test.txt")

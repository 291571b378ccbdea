"""DOALS: ten scans of each sequence with every person marked, whole range and 20 m."""

from __future__ import annotations

import pathlib
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

import mapless
from mapless._core import InputError
from mapless.protocols.counts import ComparedScan, Range, read_found

PLACES = ("hauptgebaeude", "niederdorf", "shopville", "station")
HALF_TURN_NS = 50_000_000  # of the OS1 at 10 Hz: a stamp is that of the scan whose start is nearest


def marked(file: pathlib.Path) -> dict[int, npt.NDArray[np.int64]]:
    """Numbers of the points that move, by stamp [ns] of the cloud: lines of stamp, number, number, ..."""
    if not file.is_file():
        raise InputError(f"{file}: missing: it says which points move")
    rows = {}
    for k, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
        try:
            stamp, *numbers = [int(text) for text in line.split(",") if text.strip()] or [0]
        except ValueError:
            raise InputError(f"{file} line {k}: expected a stamp in ns and numbers of points") from None
        if stamp:
            rows[stamp] = np.array(numbers, dtype=np.int64)
    return rows


class Doals:
    """Truth: PLACE/sequence_N/bag.bag and indices.csv; predictions: PLACE/sequence_N, results of `mapless detect`."""

    ranges: tuple[Range, ...] = ((0.0, 20.0),)

    def places(self, truth: pathlib.Path, predictions: pathlib.Path) -> dict[str, pathlib.Path]:
        names = [f"{place}/sequence_{n}" for place in PLACES for n in (1, 2)]
        return {name: predictions / name for name in names}

    def compared(self, name: str, truth: pathlib.Path, predictions: pathlib.Path) -> Iterator[ComparedScan]:
        recording = mapless.open(truth / name / "bag.bag")
        starts = np.array([recording.core.start_ns(k) for k in range(len(recording))])
        for stamp, numbers in sorted(marked(truth / name / "indices.csv").items()):
            k = int(np.abs(starts - stamp).argmin())
            if abs(int(starts[k]) - stamp) > HALF_TURN_NS:
                raise InputError(f"{truth / name}: its bag has no scan at {stamp} ns, which counts")
            scan = recording[k]
            label = predictions / "labels" / f"{k:06d}.label"
            if not label.is_file():
                raise InputError(f"{label}: missing: scan {k} counts")
            found = read_found(label, len(scan), f"scan {k} of the bag")
            if numbers.size and not 0 <= numbers.min() <= numbers.max() < len(scan):
                raise InputError(f"{truth / name / 'indices.csv'}: point {numbers.max()}: scan {k} has {len(scan)}")
            moving = np.zeros(len(scan), dtype=bool)
            moving[numbers] = True
            used = np.isfinite(scan.points).all(axis=1)
            range_m = np.linalg.norm(scan.points[used].astype(np.float64), axis=1)
            yield ComparedScan(moving[used], found[used], range_m)

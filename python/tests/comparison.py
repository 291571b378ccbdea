"""What tests of readers compare."""

import pathlib

import numpy as np

import mapless


def compact(scan: mapless.Scan) -> np.ndarray:
    """The returns of a scan as a driver publishes them: rows without a return left out."""
    return np.isfinite(scan.points).all(axis=1)


def iou(a: np.ndarray, b: np.ndarray) -> float:
    either = (a | b).sum()
    return float((a & b).sum() / either) if either else 1.0


FAULTY, NOTHING = 1, 2  # codes of the native format


def without_empty_rays(drive: pathlib.Path) -> None:
    """Lets no ray of a native recording say that there is nothing within range, which no driver says."""
    for file in (drive / "scans").glob("*.pcd"):
        head, mark, data = file.read_bytes().partition(b"DATA binary\n")
        lines = {line.split()[0].decode(): line.split()[1:] for line in head.splitlines()}
        sizes = [int(size) for size in lines["SIZE"]]
        at = sum(sizes[: lines["FIELDS"].index(b"code")])
        rows = np.frombuffer(data, np.uint8).reshape(-1, sum(sizes)).copy()
        rows[rows[:, at] == NOTHING, at] = FAULTY
        file.write_bytes(head + mark + rows.tobytes())

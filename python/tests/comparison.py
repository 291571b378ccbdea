"""What tests of readers compare."""

import numpy as np

import mapless


def compact(scan: mapless.Scan) -> np.ndarray:
    """The returns of a scan as a driver publishes them: rows without a return left out."""
    return np.isfinite(scan.points).all(axis=1)


def iou(a: np.ndarray, b: np.ndarray) -> float:
    either = (a | b).sum()
    return float((a & b).sum() / either) if either else 1.0

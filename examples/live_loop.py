"""Removes moving points from the clouds of a live sensor: python live_loop.py drive

The driver is played by a recording; a real one hands over the same arrays. Labels come one scan late, so the clouds
wait for theirs."""

import collections
import sys
from collections.abc import Iterator

import numpy as np

import mapless


def driver() -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, int]]:
    for scan in mapless.open(sys.argv[1]):
        assert scan.time_s is not None and scan.ring is not None
        yield scan.points, scan.time_s, scan.ring, scan.stamp_ns


waiting: collections.deque[np.ndarray] = collections.deque()
detector = mapless.OnlineDetector("VLP-16")
for points, time, ring, stamp_ns in driver():
    waiting.append(points)
    for found in detector.push(points, time=time, ring=ring, stamp_ns=stamp_ns):
        static = waiting.popleft()[~found.moving]
        print(f"scan {found.scan}: {len(static)} static points at {found.pose[:3, 3].round(2)} {found.trouble}")

#!/usr/bin/env python3
"""How well the probabilities of `mapless detect --probability` hold: of the points given about .9, how many move?

usage: probability_reliability.py MAPLESS RECORDING...

Labels recordings in the native format that have true labels and poses, and prints a table: points by their probability, its
mean, and the share of them that move. Points whose true label is 0 or 1 (unknown) do not count. Needs NumPy.
"""

import pathlib
import sys
import tempfile

import numpy as np

from shared import run

EDGES = np.array([0, 0.001, 0.01, 0.05, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.98, 1.001])


def sums(recording, result):
    """For each bin: points, sum of probabilities, points that move."""
    out = np.zeros((len(EDGES) - 1, 3))
    for file in sorted((result / "probability").glob("*.f32")):
        probability = np.fromfile(file, dtype="<f4")
        truth = np.fromfile(recording / "labels" / f"{file.stem}.label", dtype="<u4") & 0xFFFF
        known = np.isfinite(probability) & (truth > 1)
        given, moves = probability[known], truth[known] > 250
        where = np.searchsorted(EDGES, given, side="right") - 1
        for column, weights in enumerate((None, given, moves)):
            out[:, column] += np.bincount(where, weights=weights, minlength=len(out))
    return out


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    total = np.zeros((len(EDGES) - 1, 3))
    for recording in map(pathlib.Path, sys.argv[2:]):
        with tempfile.TemporaryDirectory() as folder:
            result = pathlib.Path(folder) / "result"
            poses = ["--trajectory", recording / "trajectory.txt"]
            run([sys.argv[1], "detect", recording, "-o", result, "--probability", *poses])
            total += sums(recording, result)
    print("| probability | points | mean | share that moves |\n|---|---|---|---|")
    for (low, high), (points, given, moving) in zip(zip(EDGES, EDGES[1:]), total):
        if points > 0:
            print(f"| {low:g} to {min(high, 1):g} | {points:.0f} | {given / points:.4f} | {moving / points:.4f} |")


if __name__ == "__main__":
    main()

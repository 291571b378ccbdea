#!/usr/bin/env python3
"""How smooth the motion is that the reference clouds of newer_college_gtsam_points were deskewed with.

usage: newer_college_reference.py FOLDER/newer_06

Fits a motion cubic in time (rotation vector and translation) that takes each raw scan to its deskewed one, robustly,
and prints the turn within the scan and what the fit leaves of the distances: no comparison can be closer.
"""

import pathlib
import sys

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

IMU_FROM_LIDAR_M = np.array([-0.006253, 0.011775, -0.028535])
HALF_TURN = np.array([-1.0, -1.0, 1.0])


def powers(times):
    return np.stack([times, 10 * times**2, 100 * times**3], axis=1)


def moved(coefficients, points, times):
    rotation, translation = coefficients.reshape(2, 3, 3)
    return Rotation.from_rotvec(powers(times) @ rotation).apply(points) + powers(times) @ translation


def main():
    folder = pathlib.Path(sys.argv[1])
    for number in range(3):
        raw, deskewed, times = (
            np.fromfile(folder / f"{name}_{number:02}.bin", "<f4").astype(np.float64)
            for name in ("raw", "deskewed", "times")
        )
        raw = raw.reshape(-1, 3)
        reference = (deskewed.reshape(-1, 3) - IMU_FROM_LIDAR_M) * HALF_TURN
        few = slice(None, None, 5)
        fit = least_squares(
            lambda x: (moved(x, raw[few], times[few]) - reference[few]).ravel(), np.zeros(18), loss="soft_l1", f_scale=0.05
        )
        turn = Rotation.from_rotvec(powers(np.array([times.max()])) @ fit.x[:9].reshape(3, 3)).magnitude()[0]
        left = np.linalg.norm(moved(fit.x, raw, times) - reference, axis=1)
        median, most = np.percentile(left, [50, 95])
        print(f"scan {number}: turns {np.degrees(turn):.2f} deg; left over, median {median:.4f} m, 95 % {most:.4f} m")


if __name__ == "__main__":
    main()

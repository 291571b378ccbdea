#!/usr/bin/env python3
"""Makes the fixture of tests/evaluation/trajectory_error_test.cpp: two trajectories, and what others say of them.

usage: make_trajectory_figures.py FOLDER

Writes true.txt and estimated.txt (TUM rows, one pose a scan, 10 Hz) and figures.txt: a name and a number a row.
Absolute and relative errors are those of evo, drift is that of KISS-ICP's port of KITTI's devkit. Needs requirements.txt.
"""

import pathlib
import sys

import numpy as np
from evo.core import metrics, sync
from evo.tools import file_interface
from kiss_icp.metrics import sequence_error
from scipy.spatial.transform import Rotation

POSES = 240
STEP_S = 0.1
STEP_M = 1.1


def chain(steps):
    poses = [np.eye(4)]
    for step in steps:
        poses.append(poses[-1] @ step)
    return poses


def make_steps(generator):
    """A winding, climbing drive, and the same with scale, yaw-rate and random errors."""
    true, estimated = [], []
    for k in range(POSES - 1):
        step = np.eye(4)
        turn = np.array([0.002 * np.sin(0.07 * k), 0.004 * np.cos(0.05 * k), 0.03 * np.sin(0.02 * k)])
        step[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
        step[:3, 3] = [STEP_M, 0.02 * np.sin(0.1 * k), 0.0]
        wrong = step.copy()
        noise = np.array([0, 0, 0.0004]) + generator.normal(0, 0.0005, 3)
        wrong[:3, :3] = Rotation.from_rotvec(turn + noise).as_matrix()
        wrong[:3, 3] = 1.004 * step[:3, 3] + generator.normal(0, 0.004, 3)
        true.append(step)
        estimated.append(wrong)
    return true, estimated


def write_tum(file, poses):
    rows = []
    for k, pose in enumerate(poses):
        numbers = [*pose[:3, 3], *Rotation.from_matrix(pose[:3, :3]).as_quat()]
        rows.append(f"{k * STEP_S:.1f} " + " ".join(f"{n:.9f}" for n in numbers))
    file.write_text("\n".join(rows) + "\n")


def ape(reference, estimate, relation):
    error = metrics.APE(relation)
    error.process_data((reference, estimate))
    return error.get_all_statistics()


def rpe(reference, estimate, relation):
    error = metrics.RPE(relation, 1, metrics.Unit.frames)
    error.process_data((reference, estimate))
    return error.get_all_statistics()


def evo_figures(folder):
    reference = file_interface.read_tum_trajectory_file(folder / "true.txt")
    estimate = file_interface.read_tum_trajectory_file(folder / "estimated.txt")
    reference, estimate = sync.associate_trajectories(reference, estimate)
    translation = metrics.PoseRelation.translation_part
    rotation = metrics.PoseRelation.rotation_angle_deg
    figures = {}
    for name, statistics in (
        ("rpe_translation_m", rpe(reference, estimate, translation)),
        ("rpe_rotation_deg", rpe(reference, estimate, rotation)),
    ):
        figures |= {f"{name}_{key}": statistics[key] for key in ("rmse", "mean", "median", "max")}
    estimate.align_origin(reference)
    figures["from_first_translation_m_rmse"] = ape(reference, estimate, translation)["rmse"]
    figures["from_first_rotation_deg_rmse"] = ape(reference, estimate, rotation)["rmse"]
    estimate.align(reference)
    for key in ("rmse", "mean", "median", "max"):
        figures[f"aligned_m_{key}"] = ape(reference, estimate, translation)[key]
    return figures, reference.poses_se3, estimate.poses_se3


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    true, estimated = make_steps(np.random.default_rng(4))
    start = np.eye(4)
    start[:3, :3] = Rotation.from_rotvec([0.3, -0.2, 2.0]).as_matrix()
    start[:3, 3] = [40, -7, 3]
    write_tum(folder / "true.txt", [start @ pose for pose in chain(true)])
    write_tum(folder / "estimated.txt", chain(estimated))
    figures, reference, estimate = evo_figures(folder)
    translation_percent, rotation_deg_per_m = sequence_error(reference, estimate)
    figures["kitti_translation_percent"] = translation_percent
    # The port takes 3.14 for pi.
    figures["kitti_rotation_deg_per_100m"] = 100 * rotation_deg_per_m * 3.14 / np.pi
    rows = [f"{name} {value:.9g}" for name, value in figures.items()]
    (folder / "figures.txt").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()

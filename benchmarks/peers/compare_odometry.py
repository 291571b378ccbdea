#!/usr/bin/env python3
"""Runs KISS-ICP and `mapless odometry` on the same raw scans, one after the other, and evaluates both the same way.

usage: compare_odometry.py [--mapless build/mapless] [--kitti DRIVE] [--duration-s 20] [--write docs/notebook/odometry.md]

Makes short simulated recordings in --work where they are not there yet. KISS-ICP is the Python package of
requirements.txt with its defaults: deskewing on, given the time of every point, one thread. Its poses are those of the
end of each scan, to which it deskews; between them they are interpolated at constant velocity, which is kinder than the
motion it deskews with, that of the scan before. Where the truth is known it runs once more, given the motion of the
first scan: by itself it does not get going where a drive begins fast. `mapless evaluate` evaluates all. Times are those of
the process on its CPU, so that what else runs on the machine does not count. With --write, the table replaces the one
between the two marks in that file.
"""

import argparse
import json
import pathlib
import statistics
import sys
import time

import numpy as np
from scipy.spatial.transform import Rotation

from recordings import scans

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from shared import dated_table, run, simulate, write_between_marks  # noqa: E402

SIMULATED = [
    ("town1", "HDL-64E-S2"),
    ("highway", "HDL-64E-S2"),
    ("forest", "HDL-64E-S2"),
    ("tunnel", "HDL-64E-S2"),
    ("town1", "VLP-16"),
]
COLUMNS = [
    "recording",
    "odometry",
    "drift [%]",
    "drift [deg/100 m]",
    "per scan [m]",
    "per scan [deg]",
    "static points, 95 % [m]",
    "of all scans [m]",
    "ms a scan",
]


def run_mapless(options, folder, output):
    command = [options.mapless, "odometry", folder, "-o", output, "--overwrite"]
    summary = json.loads(run(command + ["--poses-per-scan", 10, "--threads", 1, "--json"]))
    return ["mapless", output, [], summary["scan_cpu_ms"]["median"]]


def run_kiss_icp(folder, output, first_motion=None):
    from kiss_icp.config.parser import load_config
    from kiss_icp.kiss_icp import KissICP

    config = load_config(None)
    config.registration.max_num_threads = 1
    odometry = KissICP(config)
    if first_motion is not None:
        odometry.last_delta = first_motion
    rows, times = [], []
    for points, stamps in scans(folder):
        begin = time.process_time()
        odometry.register_frame(points, stamps)
        times.append(1e3 * (time.process_time() - begin))
        rows.append(odometry.last_pose[:3].ravel())
    np.savetxt(output, rows)
    name = "KISS-ICP" if first_motion is None else "KISS-ICP, given its first motion"
    return [name, output, ["--pose-instant", "end"], statistics.median(times)]


def figures(report, ms):
    def of(*path, form):
        value = report
        for name in path:
            value = None if value is None else value[name]
        return "-" if value is None else form.format(value)

    return [
        of("drift", "translation_percent", form="{:.3f}"),
        of("drift", "rotation_deg_per_100m", form="{:.3f}"),
        of("relative_per_scan_settled", "translation_m", "rmse", form="{:.4f}"),
        of("relative_per_scan_settled", "rotation_deg", "rmse", form="{:.4f}"),
        of("displacement_settled", "distance_m", "p95", form="{:.4f}"),
        of("displacement", "distance_m", "p95", form="{:.4f}"),
        f"{ms:.1f}",
    ]


def true_first_motion(folder):
    """Of the first scan: the pose at its end in the sensor frame of its start."""
    rows = np.loadtxt(folder / "trajectory.txt")
    poses = []
    for t in np.loadtxt(folder / "times.txt")[:2]:
        row = rows[np.argmin(np.abs(rows[:, 0] - t))]
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_quat(row[4:]).as_matrix()
        pose[:3, 3] = row[1:4]
        poses.append(pose)
    return np.linalg.inv(poses[0]) @ poses[1]


def compare(options, name, folder, evaluate_with):
    runs = [
        run_mapless(options, folder, options.work / "mapless_result"),
        run_kiss_icp(folder, options.work / "kiss_icp_poses.txt"),
    ]
    if (folder / "trajectory.txt").exists():
        motion = true_first_motion(folder)
        runs.append(run_kiss_icp(folder, options.work / "kiss_icp_first_motion_poses.txt", motion))
    for odometry, result, how, ms in runs:
        command = [options.mapless, "evaluate", folder, result, "--json", "-"] + how + evaluate_with
        row = [name, odometry] + figures(json.loads(run(command))["trajectory"], ms)
        print(" | ".join(row), flush=True)
        yield row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mapless", default="build/mapless", type=pathlib.Path)
    parser.add_argument("--work", default="build/peers", type=pathlib.Path, help="folder for recordings and results")
    parser.add_argument("--duration-s", default=20, type=float, help="of each simulated recording")
    parser.add_argument("--kitti", type=pathlib.Path, help="a KITTI raw drive with poses_icp.txt (mid-scan)")
    parser.add_argument("--write", type=pathlib.Path, help="put the table into this document")
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    rows = []
    print(" | ".join(COLUMNS))
    for scene, sensor in SIMULATED:
        folder = options.work / f"{scene}_{sensor}_{options.duration_s:g}s"
        simulate(options.mapless, scene, folder, "--sensor", sensor, "--duration-s", options.duration_s)
        rows += compare(options, f"{scene}, {sensor}", folder, [])
    if options.kitti:
        reference = ["--reference-trajectory", options.kitti / "poses_icp.txt", "--reference-pose-instant", "middle"]
        rows += compare(options, options.kitti.name, options.kitti, reference)
    command = f"benchmarks/peers/compare_odometry.py --duration-s {options.duration_s:g}"
    text = dated_table(command + (" --kitti $DRIVE" if options.kitti else ""), COLUMNS, rows)
    print(text)
    if options.write:
        write_between_marks(options.write, "compare_odometry.py", text)


if __name__ == "__main__":
    main()

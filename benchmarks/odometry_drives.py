#!/usr/bin/env python3
"""Simulates a drive of every scene with several sensors and says how well `mapless odometry` follows it.

usage: odometry_drives.py [--mapless build/mapless] [--work FOLDER] [--duration-s 60] [--seed 300] [--keep]
                          [--scenes town1 ...] [--sensors HDL-64E-S2 ...] [--write docs/notebook/odometry.md]

A drive takes 0.2 to 1.8 GB in --work and is deleted once it is evaluated, unless --keep. Needs NumPy and SciPy. With
--write, the table replaces the one between the two marks in that file. "start" is the largest distance from the truth
within the second to the eleventh scan, the first poses laid upon each other; everything else is what `mapless evaluate`
says, over all scans. What misses its bar is in bold.
"""

import argparse
import json
import pathlib
import shutil

import numpy as np

from shared import SCENES, poses, run, simulate, write_between_marks

SENSORS = ["HDL-64E-S2", "VLP-16", "OS1-128"]
POSES_PER_SCAN = 10
# Name of the column, format, and the bar it is held against.
COLUMNS = [
    ("drift [%]", "{:.3f}", 0.3),
    ("drift [deg/m]", "{:.4f}", 0.002),
    ("per scan [m]", "{:.4f}", 0.02),
    ("per scan [deg]", "{:.4f}", 0.05),
    ("velocity [m/s]", "{:.3f}", 0.05),
    ("static points, 95 % [m]", "{:.4f}", 0.03),
    ("start [m]", "{:.3f}", 0.10),
    ("ms a scan", "{:.1f}", None),
]


def start_error(folder, result):
    estimate = np.loadtxt(result / "trajectory.txt")
    rows = estimate[: 11 * POSES_PER_SCAN]
    p, R = poses(rows, rows[:, 0])
    p_true, R_true = poses(np.loadtxt(folder / "trajectory.txt"), rows[:, 0])
    ours = R[0].inv().apply(p - p[0])
    true = R_true[0].inv().apply(p_true - p_true[0])
    return float(np.linalg.norm(ours - true, axis=1)[POSES_PER_SCAN:].max())


def rmse(report, *path):
    for name in path:
        report = report[name]
    return report["rmse"]


def evaluate(options, folder, result):
    command = [options.mapless, "odometry", folder, "-o", result, "--overwrite", "--json"]
    summary = json.loads(run(command + ["--poses-per-scan", POSES_PER_SCAN, "--threads", options.threads]))
    report = json.loads(run([options.mapless, "evaluate", folder, result, "--json", "-"]))["trajectory"]
    drift = report["drift"]
    values = [
        drift and drift["translation_percent"],
        drift and drift["rotation_deg_per_100m"] / 100,
        rmse(report, "relative_per_scan", "translation_m"),
        rmse(report, "relative_per_scan", "rotation_deg"),
        rmse(report, "velocity", "linear_m_per_s"),
        report["displacement"]["distance_m"]["p95"],
        start_error(folder, result),
        summary["scan_cpu_ms"]["median"],
    ]
    return values, summary["trouble"]


def cell(value, form, bar):
    if value is None:
        return "-"
    text = form.format(value)
    return f"**{text}**" if bar is not None and value > bar else text


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mapless", default="build/mapless", type=pathlib.Path)
    parser.add_argument("--work", default="build/odometry_drives", type=pathlib.Path)
    parser.add_argument("--duration-s", default=60, type=float)
    parser.add_argument("--seed", default=300, type=int)
    parser.add_argument("--threads", default=1, type=int)
    parser.add_argument("--scenes", nargs="+", default=SCENES)
    parser.add_argument("--sensors", nargs="+", default=SENSORS)
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--write", type=pathlib.Path)
    return parser.parse_args()


def main():
    options = arguments()
    options.work.mkdir(parents=True, exist_ok=True)
    head = ["drive"] + [name for name, _, _ in COLUMNS]
    lines = [" | ".join(head), " | ".join(["---"] * len(head))]
    troubles = []
    for sensor in options.sensors:
        for scene in options.scenes:
            folder = options.work / f"{scene}_{sensor}_{options.seed}"
            how = ["--sensor", sensor, "--seed", options.seed, "--duration-s", options.duration_s]
            simulate(options.mapless, scene, folder, *how, "--range-noise-m", 0.02, "--threads", options.threads)
            values, trouble = evaluate(options, folder, options.work / "result")
            cells = [cell(value, form, bar) for value, (_, form, bar) in zip(values, COLUMNS)]
            lines.append(" | ".join([f"{scene}, {sensor}"] + cells))
            print(lines[-1], flush=True)
            if trouble:
                troubles.append(f"- {scene}, {sensor}: {trouble}")
                print(troubles[-1], flush=True)
            if not options.keep:
                shutil.rmtree(folder)
    table = "\n".join(f"| {line} |" for line in lines)
    text = f"{table}\n\nWarnings of `mapless odometry` on these drives:\n\n" + "\n".join(troubles)
    if options.write:
        write_between_marks(options.write, "odometry_drives.py", text)


if __name__ == "__main__":
    main()

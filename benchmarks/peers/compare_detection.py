#!/usr/bin/env python3
"""Runs DUFOMap and `mapless detect` on the same recordings, one after the other, and evaluates both the same way.

usage: compare_detection.py [--mapless build/mapless] [--duration-s 12] [--seed 501] [--write docs/accuracy.md]

Makes short simulated recordings in --work where they are not there yet. DUFOMap is the Python package of
requirements.txt with the parameters of its paper, one thread. It cleans maps; here it runs online: the scans go in
one after the other, each from its true pose, and the points of a scan are classified once the next one is in, the
latency that mapless has. It gets every point where it truly was, in the frame of the first scan, and once more the raw
scans, each from the pose of its middle. `mapless evaluate` evaluates all. Times are CPU times, mean: of DUFOMap those of
run() and segment(), of mapless those of the whole command, reading and writing included.
"""

import argparse
import json
import pathlib
import resource
import statistics
import sys
import time

import numpy as np

from recordings import native_hits

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from shared import SCENES, dated_table, poses, run, simulate, write_between_marks  # noqa: E402

SENSOR = "HDL-64E-S2"
VOXEL_M, INFLATED_HITS_M, INFLATED_UNKNOWN_VOXELS = 0.1, 0.2, 1
STATIC, DYNAMIC = 9, 251
DETECTORS = ["mapless", "DUFOMap", "DUFOMap, raw"]
FIGURES = ["IoU", "precision", "recall", "ms a scan"]
# One row a recording; of each detector its figures, one after the other.
COLUMNS = ["recording"] + [f"{name}: {', '.join(FIGURES)}" for name in DETECTORS]


def run_mapless(options, folder):
    output = options.work / "mapless_detection"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run([options.mapless, "detect", folder, "-o", output, "--overwrite", "--threads", 1])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return [DETECTORS[0], output, 1e3 * seconds / len(np.loadtxt(folder / "times.txt"))]


def placed_scans(folder, deskewed):
    """Of each scan the hits and the pose of its middle, in the frame of the first scan, and which records are hits."""
    trajectory = np.loadtxt(folder / "trajectory.txt")
    origin = None
    for start, (points, times, hits) in zip(np.loadtxt(folder / "times.txt"), native_hits(folder)):
        middle = np.array([start + (times.min() + times.max()) / 2])
        p, R = poses(trajectory, middle)
        if origin is None:
            origin = p[0], R[0].inv()
        p_points, R_points = poses(trajectory, start + times) if deskewed else (p, R[0])
        world = R_points.apply(points) + p_points
        pose = np.eye(4)
        pose[:3, :3] = (origin[1] * R[0]).as_matrix()
        pose[:3, 3] = origin[1].apply(p[0] - origin[0])
        yield origin[1].apply(world - origin[0]), pose, hits


def write_labels(output, number, dynamic, hits):
    labels = np.zeros(len(hits), "<u4")
    labels[hits] = np.where(dynamic, DYNAMIC, STATIC)
    labels.tofile(output / "labels" / f"{number:06}.label")


def run_dufomap(options, folder, deskewed):
    from dufomap import dufomap

    name = DETECTORS[1] if deskewed else DETECTORS[2]
    output = options.work / ("dufomap_deskewed" if deskewed else "dufomap_raw")
    (output / "labels").mkdir(parents=True, exist_ok=True)
    for old in (output / "labels").glob("*.label"):
        old.unlink()
    world = dufomap(VOXEL_M, INFLATED_HITS_M, INFLATED_UNKNOWN_VOXELS, num_threads=1)
    scans = list(placed_scans(folder, deskewed))
    seconds = 0
    for k in range(len(scans) + 1):
        begin = time.process_time()
        if k < len(scans):
            world.run(scans[k][0], scans[k][1], cloud_transform=False)
        if k > 0:
            dynamic = world.segment(scans[k - 1][0], scans[k - 1][1], cloud_transform=False) == 1
        seconds += time.process_time() - begin
        if k > 0:
            write_labels(output, k - 1, dynamic, scans[k - 1][2])
    return [name, output, 1e3 * seconds / len(scans)]


def compare(options, scene):
    """Of each detector, in the order of DETECTORS, its FIGURES for one recording."""
    folder = options.work / f"{scene}_{SENSOR}_{options.seed}_{options.duration_s:g}s"
    how = ["--sensor", SENSOR, "--duration-s", options.duration_s, "--seed", options.seed]
    simulate(options.mapless, scene, folder, *how, "--threads", 1)
    figures = {}
    for name, output, ms in (
        run_mapless(options, folder),
        run_dufomap(options, folder, deskewed=True),
        run_dufomap(options, folder, deskewed=False),
    ):
        found = json.loads(run([options.mapless, "evaluate", folder, output, "--json", "-"]))["final"]
        figures[name] = [found["iou"], found["precision"], found["recall"], ms]
    return [figures[name] for name in DETECTORS]


def cell(figures):
    *rates, ms = figures
    return ", ".join(["-" if rate is None else f"{rate:.3f}" for rate in rates] + [f"{ms:.0f}"])


def table_row(recording, detectors):
    return [recording] + [cell(figures) for figures in detectors]


def means(found):
    """Over the recordings; rates that a recording does not have do not count."""
    return [[statistics.mean(v for v in column if v is not None) for column in zip(*of_one)] for of_one in zip(*found)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mapless", default="build/mapless", type=pathlib.Path)
    parser.add_argument("--work", default="build/peers", type=pathlib.Path, help="folder for recordings and results")
    parser.add_argument("--duration-s", default=12, type=float, help="of each simulated recording")
    parser.add_argument("--seed", default=501, type=int, help="of the simulated recordings")
    parser.add_argument("--scenes", nargs="+", default=SCENES, choices=SCENES)
    parser.add_argument("--write", type=pathlib.Path, help="put the table into this document")
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    found = []
    print(" | ".join(COLUMNS))
    for scene in options.scenes:
        found.append(compare(options, scene))
        print(" | ".join(table_row(scene, found[-1])), flush=True)
    rows = [table_row(scene, detectors) for scene, detectors in zip(options.scenes, found)]
    command = f"benchmarks/peers/compare_detection.py --duration-s {options.duration_s:g} --seed {options.seed}"
    command += "" if options.scenes == SCENES else " --scenes " + " ".join(options.scenes)
    text = dated_table(command, COLUMNS, rows + [table_row("mean", means(found))])
    print(text)
    if options.write:
        write_between_marks(options.write, "compare_detection.py", text)


if __name__ == "__main__":
    main()

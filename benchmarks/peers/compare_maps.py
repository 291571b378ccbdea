#!/usr/bin/env python3
"""Cleans the map of simulated drives with DUFOMap and with `mapless detect`, and compares the two with the truth.

usage: compare_maps.py [--mapless build/mapless] [--duration-s 12] [--seed 501] [--write docs/export.md]

The clean map has the points labelled static. DUFOMap (the Python package of requirements.txt, parameters of its paper)
gets every scan first, each point where it truly was and each scan from its true pose, and is then queried about
all points: its intended use. mapless labels online, one scan late, from the raw scans: with the true poses, and along its
own odometry. Points: share of the static ones kept, and of those that moved when they were seen removed. Voxels of
0.1 m: share of those with a static point that the map has, and of those without one that it does not have.
"""

import argparse
import pathlib
import statistics
import sys

import numpy as np

from compare_detection import INFLATED_HITS_M, INFLATED_UNKNOWN_VOXELS, SENSOR, VOXEL_M, placed_scans

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from shared import SCENES, dated_table, run, simulate, write_between_marks  # noqa: E402

STATIC, DYNAMIC = 9, 251
CLEANERS = ["mapless", "mapless, own odometry", "DUFOMap"]
FIGURES = ["static points kept", "moving points removed", "static voxels kept", "moving voxels removed"]
COLUMNS = ["recording"] + CLEANERS  # of each its FIGURES in percent


def read_labels(folder, hits):
    """Class of each hit of each scan."""
    files = sorted((folder / "labels").glob("*.label"))
    return [np.fromfile(file, "<u4")[of_scan] & 0xFFFF for file, of_scan in zip(files, hits, strict=True)]


def dufomap_labels(scans):
    from dufomap import dufomap

    world = dufomap(VOXEL_M, INFLATED_HITS_M, INFLATED_UNKNOWN_VOXELS, num_threads=1)
    for points, pose, _ in scans:
        world.run(points, pose, cloud_transform=False)
    dynamic = [world.segment(points, pose, cloud_transform=False) == 1 for points, pose, _ in scans]
    return [np.where(d, DYNAMIC, STATIC) for d in dynamic]


def mapless_labels(options, folder, hits, *how):
    output = options.work / "mapless_map"
    run([options.mapless, "detect", folder, "-o", output, "--overwrite", *how])
    return read_labels(output, hits)


def voxels(points):
    return np.unique(np.floor(points / VOXEL_M).astype(np.int32), axis=0)


def count_common(a, b):
    both = np.concatenate([a, b])
    return len(both) - len(np.unique(both, axis=0))  # each of the two has no row twice


def figures(points, truth, labels):
    """FIGURES in percent; None where the recording has nothing of a kind."""
    static, moving, kept = truth == STATIC, truth == DYNAMIC, labels != DYNAMIC
    of_map, of_static = voxels(points[kept & (static | moving)]), voxels(points[static])
    of_moving = voxels(points[moving])
    only_moving = len(of_moving) - count_common(of_moving, of_static)
    static_kept = count_common(of_map, of_static)
    left_over = len(of_map) - static_kept  # voxels of the map that have no static point
    return [
        100 * np.mean(kept[static]),
        100 * np.mean(~kept[moving]) if moving.any() else None,
        100 * static_kept / len(of_static),
        100 * (1 - left_over / only_moving) if only_moving else None,
    ]


def compare(options, scene):
    folder = options.work / f"{scene}_{SENSOR}_{options.seed}_{options.duration_s:g}s"
    simulate(options.mapless, scene, folder, "--sensor", SENSOR, "--duration-s", options.duration_s, "--seed", options.seed)
    scans = list(placed_scans(folder, deskewed=True))
    hits = [of_scan for _, _, of_scan in scans]
    points, truth = np.concatenate([p for p, _, _ in scans]), np.concatenate(read_labels(folder, hits))
    found = [
        mapless_labels(options, folder, hits),
        mapless_labels(options, folder, hits, "--odometry"),
        dufomap_labels(scans),
    ]
    return [figures(points, truth, np.concatenate(labels)) for labels in found]


def row(recording, cleaners):
    return [recording] + [", ".join("-" if v is None else f"{v:.1f}" for v in of_one) for of_one in cleaners]


def means(found):
    return [[statistics.mean(v for v in column if v is not None) for column in zip(*of_one)] for of_one in zip(*found)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mapless", default="build/mapless", type=pathlib.Path)
    parser.add_argument("--work", default="build/peers", type=pathlib.Path, help="folder for recordings and results")
    parser.add_argument("--duration-s", default=12, type=float, help="of each simulated recording")
    parser.add_argument("--seed", default=501, type=int, help="of the simulated recordings")
    parser.add_argument("--scenes", nargs="+", default=["town1", "town2", "highway", "crossing"], choices=SCENES)
    parser.add_argument("--write", type=pathlib.Path, help="put the table into this document")
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    found = []
    for scene in options.scenes:
        found.append(compare(options, scene))
        print(" | ".join(row(scene, found[-1])), flush=True)
    rows = [row(scene, cleaners) for scene, cleaners in zip(options.scenes, found)] + [row("mean", means(found))]
    command = f"benchmarks/peers/compare_maps.py --duration-s {options.duration_s:g} --seed {options.seed}"
    text = dated_table(command, COLUMNS, rows)
    print(text)
    if options.write:
        write_between_marks(options.write, "compare_maps.py", text)


if __name__ == "__main__":
    main()

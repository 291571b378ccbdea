#!/usr/bin/env python3
"""What each reading of the paper's open points contributes: the ablation table of docs/paper_map.md.

Profiles `paper` (the sensible readings) and `paper-literal` (the plainest) differ in the parameters of READINGS. Each is
switched by itself, in both directions: in `paper` to the plain reading, and in `paper-literal` to the sensible one. The
figures are the IoU of the moving points over all scans, with given poses, on simulated HDL-64E-S2 recordings and on KITTI
raw drive 0005 (DATA/kitti_raw; skipped, saying so, where it is absent). Results that are there already are kept.

usage: paper_readings.py [--mapless MAPLESS] [--data DATA] [--work FOLDER] [--duration-s S] [--seed N] [--write]
"""

import argparse
import json
import pathlib
import sys

from shared import dated_table, run, simulate, write_between_marks

ROOT = pathlib.Path(__file__).resolve().parent.parent
DRIVE = pathlib.Path("kitti_raw/2011_09_26/2011_09_26_drive_0005_sync")
SCENES = ["town1", "town2", "forest"]

# The open point, its plain and its sensible reading in words, the parameters that switch it
READINGS = [
    ("normals", "ten nearest neighbours", "window of the aligned image", ["normals.method"]),
    ("points without a normal", "compared with the nearest point at any range", "static beyond 25 m",
     ["comparison.max_range_without_normal_m"]),
    ("how near a ray must pass", "the nearest ray counts, however far", "one laser spacing x range + 0.05 m",
     ["freespace.require_near_ray"]),
    ("image of the box filter", "rows as recorded", "rows shifted by the lasers' azimuth offsets", ["box_filter.image"]),
    ("link of clusters and growth", "0.5 m", "0.12 m + 0.015 x range", ["region_growth.link_m", "region_growth.link_per_m"]),
    ("smallest cluster", "one point", "10 points", ["region_growth.min_cluster_points"]),
    ("reach of growth", "unlimited", "2 m from the nearest seed", ["region_growth.max_growth_m"]),
    ("tolerance of convexity", "0 degrees", "5 degrees", ["region_growth.concave_tolerance_deg"]),
]


def parameters_of(mapless, profile):
    """Of `mapless config`: every key with its value as text, in the form that --set takes."""
    values, group = {}, ""
    for line in run([mapless, "config", "--profile", profile]).splitlines():
        key, colon, value = line.partition(":")
        if not colon or key.strip().startswith("#"):
            continue
        if not value.strip():
            group = f"{key}."
        else:
            values[group + key.strip() if key.startswith(" ") else key] = value.strip()
    return values


def settings(mapless):
    """Options of `mapless detect` for each run, by name. Ends the script where READINGS lacks a parameter."""
    sensible, plain = parameters_of(mapless, "paper"), parameters_of(mapless, "paper-literal")
    differing = {key for key in sensible if sensible[key] != plain[key]}
    listed = {key for *_, keys in READINGS for key in keys}
    if differing != listed:
        sys.exit(f"paper_readings.py: the profiles differ in {sorted(differing)}, READINGS has {sorted(listed)}")
    runs = {"paper": ["--profile", "paper"], "paper-literal": ["--profile", "paper-literal"]}
    for point, _, _, keys in READINGS:
        for profile, values in [("paper", plain), ("paper-literal", sensible)]:
            switches = [word for key in keys for word in ("--set", f"{key}={values[key]}")]
            runs[f"{profile}: {point}"] = ["--profile", profile, *switches]
    return runs


def iou(mapless, recording, labels, how, folder):
    evaluation = folder.with_suffix(".json")
    if not evaluation.exists():
        run([mapless, "detect", recording, "-o", folder, "--overwrite", *how])
        run([mapless, "evaluate", recording, folder, *labels, "--json", evaluation])
    return json.loads(evaluation.read_text())["stages"][-1]["iou"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mapless", type=pathlib.Path, default=ROOT / "build" / "mapless")
    parser.add_argument("--data", type=pathlib.Path, default=ROOT.parent / "shared" / "data")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out" / "paper_readings",
                        help="folder for recordings and results")
    parser.add_argument("--duration-s", type=float, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true", help="put the table into docs/paper_map.md")
    options = parser.parse_args()

    options.work.mkdir(parents=True, exist_ok=True)
    how = ["--sensor", "HDL-64E-S2", "--seed", options.seed, "--duration-s", options.duration_s]
    recordings = {}
    drive = options.data / DRIVE
    if drive.exists():
        recordings["KITTI"] = (drive, ["--labels", drive / "labels_derived"], ["--trajectory", drive / "poses_icp.txt"])
    else:
        print(f"{drive} is absent: without the KITTI drive", file=sys.stderr)
    for scene in SCENES:
        folder = options.work / f"{scene}-{options.seed}-{options.duration_s:g}s"
        recordings[scene] = (simulate(options.mapless, scene, folder, *how), [], [])

    runs = settings(options.mapless)
    found = {name: [] for name in runs}
    for recording, (folder, labels, trajectory) in recordings.items():
        for number, (name, switches) in enumerate(runs.items()):
            result = options.work / f"{folder.name}-{number:02}"
            found[name].append(iou(options.mapless, folder, labels, [*trajectory, *switches], result))
            print(f"{recording}, {name}: {found[name][-1]:.3f}", file=sys.stderr, flush=True)

    def figures(name):
        return [f"{value:.3f}".removeprefix("0") for value in found[name]]

    columns = ["reading", "plain", "sensible", "`paper` with the plain one: " + ", ".join(recordings),
               "`paper-literal` with the sensible one"]
    rows = [["none switched", "", "", ", ".join(figures("paper")), ", ".join(figures("paper-literal"))]]
    for point, plain, sensible, _ in READINGS:
        rows.append([point, plain, sensible, ", ".join(figures(f"paper: {point}")),
                     ", ".join(figures(f"paper-literal: {point}"))])
    command = f"benchmarks/paper_readings.py --duration-s {options.duration_s:g} --seed {options.seed}"
    table = dated_table(command, columns, rows)
    print(table)
    if options.write:
        write_between_marks(ROOT / "docs" / "paper_map.md", pathlib.Path(__file__).name, table)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Compares labels, stages, objects and trajectory of fixed runs with the recorded digests (tests/digests/digests.json).

A change that is not meant to change any result keeps every digest; one that is meant to records them anew, in a commit
of its own that says why. Simulated recordings and results depend, in the last bits, on the compiler and on the vector
instructions that Embree and the C library choose: where a recording itself differs from the recorded one, its run is
compared by the number of dynamic points, within 2 %, and the report says so.

usage: check_digests.py [--record] [--data FOLDER] [--only NAME ...] [MAPLESS]
"""

import argparse
import array
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RECORDED = ROOT / "tests" / "digests" / "digests.json"
DRIVE = pathlib.Path("kitti_raw/2011_09_26/2011_09_26_drive_0005_sync")
SCENES = ["town1", "town2", "highway", "forest", "tunnel", "flyer", "tilted", "crossing"]
DYNAMIC = 251
COUNT_TOLERANCE = 0.02

# name: (scene or None for the KITTI drive, sensor, options of `mapless detect`)
RUNS = {f"{scene}-HDL-64E": (scene, "HDL-64E-S2", []) for scene in SCENES} | {
    "flyer-VLP-16": ("flyer", "VLP-16", []),
    "town1-VLP-16-odometry": ("town1", "VLP-16", ["--odometry"]),
    "highway-OS1-128-odometry": ("highway", "OS1-128", ["--odometry"]),
    "tunnel-Pandar64-odometry": ("tunnel", "Pandar64", ["--odometry"]),
    "crossing-HDL-64E-odometry": ("crossing", "HDL-64E-S2", ["--odometry"]),
    "town1-HDL-64E-causal": ("town1", "HDL-64E-S2", ["--causal"]),
    "town2-HDL-64E-paper": ("town2", "HDL-64E-S2", ["--profile", "paper", "--count", "10"]),
    "town2-HDL-64E-paper-literal": ("town2", "HDL-64E-S2", ["--profile", "paper-literal", "--count", "6"]),
    "kitti-poses": (None, None, ["--trajectory", str(DRIVE / "poses_icp.txt"), "--count", "25"]),
    "kitti-odometry": (None, None, ["--count", "25"]),
}


def digest(files):
    total = hashlib.sha256()
    for file in files:
        total.update(file.name.encode() + b"\0" + file.read_bytes())
    return total.hexdigest()[:16]


def dynamic_points(result):
    count = 0
    for file in (result / "labels").glob("*.label"):
        labels = array.array("I", file.read_bytes())
        count += sum(1 for label in labels if label & 0xFFFF == DYNAMIC)
    return count


def run(mapless, *arguments):
    done = subprocess.run([mapless, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"check_digests.py: {' '.join(map(str, [mapless, *arguments]))}: {done.stderr.strip()}")


def recording_of(mapless, scene, sensor, work):
    recording = work / f"{scene}-{sensor}"
    if not recording.exists():
        run(mapless, "simulate", scene, "--sensor", sensor, "--seed", 7, "--duration-s", 2.5, "-o", recording)
    return recording


def outcome(mapless, name, data, work):
    scene, sensor, options = RUNS[name]
    recording = recording_of(mapless, scene, sensor, work) if scene else data / DRIVE
    options = [str(data / option) if option.startswith(str(DRIVE)) else option for option in options]
    result = work / f"result-{name}"
    run(mapless, "detect", recording, "-o", result, *options)
    found = {
        "recording": digest(sorted((recording / "scans").glob("*.pcd"))) if scene else "as downloaded",
        "labels": digest(sorted((result / "labels").iterdir())),
        "stages": digest(sorted((result / "stages").iterdir())),
        "objects": digest([result / "objects.csv"]),
        "trajectory": digest([result / "trajectory.txt", result / "poses_kitti.txt"]),
        "dynamic_points": dynamic_points(result),
    }
    return found


def fault(expected, found):
    """What differs, in words; empty where nothing does."""
    if expected["recording"] == found["recording"]:
        differing = [key for key in expected if expected[key] != found[key]]
        return f"other {', '.join(differing)}" if differing else ""
    allowed = COUNT_TOLERANCE * expected["dynamic_points"] + 50
    if abs(expected["dynamic_points"] - found["dynamic_points"]) <= allowed:
        return ""
    return f"{found['dynamic_points']} dynamic points, not {expected['dynamic_points']}, in another recording"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mapless", nargs="?", default=str(ROOT / "build" / "mapless"))
    parser.add_argument("--record", action="store_true", help="write the digests of this build")
    parser.add_argument("--data", type=pathlib.Path, default=ROOT.parent / "shared" / "data")
    parser.add_argument("--only", nargs="+", default=list(RUNS), choices=list(RUNS), metavar="NAME")
    options = parser.parse_args()

    recorded = json.loads(RECORDED.read_text()) if RECORDED.exists() else {}
    faults = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in options.only:
            if RUNS[name][0] is None and not (options.data / DRIVE).exists():
                print(f"{name}: skipped, {options.data / DRIVE} is absent")
                continue
            found = outcome(options.mapless, name, options.data, pathlib.Path(folder))
            if options.record:
                recorded[name] = found
                continue
            difference = fault(recorded[name], found)
            exact = recorded[name]["recording"] == found["recording"]
            print(f"{name}: {difference or ('same' if exact else 'as many dynamic points, in another recording')}",
                  flush=True)
            faults += difference != ""
    if options.record:
        RECORDED.write_text(json.dumps(recorded, indent=1) + "\n")
        print(f"recorded {len(recorded)} runs in {RECORDED.relative_to(ROOT)}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Tries the usual mistakes on a right recording: spoils a copy in each way, runs `mapless detect` on it, and prints
the case, the exit code, and the line that says why. A mistake that ends with 0 is a failure; so is the untouched
recording where it does not. Needs NumPy.

usage: try_mistakes.py MAPLESS [--recording FOLDER] [--other FOLDER] [--only TEXT ...]

Without --recording it simulates 24 scans of a town. --other: a second recording, whose poses do not fit.
"""

import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import numpy as np

TYPES = {("F", 4): "<f4", ("F", 8): "<f8", ("U", 1): "u1", ("U", 4): "<u4", ("I", 4): "<i4"}


def read_pcd(file):
    """The header (bytes) and the points (structured array) of a binary PCD file."""
    data = file.read_bytes()
    end = data.index(b"\n", data.index(b"\nDATA ") + 1) + 1
    header = dict(line.split(" ", 1) for line in data[:end].decode().splitlines() if not line.startswith("#"))
    kinds = [TYPES[t, int(s)] for t, s in zip(header["TYPE"].split(), header["SIZE"].split())]
    return data[:end], np.frombuffer(data[end:], list(zip(header["FIELDS"].split(), kinds))).copy()


def change_points(folder, change):
    for k, file in enumerate(sorted((folder / "scans").glob("*.pcd"))):
        header, points = read_pcd(file)
        changed = change(points, k)
        file.write_bytes(header + (points if changed is None else changed).tobytes())


def change_text(name, change):
    def apply(folder):
        file = folder / name
        file.write_text(change(file.read_text()))

    return apply


def replace(name, pattern, text):
    return change_text(name, lambda old: re.sub(pattern, text, old, flags=re.M))


def change_lasers(pattern, change):
    """Each number after `pattern` in sensor.yaml becomes change(number, index of its laser)."""

    def apply(text):
        index = iter(range(10**6))
        return re.sub(pattern + r"([-\d.e+]+)", lambda m: m[0][: -len(m[1])] + repr(change(float(m[1]), next(index))), text)

    return change_text("sensor.yaml", apply)


def scale(factor):
    def change(points, k):
        for axis in "xyz":
            points[axis] *= factor

    return lambda folder: change_points(folder, change)


def axes(x, y, z):
    def change(points, k):
        old = {a: points[a].copy() for a in "xyz"}
        for axis, name in zip("xyz", (x, y, z)):
            points[axis] = -old[name[1]] if name[0] == "-" else old[name]

    return lambda folder: change_points(folder, change)


def columns_of(folder):
    return int(re.search(r"^columns: (\d+)", (folder / "sensor.yaml").read_text(), re.M)[1])


def reorder_rows(order):
    def apply(folder):
        columns = columns_of(folder)

        def change(points, k):
            rows = points.reshape(-1, columns)
            return rows[order(len(rows))]

        change_points(folder, change)

    return apply


def roll_columns(folder):
    columns = columns_of(folder)

    def change(points, k):
        rows = points.reshape(-1, columns)
        rolled = np.roll(rows, columns // 2, axis=1)
        rolled["t"] = rows["t"]
        return rolled

    change_points(folder, change)


def times(change):
    def apply(points, k):
        points["t"] = change(points["t"].astype(float)).astype(points["t"].dtype)

    return lambda folder: change_points(folder, apply)


def poses(change):
    """change(rows): rows of t x y z qx qy qz qw."""

    def apply(folder):
        file = folder / "trajectory.txt"
        rows = np.loadtxt(file)
        file.write_text("".join(" ".join(f"{v:.9f}" for v in row) + "\n" for row in change(rows)))

    return apply


def matrices(rows):
    x, y, z, w = rows[:, 4:].T
    r = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                  [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                  [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    return np.moveaxis(r, 2, 0)


def inverted(rows):
    rows = rows.copy()
    rotation = matrices(rows)
    rows[:, 1:4] = -np.einsum("kji,kj->ki", rotation, rows[:, 1:4])
    rows[:, 4:7] *= -1
    return rows


def columns_swapped(a, b):
    def change(rows):
        rows = rows.copy()
        rows[:, [a, b]] = rows[:, [b, a]]
        return rows

    return change


def scaled(columns, factor):
    def change(rows):
        rows = rows.copy()
        rows[:, columns] *= factor
        return rows

    return change


def jump(distance):
    def change(rows):
        rows = rows.copy()
        rows[len(rows) // 2 :, 1] += distance
        return rows

    return change


def wxyz(rows):
    return rows[:, [0, 1, 2, 3, 7, 4, 5, 6]]


def body_turned(rows):
    """Poses of a body whose x points to the left of the sensor's."""
    rows = rows.copy()
    x, y, z, w = rows[:, 4:].T
    s = np.sqrt(0.5)
    rows[:, 4:] = np.stack([s * (x + y), s * (y - x), s * (z + w), s * (w - z)], 1)
    return rows


def in_world(folder):
    rows = np.loadtxt(folder / "trajectory.txt")
    rotation = matrices(rows)
    starts = np.loadtxt(folder / "times.txt")
    # The pose of each scan's start is near enough: metres and degrees are what counts.
    at = np.clip(np.searchsorted(rows[:, 0], starts), 0, len(rows) - 1)

    def change(points, k):
        p = np.stack([points[a] for a in "xyz"], 1) @ rotation[at[k]].T + rows[at[k], 1:4]
        for i, a in enumerate("xyz"):
            points[a] = p[:, i]

    change_points(folder, change)


def same_scans(folder):
    files = sorted((folder / "scans").glob("*.pcd"))
    for file in files[1:]:
        shutil.copy(files[0], file)


def two_swapped(folder):
    files = sorted((folder / "scans").glob("*.pcd"))
    a, b = files[len(files) // 3], files[2 * len(files) // 3]
    content = a.read_bytes(), b.read_bytes()
    a.write_bytes(content[1])
    b.write_bytes(content[0])


def lose_columns(folder):
    columns = columns_of(folder)

    def change(points, k):
        for axis in "xyz":
            points.reshape(-1, columns)[axis][:, columns // 2 * (k % 2) :][:, : columns // 2] = np.nan

    change_points(folder, change)


def no_points(points, k):
    for axis in "xyz":
        points[axis] = np.nan


def few_points(points, k):
    keep = np.linspace(0, len(points) - 1, 20).astype(int)
    lost = np.ones(len(points), bool)
    lost[keep] = False
    for axis in "xyz":
        points[axis][lost] = np.nan


def code_two(points, k):
    points["code"] = 2


def bits_flipped(points, k):
    rng = np.random.default_rng(k)
    raw = points.view(np.uint8)
    at = rng.integers(0, len(raw), len(raw) // 200)
    raw[at] ^= (1 << rng.integers(0, 8, len(at))).astype(np.uint8)


def half_zero(points, k):
    raw = points.view(np.uint8)
    raw[len(raw) // 2 :] = 0


def cases(other):
    random = lambda t: np.random.default_rng(1).permutation(t)
    yield "untouched", lambda folder: None
    yield "azimuth_offset_deg 40 at every laser", change_lasers("azimuth_offset_deg: ", lambda v, i: v + 40)
    yield "azimuth_offset_deg 25 and -25 in turn", change_lasers("azimuth_offset_deg: ", lambda v, i: v + (25, -25)[i % 2])
    yield "azimuth_offset_deg 5 at every laser", change_lasers("azimuth_offset_deg: ", lambda v, i: v + 5)
    yield "azimuth_offset_deg 10 at one laser", change_lasers("azimuth_offset_deg: ", lambda v, i: v + 10 * (i == 5))
    yield "direction", change_text("sensor.yaml", lambda s: re.sub(r"direction: (-?)1", lambda m: "direction: " + ("1" if m[1] else "-1"), s))
    yield "rate_hz 20", replace("sensor.yaml", r"^rate_hz: .*", "rate_hz: 20")
    yield "rate_hz 5", replace("sensor.yaml", r"^rate_hz: .*", "rate_hz: 5")
    yield "start_azimuth_deg 90", replace("sensor.yaml", r"^start_azimuth_deg: .*", "start_azimuth_deg: 90")
    yield "max_range_m 5", replace("sensor.yaml", r"^max_range_m: .*", "max_range_m: 5")
    yield "elevations twice as wide", change_lasers("elevation_deg: ", lambda v, i: 2 * v)
    yield "elevations half as wide", change_lasers("elevation_deg: ", lambda v, i: v / 2)
    yield "elevations all alike", change_lasers("elevation_deg: ", lambda v, i: 0.0)
    yield "elevations 3 degrees higher", change_lasers("elevation_deg: ", lambda v, i: v + 3)
    yield "origin_m 5 m up at every laser", replace("sensor.yaml", r"origin_m: \[.*?\]", "origin_m: [0, 0, 5]")
    yield "scans 10 ms apart", change_text("times.txt", lambda s: "".join(f"{float(t) / 10:.9f}\n" for t in s.split()))
    yield "poses of another recording", (lambda folder: shutil.copy(other / "trajectory.txt", folder)) if other else None
    yield "poses inverted", poses(inverted)
    yield "quaternions w x y z", poses(wxyz)
    yield "positions in millimetres", poses(scaled([1, 2, 3], 1000))
    yield "positions in kilometres", poses(scaled([1, 2, 3], 0.001))
    yield "positions in feet", poses(scaled([1, 2, 3], 1 / 0.3048))
    yield "y and z of the positions swapped", poses(columns_swapped(2, 3))
    yield "x and y of the positions swapped", poses(columns_swapped(1, 2))
    yield "x of the positions negated", poses(scaled([1], -1))
    yield "poses of a body turned by 90 degrees", poses(body_turned)
    yield "pose times in nanoseconds", poses(scaled([0], 1e9))
    yield "pose times in milliseconds", poses(scaled([0], 1e3))
    yield "a jump of 5 m", poses(jump(5))
    yield "a jump of 1 m", poses(jump(1))
    yield "points in millimetres", scale(1000)
    yield "points in centimetres", scale(100)
    yield "points in feet", scale(1 / 0.3048)
    yield "points in kilometres", scale(0.001)
    yield "y negated", axes("x", "-y", "z")
    yield "z negated", axes("x", "y", "-z")
    yield "x and y swapped", axes("y", "x", "z")
    yield "points turned by 90 degrees", axes("-y", "x", "z")
    yield "camera axes", axes("-y", "-z", "x")
    yield "rows in another order", reorder_rows(lambda n: np.random.default_rng(3).permutation(n))
    yield "rows upside down", reorder_rows(lambda n: np.arange(n)[::-1])
    yield "columns moved on by half a turn", roll_columns
    yield "all scans the same bytes", same_scans
    yield "points in the world frame", in_world
    yield "t in microseconds", times(lambda t: t / 1000)
    yield "t backwards", times(lambda t: t.max() - t)
    yield "t all 0", times(lambda t: 0 * t)
    yield "t random", times(random)
    yield "code 2 everywhere", lambda folder: change_points(folder, code_two)
    yield "two scans exchanged", two_swapped
    yield "half of the columns lost, the other half in the next scan", lose_columns
    yield "no points at all", lambda folder: change_points(folder, no_points)
    yield "20 points a scan", lambda folder: change_points(folder, few_points)
    yield "bits flipped", lambda folder: change_points(folder, bits_flipped)
    yield "second half of each scan 0", lambda folder: change_points(folder, half_zero)


def run(mapless, folder, output, arguments):
    done = subprocess.run([mapless, "detect", folder, "-o", output, *arguments], capture_output=True, text=True)
    told = [line for line in done.stderr.splitlines() if re.search("doubtful|lost|without motion|certain|error|wrong", line)]
    if done.returncode not in (0, 4):
        told = done.stderr.strip().splitlines()[-1:]
    return done.returncode, " | ".join(told)


def try_cases(options, work):
    base = options.recording
    if base is None:
        base = work / "base"
        subprocess.run([options.mapless, "simulate", "town1", "--sensor", "VLP-16", "--duration-s", "2.4", "--seed", "31",
                        "-o", base], check=True, capture_output=True)
    silent = 0
    for name, spoil in cases(options.other):
        if spoil is None or (options.only and not any(text in name for text in options.only)):
            continue
        folder = work / "spoilt"
        shutil.copytree(base, folder)
        spoil(folder)
        for how, arguments in (("poses", []), ("bare", ["--odometry"]), ("bare", ["--stationary"])):
            if "--stationary" in arguments:
                if name != "untouched":
                    continue
                case = "--stationary for a sensor that drives"
            elif how == "bare" and ("pose" in name or "position" in name or "jump" in name or "quat" in name):
                continue
            else:
                case = name
            code, told = run(options.mapless, folder, work / "out", arguments)
            shutil.rmtree(work / "out", ignore_errors=True)
            right = code == 0 if case == "untouched" else code != 0
            silent += not right
            print(f"{'' if right else 'SILENT '}{case} ({how}): exit {code}: {told}", flush=True)
        shutil.rmtree(folder)
    print(f"{silent} cases end wrong")
    return silent == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mapless", type=pathlib.Path)
    parser.add_argument("--recording", type=pathlib.Path)
    parser.add_argument("--other", type=pathlib.Path)
    parser.add_argument("--only", nargs="*", default=[])
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        sys.exit(0 if try_cases(options, pathlib.Path(work)) else 1)


if __name__ == "__main__":
    main()

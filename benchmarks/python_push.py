#!/usr/bin/env python3
"""Time per scan of OnlineDetector.push with NumPy arrays, beside `mapless detect --odometry` of the same recording.

The two run in turn, several times; printed is the median of the ratios: wall time, and processor time, which other work on
the machine changes less. The command reads the files and writes the labels too. Needs the Python package.

usage: benchmarks/python_push.py COMMAND RECORDING [--scans 40] [--pairs 5]     (COMMAND: build/release/apps/mapless/mapless)
"""

import argparse
import pathlib
import resource
import statistics
import subprocess
import tempfile
import time

import numpy as np

import mapless


def read_arrays(recording, scans):
    arrays = []
    for scan in mapless.open(recording):
        arrays.append((np.array(scan.points), np.array(scan.time_s), np.array(scan.ring), scan.stamp_ns))
        if len(arrays) == scans:
            break
    return arrays


def push(arrays, sensor):
    """Wall and processor time per scan [ms]."""
    detector = mapless.OnlineDetector(sensor=sensor)
    wall_s, processor_s = time.perf_counter(), time.process_time()
    for points, times, rings, stamp_ns in arrays:
        detector.push(points, time=times, ring=rings, stamp_ns=stamp_ns)
    detector.flush()
    count = len(arrays)
    return (time.perf_counter() - wall_s) * 1e3 / count, (time.process_time() - processor_s) * 1e3 / count


def processor_of_children_s():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def detect(command, recording, count):
    with tempfile.TemporaryDirectory() as folder:
        words = [command, "detect", recording, "-o", f"{folder}/result", "--count", str(count), "--odometry"]
        wall_s, processor_s = time.perf_counter(), processor_of_children_s()
        subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
        wall_s = time.perf_counter() - wall_s
        return wall_s * 1e3 / count, (processor_of_children_s() - processor_s) * 1e3 / count


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("recording", type=pathlib.Path, help="in the native format")
    parser.add_argument("--scans", type=int, default=40)
    parser.add_argument("--pairs", type=int, default=5)
    given = parser.parse_args()
    arrays = read_arrays(given.recording, given.scans)
    ratios = []
    for _ in range(given.pairs):
        own, other = push(arrays, given.recording / "sensor.yaml"), detect(given.command, given.recording, len(arrays))
        ratios.append((own[0] / other[0], own[1] / other[1]))
        print(f"push {own[0]:.1f} ms, processor {own[1]:.1f}; command {other[0]:.1f}, {other[1]:.1f}", flush=True)
    print("push / command: {:.2f} in wall time, {:.2f} in processor time".format(*map(statistics.median, zip(*ratios))))


if __name__ == "__main__":
    main()

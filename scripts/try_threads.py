#!/usr/bin/env python3
"""Labels random recordings (`mapless simulate random`) with 1, 2, 8 and 64 threads, and compares every byte of the
results but summary.json, which holds times. Along the recording's poses and along own odometry in turn.

usage: try_threads.py MAPLESS [--recordings 100] [--first-seed 1] [--threads 1 2 8 64] [--sensor VLP-16]
                      [--duration-s 1.5] [--work FOLDER]
"""

import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile


def files(result):
    return {str(file.relative_to(result)): file.read_bytes() for file in result.rglob("*")
            if file.is_file() and file.name not in ("summary.json", ".lock")}


def difference(options, seed, work):
    """What differs between the numbers of threads; empty where nothing does."""
    recording = work / "recording"
    subprocess.run([options.mapless, "simulate", "random", "--seed", str(seed), "--sensor", options.sensor,
                    "--duration-s", str(options.duration_s), "-o", recording], check=True, capture_output=True)
    motion = ["--odometry"] if seed % 2 else []
    first = None
    for threads in options.threads:
        out = work / f"out{threads}"
        done = subprocess.run([options.mapless, "detect", recording, "-o", out, "--threads", str(threads), *motion],
                              capture_output=True, text=True)
        if done.returncode not in (0, 4):
            return f"{threads} threads: exit code {done.returncode}: {done.stderr.splitlines()[-1:]}"
        found = (done.returncode, files(out))
        first = first or found
        if found != first:
            names = [name for name in found[1].keys() | first[1].keys() if found[1].get(name) != first[1].get(name)]
            return f"{threads} threads: exit code {found[0]} for {first[0]}, files that differ: {sorted(names)[:5]}"
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mapless", type=pathlib.Path)
    parser.add_argument("--recordings", type=int, default=100)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2, 8, 64])
    parser.add_argument("--sensor", default="VLP-16")
    parser.add_argument("--duration-s", type=float, default=1.5)
    parser.add_argument("--work", type=pathlib.Path, help="folder for temporary files")
    options = parser.parse_args()
    failures = 0
    for seed in range(options.first_seed, options.first_seed + options.recordings):
        work = pathlib.Path(tempfile.mkdtemp(dir=options.work))
        try:
            if what := difference(options, seed, work):
                failures += 1
                print(f"FAILED: seed {seed}: {what}", flush=True)
        finally:
            shutil.rmtree(work)
    print(f"{options.recordings} recordings with {', '.join(map(str, options.threads))} threads: {failures} differ")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()

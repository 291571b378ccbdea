#!/usr/bin/env python3
"""Checks that each header compiles by itself: the unity builds, which read many into one unit, hide a missing include.

usage: check_headers.py [--compiler COMPILER] [--include FOLDER ...] [--jobs N] [FOLDER ...]

FOLDER: where the headers are, from the root (default: include, src and apps/mapless). --include adds folders to those
of the project, for generated headers.
"""

import argparse
import concurrent.futures
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ["include", "src", "apps/mapless"]
# System headers: their warnings are not ours.
SYSTEM = ["/usr/include/eigen3"]


def fault(header, compiler, include):
    """What the compiler says of a unit that holds the header alone; empty where it has nothing to say."""
    command = [compiler, "-std=c++20", "-fsyntax-only", "-x", "c++", "-"]
    command += [f"-I{folder}" for folder in include] + [f"-isystem{folder}" for folder in SYSTEM]
    unit = f'#include "{header}"\n#include "{header}"\n'
    done = subprocess.run(command, input=unit, capture_output=True, text=True, check=False)
    return done.stderr if done.returncode != 0 else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--compiler", default=os.environ.get("CXX", "c++"))
    parser.add_argument("--include", nargs="*", default=[], metavar="FOLDER")
    parser.add_argument("--jobs", type=int, default=int(os.environ.get("JOBS", os.cpu_count())))
    parser.add_argument("folders", nargs="*", default=FOLDERS, metavar="FOLDER")
    options = parser.parse_args()

    headers = sorted(file for folder in options.folders for file in (ROOT / folder).rglob("*.hpp"))
    include = [ROOT / folder for folder in FOLDERS] + options.include
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        faults = list(filter(None, pool.map(lambda header: fault(header, options.compiler, include), headers)))
    print("\n".join(faults) if faults else f"each of {len(headers)} headers compiles by itself")
    return 1 if faults or not headers else 0


if __name__ == "__main__":
    sys.exit(main())

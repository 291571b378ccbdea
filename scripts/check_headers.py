#!/usr/bin/env python3
"""Checks that headers compile by themselves: the unity builds, which read many into one unit, hide a missing include.

The public headers each by itself alone, but for Eigen's, which where a header includes it is precompiled; the private
ones after the headers of other libraries that take longest to read, precompiled once, which takes a quarter of the time
and hides no missing include of ours. A private header with
a source of its own is checked only with --all: the source reads it first, so a build without unity tells as well.

usage: check_headers.py [--all] [--compiler COMPILER] [--generated FOLDER] [--jobs N]
"""

import argparse
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PUBLIC = ROOT / "include"
PRIVATE = [ROOT / "src", ROOT / "apps" / "mapless"]
# Of builds with Cyclone DDS.
LIVE = ROOT / "apps" / "mapless" / "live"
# System headers: their warnings are not ours.
EIGEN = "/usr/include/eigen3"
CORE = "#include <Eigen/Core>\n"
SLOW = """#include <Eigen/Dense>
#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>
"""


def compile_unit(command, unit):
    """What the compiler says of a unit; empty where it takes it."""
    done = subprocess.run(command, input=unit, capture_output=True, text=True, check=False)
    return done.stderr if done.returncode != 0 else ""


def precompile(command, text, folder):
    """Options that read the headers that `text` includes from a file made in `folder`."""
    folder.mkdir()
    (folder / "slow.hpp").write_text(text, encoding="utf-8")
    subprocess.run([*command, "-x", "c++-header", folder / "slow.hpp", "-o", folder / "slow.hpp.gch"], check=True)
    return ["-include", folder / "slow.hpp"] if "clang" not in command[0] else ["-include-pch", folder / "slow.hpp.gch"]


def reads_eigen(header):
    """Whether a public header includes Eigen/Core, itself or by another: then that is there without us, too."""
    included = re.findall(r"^#include <(Eigen/Core|mapless/.+)>", header.read_text(encoding="utf-8"), re.MULTILINE)
    return "Eigen/Core" in included or any(reads_eigen(PUBLIC / name) for name in included)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true", help="also private headers with a source of their own")
    parser.add_argument("--compiler", default=os.environ.get("CXX", "c++"))
    parser.add_argument("--generated", metavar="FOLDER", nargs="*", default=[], help="where the build puts generated headers")
    parser.add_argument("--jobs", type=int, default=int(os.environ.get("JOBS", os.cpu_count())))
    options = parser.parse_args()

    public = sorted(PUBLIC.rglob("*.hpp"))
    private = sorted(file for folder in PRIVATE for file in folder.rglob("*.hpp"))
    if not options.all:
        private = [file for file in private if not file.with_suffix(".cpp").exists()]
    if not any((pathlib.Path(folder) / "ros2_messages.h").exists() for folder in options.generated):
        private = [file for file in private if LIVE not in file.parents]
        print(f"left out, because this build has no DDS: {LIVE.relative_to(ROOT)}")
    command = [options.compiler, "-std=c++20", f"-isystem{EIGEN}", f"-I{PUBLIC}"]
    within = [f"-I{folder}" for folder in PRIVATE]
    within += [f"-isystem{folder}" for folder in options.generated]
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        eigen = precompile(command, CORE, pathlib.Path(folder) / "core")
        slow = precompile(command, SLOW, pathlib.Path(folder) / "all")
        check = ["-fsyntax-only", "-x", "c++", "-"]
        units = [([*command, *(eigen if reads_eigen(header) else []), *check], header) for header in public]
        units += [([*command, *slow, *within, *check], header) for header in private]
        # Twice: the guard is there.
        said = pool.map(lambda unit: compile_unit(unit[0], f'#include "{unit[1]}"\n' * 2), units)
        faults = list(filter(None, said))
    print("\n".join(faults) if faults else f"each of {len(public) + len(private)} headers compiles by itself")
    return 1 if faults or not public else 0


if __name__ == "__main__":
    sys.exit(main())

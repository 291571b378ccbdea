#!/usr/bin/env python3
"""Breaks the published method on purpose, one small mutant after the other, and says whether its tests notice.

Copies the tree to a scratch folder, builds the tests of room detection there and runs them unbroken; then applies each
mutant, builds and runs the tests of its step, and puts the source back. A mutant is killed if a test fails or hangs,
and survives if all pass. Exit code 1 if one survives, 2 if a mutant cannot be tried.

usage: scripts/try_mutants.py [--scratch FOLDER] [NAME ...]
       scripts/try_mutants.py --check     only whether each mutant still fits the source (seconds; a lint of ctest)
       scripts/try_mutants.py --list
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[1]
PUBLISHED = "src/detection/published/"
TIMEOUT_S = 300  # of the tests of one step, which take under 20 s


class Mutant(NamedTuple):
    name: str
    file: str
    search: str  # occurs exactly once in the file
    replacement: str
    tests: str  # filter of detection_tests


PIPELINE, RAYS = "PublishedPipeline.*", "*RaySearch*:*FreespaceAgreement*"
MUTANTS = [
    Mutant("forward-skipped", PUBLISHED + "published_pipeline.cpp",
           "points_where(out.trace, was_outside)",
           "points_where(out.trace, [](const StageTrace& t) { return was_outside(t) && false; })", PIPELINE),
    Mutant("forward-of-inside-points", PUBLISHED + "published_pipeline.cpp",
           "return t.past == FreespaceVerdict::outside;",
           "return t.past == FreespaceVerdict::outside || t.past == FreespaceVerdict::inside;", PIPELINE),
    Mutant("forward-border-is-dynamic", PUBLISHED + "stage_record.hpp",
           "static_cast<char>(dynamic_after(t, stage))",
           "static_cast<char>(dynamic_after(t, stage) || (stage == Stage::future && t.future == FreespaceVerdict::border))",
           PIPELINE),
    Mutant("forward-scan-before-query", PUBLISHED + "published_pipeline.cpp",
           "number < newest ? &scan_number(newest)", "number < newest ? &scan_number(number < 1 ? 0 : number - 1)",
           PIPELINE),
    Mutant("plane-of-reference-point", PUBLISHED + "pointcloud_comparison.cpp",
           "std::abs(normal.dot(nearest_point() - q))",
           "std::abs(reference_.normals_0[static_cast<std::size_t>(nearest_.index)].cast<double>().dot("
           "nearest_point() - q))",
           "*PointcloudComparison*:*ComparisonAgreement*"),
    Mutant("seam-ignored", PUBLISHED + "ray_search.cpp",
           "const double seam = std::min(max_offset_columns_ + wandered + 2, columns / 2.0);",
           "const double seam = 0 * wandered;", RAYS),
    Mutant("origin-of-neighbouring-laser", PUBLISHED + "ray_search.cpp",
           "laser_T_lh_.push_back(laser.T_lh());",
           "laser_T_lh_.push_back(SE3(laser.T_lh().rotation(), -(laser.T_lh().rotation() * "
           "model.lasers[laser_T_lh_.empty() ? 1 : laser_T_lh_.size() - 1].origin_h_m)));", RAYS),
    Mutant("filter-off-by-one-row", PUBLISHED + "box_filter.cpp",
           "image.at(row - kWindowRows / 2 + r, column + c)", "image.at(row + 1 - kWindowRows / 2 + r, column + c)",
           "BoxFilter.*"),
    Mutant("convex-test-reversed", PUBLISHED + "region_growth.cpp",
           "return n1.dot(d) <= tolerance && -n2.dot(d) <= tolerance;",
           "return n1.dot(d) >= -tolerance && -n2.dot(d) >= -tolerance;", "RegionGrowth.*"),
    Mutant("growth-without-cap", PUBLISHED + "region_growth.cpp",
           "seed_pool.any_within(point(i), parameters_.max_growth_m)", "seed_pool.any_within(point(i), 1e6)",
           "RegionGrowth.*"),
]


class CannotTry(Exception):
    pass


def mutated(root, mutant):
    """The text of the mutant's file with the mutant in it."""
    file = root / mutant.file
    if not file.is_file():
        raise CannotTry(f"{mutant.name}: {mutant.file} is not there; name the file the code is in now")
    text = file.read_text(encoding="utf-8")
    if text.count(mutant.search) != 1:
        raise CannotTry(f"{mutant.name}: {mutant.file} has {text.count(mutant.search)} times \"{mutant.search}\", where "
                        "once is needed; follow the source in scripts/try_mutants.py")
    return text.replace(mutant.search, mutant.replacement)


def unfit(root):
    """Complaints about mutants that no longer fit the source."""
    for mutant in MUTANTS:
        try:
            mutated(root, mutant)
        except CannotTry as problem:
            yield str(problem)


def copy_tree(scratch):
    """Every file that git knows or would add; those that are the same keep their times, for quick rebuilds."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                            check=True, capture_output=True).stdout.decode().split("\0")
    for name in filter(None, listed):
        source, target = ROOT / name, scratch / name
        if not source.is_file() or (target.is_file() and target.read_bytes() == source.read_bytes()):
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)


def build(scratch, log):
    command = ["cmake", "--build", scratch / "build/release", "-j", str(os.cpu_count()), "--target", "detection_tests"]
    return subprocess.run(command, stdout=log, stderr=log).returncode == 0


def tests_pass(scratch, tests, log):
    command = [scratch / "build/release/tests/detection_tests", f"--gtest_filter={tests}", "--gtest_brief=1"]
    try:
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=log, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return False
    log.write(result.stdout)
    if b" 0 tests from" in result.stdout:
        raise CannotTry(f"the filter {tests} names no test; follow the tests in scripts/try_mutants.py")
    return result.returncode == 0


def killed(scratch, mutant, log):
    file = scratch / mutant.file
    original = file.read_bytes()
    broken = mutated(scratch, mutant)
    try:
        file.write_text(broken, encoding="utf-8")
        if not build(scratch, log):
            raise CannotTry(f"{mutant.name}: does not compile; see {log.name}")
        return not tests_pass(scratch, mutant.tests, log)
    finally:
        file.write_bytes(original)


def prepare(scratch, mutants, log):
    copy_tree(scratch)
    configure = ["cmake", "--preset", "release", "-DMAPLESS_BUILD_TESTS=ON"]
    if subprocess.run(configure, cwd=scratch, stdout=log, stderr=log).returncode != 0 or not build(scratch, log):
        raise CannotTry(f"the unbroken tests do not build; see {log.name}")
    for tests in sorted({mutant.tests for mutant in mutants}):
        if not tests_pass(scratch, tests, log):
            raise CannotTry(f"{tests} fails before anything is broken; see {log.name}")


def try_all(scratch, mutants):
    scratch.mkdir(parents=True, exist_ok=True)
    survivors = 0
    with open(scratch / "mutants.log", "wb") as log:
        prepare(scratch, mutants, log)
        for mutant in mutants:
            dead = killed(scratch, mutant, log)
            survivors += not dead
            print(f"{'killed  ' if dead else 'SURVIVED'} {mutant.name}", flush=True)
    print(f"{len(mutants) - survivors} of {len(mutants)} killed")
    return survivors


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="mutants to try; default: all")
    parser.add_argument("--scratch", type=pathlib.Path, default=ROOT / "build/mutants", help="folder of the copy")
    parser.add_argument("--check", action="store_true", help="only whether each mutant still fits the source")
    parser.add_argument("--list", action="store_true", help="names and files of the mutants")
    options = parser.parse_args()
    unknown = set(options.names) - {mutant.name for mutant in MUTANTS}
    if unknown:
        parser.error(f"no such mutant: {', '.join(sorted(unknown))}; --list names them")
    if options.list:
        print("\n".join(f"{mutant.name:30} {mutant.file}" for mutant in MUTANTS))
        return 0
    problems = list(unfit(ROOT))
    for problem in problems:
        print(f"scripts/try_mutants.py: {problem}", file=sys.stderr)
    if problems or options.check:
        return 2 if problems else 0
    try:
        chosen = [mutant for mutant in MUTANTS if not options.names or mutant.name in options.names]
        return 1 if try_all(options.scratch.resolve(), chosen) else 0
    except CannotTry as problem:
        print(f"scripts/try_mutants.py: {problem}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())

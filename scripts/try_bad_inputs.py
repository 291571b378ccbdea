#!/usr/bin/env python3
"""Gives every verb of `mapless` damaged files, wrong options, folders in use and full disks, and looks how it ends:

files    each file of a recording (native, kitti, mdlidar, pcd) and of a result is empty, cut, of random bytes, of
         zeros, of huge numbers, a folder, a loop of links, or gone; read by the verbs that read it
outputs  outputs that are files for folders, folders for files, within files, on inputs, in folders of others
options  values no verb can use
twice    two runs at once into one folder, of the same verb and of two
full     a file system of a few KiB (tmpfs; needs root, else left out), for every verb that writes
python   the same damage for what the Python package reads: bags, NumPy archives, PLY, LAS and lists of mapless batch
         (--python: an interpreter that imports mapless, rosbags and NumPy; else left out)

A case fails where a program is ended by a signal or takes more than a minute; where it ends with 0 though it must
not; where the code is not one of the table of docs/reliability.md; where an error is not one line that begins with
"mapless: error:"; or where a failed run leaves a file that was not there and is not a finished part of a result.

usage: try_bad_inputs.py MAPLESS [--only TEXT ...] [--python PYTHON] [--work FOLDER]
"""

import argparse
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

WRONG_USE, BAD_DATA, DOUBTFUL, FULL = 2, 3, 4, 75
REFUSED = {1, WRONG_USE, BAD_DATA}
LONGEST_S = 240


def damages(file):
    """Name of a damage and what does it."""
    content = file.read_bytes()
    rng = random.Random(len(content))

    def link(path):
        path.unlink()
        path.symlink_to(path)

    def folder(path):
        path.unlink()
        path.mkdir()

    yield "empty", lambda path: path.write_bytes(b"")
    yield "cut in the middle", lambda path: path.write_bytes(content[: len(content) // 2])
    yield "random bytes", lambda path: path.write_bytes(rng.randbytes(max(1, len(content))))
    yield "zeros", lambda path: path.write_bytes(bytes(len(content)))
    yield "huge numbers", lambda path: path.write_bytes(content.replace(b"1", b"9e307"))
    yield "not numbers", lambda path: path.write_bytes(content.replace(b"0.", b"nan."))
    yield "a folder", folder
    yield "a loop of links", link
    yield "gone", lambda path: path.unlink()


class Battery:
    def __init__(self, options, work):
        self.mapless, self.only, self.work = options.mapless, options.only, work
        self.tried, self.failed = 0, 0

    def command(self, *arguments, program=None):
        begin = time.monotonic()
        try:
            done = subprocess.run([*(program or [self.mapless]), *arguments], capture_output=True, timeout=LONGEST_S,
                                  stdin=subprocess.DEVNULL)
            return done.returncode, done.stderr.decode(errors="replace"), time.monotonic() - begin
        except subprocess.TimeoutExpired as error:
            return None, (error.stderr or b"").decode(errors="replace"), LONGEST_S

    def wants(self, name):
        return not self.only or any(text in name for text in self.only)

    def judge(self, name, code, err, allowed, left=(), counted=False):
        """`left`: files that must not be there. `counted`: the last line counts failures said before it."""
        self.tried += 1
        errors = [line for line in err.splitlines() if line.startswith("mapless: error:")]
        problems = []
        if code is None:
            problems.append(f"not ended after {LONGEST_S} s")
        elif code < 0 or code > 128:
            problems.append(f"ended by signal {abs(code) % 128}")
        elif code not in allowed:
            problems.append(f"exit code {code}, not of {sorted(allowed)}")
        if "Traceback (most recent call last)" in err:
            problems.append("ended by an exception")
        if code in (1, WRONG_USE, BAD_DATA, FULL) and not counted and (len(errors) != 1 or not err.rstrip().endswith(errors[0].rstrip())):
            problems.append("the error is not the last line alone")
        if any(len(line) > 2000 for line in errors):
            problems.append("an error of more than 2000 characters")
        problems += [f"leaves {file}" for file in left]
        self.failed += bool(problems)
        if problems:
            print(f"FAILED {name}: {'; '.join(problems)}: {err.strip().splitlines()[-1:][:1]}"[:500], flush=True)

    def case(self, name, arguments, allowed, outputs=(), program=None):
        """`outputs` must not be there after a failure."""
        if not self.wants(name):
            return
        code, err, _ = self.command(*arguments, program=program)
        failed = code not in (0, DOUBTFUL)
        self.judge(name, code, err, allowed, [o for o in outputs if failed and os.path.lexists(o)])
        for output in outputs:
            remove(output)


def remove(path):
    path = pathlib.Path(path)
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    elif os.path.lexists(path):
        path.unlink()


class Bases:
    """Right recordings and results, made once."""

    def __init__(self, battery):
        self.work, run = battery.work / "right", battery.command
        self.work.mkdir()
        self.tests = pathlib.Path(__file__).resolve().parent.parent / "python" / "tests"
        for form, sensor in (("native", "VLP-16"), ("kitti", "HDL-64E-S2"), ("mdlidar", "VLP-16")):
            self.make(run, "simulate", "town1", "--sensor", sensor, "--duration-s", "1.2" if form == "native" else ".4",
                      "--seed", "31", "--format", form, "-o", self.work / form)
        pcd = self.work / "pcd"
        shutil.copytree(self.work / "native" / "scans", pcd)
        shutil.copy(self.work / "native" / "times.txt", pcd)
        self.make(run, "detect", self.work / "native", "-o", self.work / "result", "--probability")
        self.make(run, "odometry", self.work / "native", "-o", self.work / "motion")

    def make(self, run, *arguments):
        code, err, _ = run(*arguments)
        if code not in (0, DOUBTFUL):
            sys.exit(f"{arguments}: {code}: {err}")


def try_files(battery, bases):
    work = battery.work / "spoilt"
    readers = {"info": lambda r: ["info", r], "detect": lambda r: ["detect", r, "-o", work / "out"],
               "odometry": lambda r: ["odometry", r, "-o", work / "out"]}
    for form in ("native", "kitti", "mdlidar", "pcd"):
        root = bases.work / form
        files = [f.relative_to(root) for f in sorted(root.rglob("*")) if f.is_file() and "000003" not in f.name[:6]]
        kept, seen = [], set()
        for file in files:  # one scan of each folder, of the middle ones
            if (file.parent, file.suffix) not in seen or not any(c.isdigit() for c in file.stem):
                kept.append(file)
            seen.add((file.parent, file.suffix))
        for file in kept:
            for damage, spoil in damages(root / file):
                for verb, arguments in readers.items():
                    name = f"files: {form} {file}: {damage}: {verb}"
                    if not battery.wants(name):
                        continue
                    remove(work)
                    shutil.copytree(root, work / "recording")
                    spoil(work / "recording" / file)
                    # Labels and tables of the truth are not read by these verbs, and poses not by all.
                    # A scan is not read by info where others tell enough.
                    battery.case(name, arguments(work / "recording"), {0, DOUBTFUL} | REFUSED)


def try_results(battery, bases):
    work, native = battery.work / "spoilt", bases.work / "native"
    for of, verbs in (("result", ("evaluate", "view", "render", "explain", "export", "detect")), ("motion", ("evaluate", "odometry"))):
        root = bases.work / of
        files = [f for f in sorted(root.rglob("*")) if f.is_file() and (not f.stem.isdigit() or f.stem == "000005")]
        for file in files:
            for damage, spoil in damages(file):
                for verb in verbs:
                    name = f"files: {of} {file.relative_to(root)}: {damage}: {verb}"
                    if not battery.wants(name):
                        continue
                    remove(work)
                    shutil.copytree(root, work / "out")
                    spoil(work / "out" / file.relative_to(root))
                    out, page = work / "out", work / "page"
                    arguments = {"evaluate": ["evaluate", native, out], "view": ["view", native, out, "-o", page],
                                 "render": ["render", native, out, "--scan", "5", "-o", page],
                                 "explain": ["explain", native, out, "--scan", "5", "--point", "3000"],
                                 "export": ["export", native, out, "--what", "labelled", "-o", page],
                                 "detect": ["detect", native, "-o", out, "--resume", "--probability"],
                                 "odometry": ["odometry", native, "-o", out, "--resume"]}[verb]
                    battery.case(name, arguments, {0, DOUBTFUL} | REFUSED, [page])


def try_outputs(battery, bases):
    native, result, work = bases.work / "native", bases.work / "result", battery.work / "spoilt"
    remove(work)
    work.mkdir()
    (work / "file").write_text("mine")
    (work / "others").mkdir()
    (work / "others" / "notes").write_text("mine")
    writers = {"detect": ["detect", native], "odometry": ["odometry", native], "export": ["export", native, result, "--what", "labelled"],
               "view": ["view", native, result], "render": ["render", native, result, "--scan", "3"],
               "simulate": ["simulate", "town1", "--sensor", "VLP-16", "--duration-s", ".2"],
               "benchmark": ["benchmark", "--scenes", "crossing", "--sensors", "VLP-16", "--duration-s", ".6"]}
    folders = ("detect", "odometry", "simulate", "export", "benchmark")
    for verb, arguments in writers.items():
        bad = {"within a file": work / "file" / "out", "with a line break": work / "a\nb", "empty": "",
               "a name of 5,000 characters": work / ("n" * 5000), "a device": "/dev/null/out"}
        if verb in folders:
            bad |= {"a file": work / "file", "a folder of others": work / "others", "the recording": native}
        else:
            bad |= {"a folder": work / "others", "a scan of the recording": native / "scans" / "000002.pcd"}
        for what, output in bad.items():
            for more in ([], ["--overwrite"]) if verb in ("detect", "odometry") else ([],):
                battery.case(f"outputs: {verb} {' '.join(more)} into {what}", [*arguments, "-o", output, *more], REFUSED)
    if (work / "file").read_text() != "mine" or [f.name for f in (work / "others").iterdir()] != ["notes"]:
        battery.judge("outputs: what was there", 0, "", set(), ["a changed file of others"])


def try_options(battery, bases):
    native, out = bases.work / "native", battery.work / "out"
    values = {"--threads": ["0", "-1", "1e9", "x", "nan"], "--first": ["-1", "99999999999999999999", "12", "x"],
              "--count": ["0", "13", "-3"], "--sensor": ["", "none", "/", "VLP-17"], "--profile": ["none"],
              "--set": ["x", "=", "no.such=1", "min_speed_mps=nan"], "--config": ["/none", "/", "/dev/zero"],
              "--trajectory": ["/none", "/", "/dev/zero", "/dev/null"], "--format": ["none", "kitti"]}
    for option, of in values.items():
        for value in of:
            battery.case(f"options: detect {option} {value}", ["detect", native, "-o", out, option, value], REFUSED, [out])
    for verb, option, value in (("render", "--scan", "99"), ("explain", "--point", "999999999"), ("view", "--scans", "9:2"),
                                ("export", "--what", "none"), ("info", "--format", "mdlidar")):
        more = ["-o", out] if verb in ("render", "view", "export") else []
        result = [] if verb == "info" else [bases.work / "result"]
        scan = ["--scan", "3"] if verb == "explain" else []
        battery.case(f"options: {verb} {option} {value}", [verb, native, *result, *scan, *more, option, value], REFUSED, [out])


def try_twice(battery, bases):
    native, out = bases.work / "native", battery.work / "twice"
    pairs = [(["detect", native], ["detect", native]), (["odometry", native], ["odometry", native]),
             (["detect", native], ["odometry", native]), (["odometry", native], ["detect", native])]
    for first, second in pairs:
        name = f"twice: {first[0]} and {second[0]}"
        if not battery.wants(name):
            continue
        one = subprocess.Popen([battery.mapless, *first, "-o", out], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        for line in one.stderr:
            if " of 12 scans" in line:
                break
        one.send_signal(19)  # stopped: it holds the folder
        code, err, _ = battery.command(*second, "-o", out, "--overwrite")
        one.send_signal(18)
        one.communicate()
        battery.judge(name, code, err, {FULL})
        battery.judge(name + ": the first", one.returncode, "", {0, DOUBTFUL})
        remove(out)
    simulate = ["simulate", "town1", "--sensor", "VLP-16", "--duration-s", ".6", "-o", out]
    if battery.wants("twice: simulate"):
        both = [subprocess.Popen([battery.mapless, *simulate, "--seed", str(s)], stdout=subprocess.DEVNULL,
                                 stderr=subprocess.DEVNULL) for s in (1, 2)]
        codes = sorted(p.wait() for p in both)
        whole = battery.command("detect", out, "-o", battery.work / "out")[0]
        battery.judge(f"twice: simulate: codes {codes}, and detect {whole}", 0 if codes != [0, 0] and whole in (0, DOUBTFUL) else 9, "", {0})
        remove(out), remove(battery.work / "out")


def try_full(battery, bases):
    native, result, disk = bases.work / "native", bases.work / "result", battery.work / "disk"
    if os.geteuid() != 0:
        print("full: left out, needs root")
        return
    disk.mkdir()
    out = disk / "out"
    writers = {"detect": ["detect", native, "--probability"], "odometry": ["odometry", native],
               "export": ["export", native, result, "--what", "labelled"], "export map": ["export", native, result, "--what", "map"],
               "view": ["view", native, result], "render": ["render", native, result, "--scan", "3"],
               "simulate": ["simulate", "town1", "--sensor", "VLP-16", "--duration-s", ".4"],
               "simulate kitti": ["simulate", "town1", "--sensor", "HDL-64E-S2", "--duration-s", ".4", "--format", "kitti"],
               "simulate mdlidar": ["simulate", "town1", "--sensor", "VLP-16", "--duration-s", ".4", "--format", "mdlidar"],
               "benchmark": ["benchmark", "--scenes", "crossing", "--sensors", "VLP-16", "--duration-s", ".6"],
               "evaluate --json": ["evaluate", native, result, "--json"]}
    for verb, arguments in writers.items():
        for size in ("4k", "16k", "64k", "256k"):
            name = f"full: {verb} on {size}"
            if not battery.wants(name):
                continue
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", disk], check=True)
            try:
                code, err, _ = battery.command(*arguments, *([] if verb == "evaluate --json" else ["-o"]), out)
                partial = [str(f) for f in disk.rglob("*") if ".partial-" in f.name or f.name == ".lock"]
                small = out.is_file() and code not in (0, DOUBTFUL)
                battery.judge(name, code, err, {0, DOUBTFUL, FULL}, partial + ([str(out)] if small else []))
            finally:
                subprocess.run(["umount", disk], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mapless", type=pathlib.Path)
    parser.add_argument("--only", nargs="*", default=[], help="cases whose names have one of these texts in them")
    parser.add_argument("--python", type=pathlib.Path)
    parser.add_argument("--work", type=pathlib.Path, help="folder for temporary files")
    options = parser.parse_args()
    options.mapless = options.mapless.resolve()
    with tempfile.TemporaryDirectory(dir=options.work) as work:
        battery = Battery(options, pathlib.Path(work))
        bases = Bases(battery)
        for part in (try_files, try_results, try_outputs, try_options, try_twice, try_full):
            part(battery, bases)
        if options.python:
            from try_bad_python_inputs import try_python  # beside this file

            try_python(battery, bases, options.python)
    print(f"{battery.tried} cases, {battery.failed} end wrong")
    sys.exit(1 if battery.failed else 0)


if __name__ == "__main__":
    main()

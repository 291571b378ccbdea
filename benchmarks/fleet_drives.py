#!/usr/bin/env python3
"""Labels many small drives with every engine of `mapless batch` while workers are killed, and compares the bytes.

Prints, for each engine: drives per second, calls of detect (more than the drives only for those that were killed), and
whether each label, object and pose is that of a plain call of `mapless detect`. Needs the Python package; Ray and
Slurm (slurm-wlm, root) are left out, saying so, where they are not installed.

usage: benchmarks/fleet_drives.py WORK_FOLDER [--drives 200] [--kills 20] [--seed 1] [--engines local killed ray slurm]
"""

import argparse
import contextlib
import hashlib
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "python" / "tests" / "batch"))
from slurm_daemons import reason_not_to_start, slurm_node  # noqa: E402

SENSOR = "name: small\nrate_hz: 10\ndirection: -1\ncolumns: 360\nstart_azimuth_deg: 180\nmin_range_m: 1\nmax_range_m: 80\nlasers:\n"
LASERS = "".join(f"  - {{elevation_deg: {e}, azimuth_offset_deg: 0, origin_m: [0, 0, 0]}}\n" for e in range(-15, 16, 2))
ENGINES = ("local", "killed", "ray", "slurm")
AT_ONCE = 2  # drives, with every engine
KILL_PERIOD_S = 0.7  # between kills: about four drives
INDEX_PROCESS = re.compile(rb"mapless\0batch\0run\0.*--index\0")


def mapless(*arguments, **options):
    command = [sys.executable, "-m", "mapless", *map(str, arguments)]
    return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False, **options).returncode


def simulate(work, count):
    """Drives of 20 scans, of seeds 1 to `count`."""
    sensor = work / "small.yaml"
    sensor.write_text(SENSOR + LASERS)
    for seed in range(1, count + 1):
        drive = work / "drives" / f"d{seed:03d}"
        if not drive.exists():
            flags = ["--sensor", sensor, "--duration-s", 2, "--seed", seed]
            if mapless("simulate", "crossing", "-o", drive, *flags) != 0:
                sys.exit(f"{drive}: cannot be simulated")


def digest(results, drives):
    """Of every file of the results but those that hold times."""
    total = hashlib.sha256()
    for drive in drives:
        for file in sorted(p for p in (results / drive).rglob("*") if p.is_file()):
            if file.name not in ("summary.json", "_SUCCESS.json", ".lock"):
                total.update(f"{file.relative_to(results)}\0".encode() + file.read_bytes())
    return total.hexdigest()


def tasks_below(work):
    """Processes that label one line of the plan, of this benchmark alone."""
    for entry in pathlib.Path("/proc").iterdir():
        with contextlib.suppress(OSError):
            line = (entry / "cmdline").read_bytes() if entry.name.isdigit() else b""
            if INDEX_PROCESS.search(line) and str(work).encode() in line and b"/sh\0" not in line[:16]:
                yield int(entry.name)


class Killer(threading.Thread):
    """Kills tasks at random until `wanted` are killed."""

    def __init__(self, work, wanted, seed):
        super().__init__(daemon=True)
        self.work, self.wanted, self.killed = work, wanted, 0
        self.random, self.stopped = random.Random(seed), threading.Event()

    def run(self):
        while self.killed < self.wanted and not self.stopped.wait(self.random.uniform(0.5, 1.5) * KILL_PERIOD_S):
            running = list(tasks_below(self.work))
            if running:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(self.random.choice(running), signal.SIGKILL)
                    self.killed += 1


def command_that_counts(work):
    """For --command: appends the drive to a file before detect starts."""
    script = work / "count.sh"
    script.write_text(f'#!/bin/sh\necho "$2" >> {work}/calls\nexec {sys.executable} -m mapless "$@"\n')
    script.chmod(0o755)
    return str(script)


def with_slurm(work, plan, results, drives):
    """Slurm calls `mapless` by PATH. The array is submitted again while a drive is not done, as a user would."""
    folder = work / "bin"
    folder.mkdir(exist_ok=True)
    (folder / "mapless").write_text(f'#!/bin/sh\nexec {sys.executable} -m mapless "$@" --command {work}/count.sh\n')
    (folder / "mapless").chmod(0o755)
    os.environ["PATH"] = f"{folder}:{os.environ['PATH']}"
    shutil.rmtree(work / "slurm", ignore_errors=True)
    with slurm_node(work / "slurm") as run:
        flags = ["--array=0-19", "--mem=0", "--output=/dev/null", ROOT / "examples/fleet/slurm.sh"]
        while not all((results / drive / "_SUCCESS.json").exists() for drive in drives):
            job = run("sbatch", *flags, plan, results).stdout.split()[-1]
            while run("squeue", "--noheader", "--jobs", job).stdout.strip():
                time.sleep(0.2)


def processor_s():
    """Of all processes that have ended below this one: other work on the machine does not count."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def measure(name, work, drives, expected, kills, seed, label):
    results, calls = work / f"results_{name}", work / "calls"
    shutil.rmtree(results, ignore_errors=True)
    calls.write_text("")
    killer = Killer(work, kills, seed)
    started, processor_before_s = time.monotonic(), processor_s()
    killer.start()
    label(results)
    elapsed = time.monotonic() - started
    killer.stopped.set()
    killer.join()
    called = len(calls.read_text().split())
    same = "equal" if digest(results, drives) == expected else "DIFFERENT"
    done = sum((results / drive / "_SUCCESS.json").exists() for drive in drives)
    rate = f"{len(drives) / elapsed:.1f} drives/s"
    print(f"{name:8} {done} of {len(drives)} done, {rate}, {called} calls of detect, {killer.killed} kills, bytes {same}", flush=True)
    return elapsed, processor_s() - processor_before_s


def plain(work, drives, results):
    """`mapless detect` on each drive by xargs."""
    shutil.rmtree(results, ignore_errors=True)
    results.mkdir()
    command = f'{sys.executable} -m mapless detect {work}/drives/"$0" -o {results}/"$0" --threads 1 2>/dev/null >/dev/null'
    started, processor_before_s = time.monotonic(), processor_s()
    subprocess.run(["xargs", "-P", str(AT_ONCE), "-n", "1", "sh", "-c", command], input="\n".join(drives), text=True, check=True)
    return time.monotonic() - started, processor_s() - processor_before_s


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("--drives", type=int, default=200)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engines", nargs="+", default=ENGINES, choices=ENGINES)
    given = parser.parse_args()
    work = given.work.absolute()
    work.mkdir(parents=True, exist_ok=True)
    os.environ["RAY_AUTH_MODE"] = "disabled"
    simulate(work, given.drives)
    drives = sorted(path.name for path in (work / "drives").iterdir())
    plan, count = work / "plan.jsonl", command_that_counts(work)
    if mapless("batch", "plan", work / "drives", "-o", plan) != 0:
        sys.exit("the drives cannot be planned")
    plain_s, plain_processor_s = plain(work, drives, work / "results_plain")
    expected = digest(work / "results_plain", drives)
    print(f"plain    {len(drives) / plain_s:.1f} drives/s", flush=True)

    def run(results, *flags):
        mapless("batch", "run", plan, "-o", results, "--command", count, "--retries", 20, *flags)

    for engine in given.engines:
        kills = 0 if engine == "local" else given.kills
        reason = reason_not_to_start() if engine == "slurm" else None
        if reason is not None or (engine == "ray" and not shutil.which("ray")):
            print(f"{engine:8} {reason or 'not installed'}")
            continue
        label = {
            "local": lambda results: run(results, "--jobs", AT_ONCE),
            "killed": lambda results: run(results, "--jobs", AT_ONCE),
            "ray": lambda results: run(results, "--ray"),
            "slurm": lambda results: with_slurm(work, plan, results, drives),
        }[engine]
        batch_s, batch_processor_s = measure(engine, work, drives, expected, kills, given.seed, label)
        if engine == "local":
            wall_s = AT_ONCE * (batch_s - plain_s) / len(drives)
            overhead_s = (batch_processor_s - plain_processor_s) / len(drives)
            print(f"overhead of batch for each drive: {wall_s:.2f} s wall, {overhead_s:.2f} s of processor time", flush=True)


if __name__ == "__main__":
    main()

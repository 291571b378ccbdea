#!/usr/bin/env python3
"""Runs `mapless detect` for hours and watches the process: memory, open files, threads, processor time per scan.

A simulated drive is repeated (links to its scans), with 3 s between two rounds, after which the sensor is back at
the start: a restart in another place, so exit code 4 is as right as 0. Labels are removed as they come, as a program
that uses them would. Fails where the memory of the last quarter is above that of the second by 1 % or more, processor
time per scan by 10 % or more, or where the number of open files or threads differs; and where fewer than 3,000 scans
were measured, because memory grows until the first rounds are over.

usage: soak.py MAPLESS [--minutes 60] [--full-speed] [--odometry] [--scene town1] [--sensor HDL-64E-S2] [--round-s 8]
               [--threads N] [--interval-s 1] [--table FILE.csv] [--work FOLDER]

At 10 Hz (--realtime of mapless detect), or as fast as it goes with --full-speed: then --minutes is the time recorded.
"""

import argparse
import os
import pathlib
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time

PAUSE_S = 3.0
FEWEST_SCANS = 3000
MOST_GROWTH = {"memory": 0.01, "time": 0.10}


def repeat(base, folder, minutes):
    """Writes the recording of `minutes`; returns its number of scans."""
    (folder / "scans").mkdir(parents=True)
    (folder / "sensor.yaml").write_text((base / "sensor.yaml").read_text())
    times = [float(line) for line in (base / "times.txt").read_text().split()]
    poses = [line.split(" ", 1) for line in (base / "trajectory.txt").read_text().splitlines() if line[0] != "#"]
    last = times[-1] + times[1] - times[0]
    all_times, all_poses = [], []
    for number in range(max(2, round(minutes * 60 / (last + PAUSE_S)))):
        shift = number * (last + PAUSE_S)
        for k, begin in enumerate(times):
            os.symlink(base / "scans" / f"{k:06}.pcd", folder / "scans" / f"{len(all_times):06}.pcd")
            all_times.append(f"{begin + shift:.9f}\n")
        all_poses += [f"{float(t) + shift:.9f} {rest}\n" for t, rest in poses]
    (folder / "times.txt").write_text("".join(all_times))
    (folder / "trajectory.txt").write_text("".join(all_poses))
    return len(all_times)


def sample(pid):
    """Memory [kB], processor time [s], open files, threads."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    number = lambda key: int(re.search(rf"^{key}:\s+(\d+)", status, re.M)[1])
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    seconds = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return number("VmRSS"), seconds, len(os.listdir(f"/proc/{pid}/fd")), number("Threads")


def take_labels(out):
    """Removes the labels that are there; returns their number."""
    found = sorted((out / "labels").glob("*.label")) if (out / "labels").is_dir() else []
    for file in found:
        (out / "stages" / f"{file.stem}.stages").unlink(missing_ok=True)
        file.unlink()
    return len(found)


def watch(process, out, interval_s):
    """Rows of (scans, memory, seconds, files, threads)."""
    rows, scans = [], 0
    while process.poll() is None:
        time.sleep(interval_s)
        scans += take_labels(out)
        try:
            rows.append((scans, *sample(process.pid)))
        except (FileNotFoundError, ProcessLookupError, TypeError):
            break
    process.wait()
    return rows, scans + take_labels(out)


def problems(rows):
    if not rows or rows[-1][0] < FEWEST_SCANS:
        yield f"{rows[-1][0] if rows else 0} scans are too few to tell whether memory is flat: at least {FEWEST_SCANS}"
        return
    second, last = rows[len(rows) // 4 : len(rows) // 2], rows[3 * len(rows) // 4 :]
    # The command's own end is no part of it.
    last = last[:-1]
    memory = [statistics.median(row[1] for row in part) for part in (second, last)]
    per_scan = [1e3 * (part[-1][2] - part[0][2]) / max(1, part[-1][0] - part[0][0]) for part in (second, last)]
    print(f"memory {memory[0] / 1e3:.1f} MB in the second quarter, {memory[1] / 1e3:.1f} MB in the last; processor time "
          f"{per_scan[0]:.1f} and {per_scan[1]:.1f} ms a scan; open files {min(r[3] for r in last)} to "
          f"{max(r[3] for r in second + last)}; threads {max(r[4] for r in second + last)}")
    if memory[1] > memory[0] * (1 + MOST_GROWTH["memory"]):
        yield "memory grows"
    if per_scan[1] > per_scan[0] * (1 + MOST_GROWTH["time"]):
        yield "the time per scan grows"
    # A scan that is read and a file that is written are open for a moment: the fewest are compared.
    if min(r[3] for r in last) > min(r[3] for r in second):
        yield "open files become more"
    if max(r[4] for r in last) > max(r[4] for r in second):
        yield "threads become more"


def soak(options, work):
    base, recording, out = work / "base", work / "recording", work / "out"
    subprocess.run([options.mapless, "simulate", options.scene, "--sensor", options.sensor, "--duration-s", str(options.round_s),
                    "-o", base], check=True, capture_output=True)
    scans = repeat(base, recording, options.minutes)
    command = [options.mapless, "detect", recording, "-o", out]
    command += [] if options.full_speed else ["--realtime"]
    command += ["--odometry"] if options.odometry else []
    command += ["--threads", str(options.threads)] if options.threads else []
    print(f"{scans} scans: {' '.join(str(word) for word in command)}", flush=True)
    with open(work / "stderr", "w") as errors:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors)
        try:
            rows, labelled = watch(process, out, options.interval_s)
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
    if options.table:
        head = "scans,memory_kb,processor_s,files,threads"
        options.table.write_text("\n".join([head, *(",".join(map(str, row)) for row in rows)]) + "\n")
    found = list(problems(rows))
    if process.returncode not in (0, 4):
        found.append(f"exit code {process.returncode}: {(work / 'stderr').read_text().splitlines()[-1:]}")
    if options.full_speed and labelled != scans:
        found.append(f"{labelled} of {scans} scans are labelled")
    for problem in found:
        print(f"FAILED: {problem}")
    print(f"{labelled} of {scans} scans labelled, exit code {process.returncode}")
    return not found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mapless", type=pathlib.Path)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--full-speed", action="store_true")
    parser.add_argument("--odometry", action="store_true")
    parser.add_argument("--scene", default="town1")
    parser.add_argument("--sensor", default="HDL-64E-S2")
    parser.add_argument("--round-s", type=float, default=8, help="length of the drive that is repeated [s]")
    parser.add_argument("--threads", type=int, help="of mapless detect")
    parser.add_argument("--table", type=pathlib.Path, help="file for the measurements")
    parser.add_argument("--interval-s", type=float, default=1, help="between two measurements [s]")
    parser.add_argument("--work", type=pathlib.Path, help="folder for temporary files")
    options = parser.parse_args()
    options.mapless = options.mapless.resolve()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # takes the run along
    with tempfile.TemporaryDirectory(dir=options.work) as work:
        sys.exit(0 if soak(options, pathlib.Path(work)) else 1)


if __name__ == "__main__":
    main()

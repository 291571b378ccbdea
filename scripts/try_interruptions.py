#!/usr/bin/env python3
"""Ends runs of `mapless detect` in every way a run can end before its last scan, and goes on with --resume:

kills   SIGKILL, SIGTERM, SIGINT at random instants, half of the resumed runs once more
full    a file system of a few KiB to the size of the result (tmpfs; needs root, else left out), then enlarged
io      the n-th read (EIO), write (ENOSPC) or fsync (EIO) of a run and of a resumed run fails, by LD_PRELOAD
        (tests/tools/failing_io.c; needs a C compiler); and all reads and writes short and interrupted

After each, every label file that is there has the bytes of an undisturbed run; the exit code is that of
docs/reliability.md; and --resume ends with 0 and the bytes of the undisturbed run in every file but summary.json.
Along the recording's poses and along own odometry in turn.

usage: try_interruptions.py MAPLESS [--loops kills full io] [--trials N] [--seed N] [--work FOLDER]
"""

import argparse
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

SIGNALS = [signal.SIGKILL, signal.SIGTERM, signal.SIGINT]
FULL, BROKEN = 75, 1  # exit codes


class Loops:
    def __init__(self, mapless, work, rng):
        self.mapless, self.work, self.random = mapless, work, rng
        self.recording, self.out = work / "recording", work / "disk" / "out"
        (work / "disk").mkdir()
        self.failures, self.trials = 0, 0
        subprocess.run([mapless, "simulate", "town1", "--sensor", "VLP-16", "--duration-s", "0.8", "--seed", "5",
                        "-o", self.recording], check=True, capture_output=True)
        self.right, self.seconds = {}, {}
        for motion in ([], ["--odometry"]):
            begin = time.monotonic()
            done = self.run(motion)
            if done.returncode not in (0, 4):
                sys.exit(f"the undisturbed run ends with {done.returncode}: {done.stderr}")
            self.seconds[len(motion)] = time.monotonic() - begin
            self.right[len(motion)] = (done.returncode, self.files())
            shutil.rmtree(self.out)

    def command(self, motion, *more):
        return [self.mapless, "detect", self.recording, "-o", self.out, *motion, *more]

    def run(self, motion, *more, **environment):
        return subprocess.run(self.command(motion, *more), capture_output=True, text=True, env={**os.environ, **environment})

    def files(self):
        return {str(file.relative_to(self.out)): file.read_bytes() for file in self.out.rglob("*")
                if file.is_file() and file.name not in ("summary.json", ".lock")}

    def fail(self, what):
        self.failures += 1
        print(f"FAILED: {what}", flush=True)

    def require_whole_labels(self, motion, what):
        right = self.right[len(motion)][1]
        for file in (self.out / "labels").glob("*.label") if self.out.is_dir() else []:
            if file.read_bytes() != right[f"labels/{file.name}"]:
                self.fail(f"{what}: {file.name} is not whole")

    def finish(self, motion, what):
        """The run goes on to the bytes of one run; leaves nothing."""
        self.trials += 1
        code, right = self.right[len(motion)]
        done = self.run(motion, "--resume")
        if done.returncode != code:
            self.fail(f"{what}: --resume ends with {done.returncode}: {done.stderr.strip()}")
        elif self.files() != right:
            found = self.files()
            names = sorted(name for name in found.keys() | right.keys() if found.get(name) != right.get(name))
            self.fail(f"{what}: {names[:5]} differ")
        shutil.rmtree(self.out, ignore_errors=True)

    def kill(self, motion, more, which):
        process = subprocess.Popen(self.command(motion, *more), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        # Also within start and end.
        try:
            process.wait(self.random.uniform(0, 1.1) * self.seconds[len(motion)])
        except subprocess.TimeoutExpired:
            process.send_signal(which)
        code = process.wait()
        ended = -which if which == signal.SIGKILL else 128 + which
        if code not in (self.right[len(motion)][0], ended, -which):
            self.fail(f"exit code {code} after {which.name}")

    def kills(self, count):
        killed = 0
        while killed < count:
            motion, which = self.motion(killed), SIGNALS[killed % 3]
            self.kill(motion, [], which)
            killed += 1
            self.require_whole_labels(motion, which.name)
            if self.random.random() < 0.5:
                self.kill(motion, ["--resume"], which)
                killed += 1
                self.require_whole_labels(motion, which.name)
            self.finish(motion, which.name)
        print(f"kills: {killed} in {self.trials} runs", flush=True)

    @staticmethod
    def motion(number):
        return [] if number % 2 == 0 else ["--odometry"]

    def full(self, count):
        if os.geteuid() != 0:
            print("full: left out, needs root")
            return
        size = sum(len(content) for content in self.right[0][1].values())
        for trial in range(count):
            motion = self.motion(trial)
            # tmpfs counts pages of 4 KiB: small files take more than their bytes.
            room = int(8192 + (trial + self.random.random()) / count * 1.5 * size)
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={room}", "tmpfs", self.out.parent], check=True)
            try:
                done = self.run(motion)
                if done.returncode not in (FULL, self.right[len(motion)][0]):
                    self.fail(f"{room} bytes: exit code {done.returncode}: {done.stderr.strip()}")
                self.require_whole_labels(motion, f"{room} bytes")
                subprocess.run(["mount", "-o", f"remount,size={8 * size}", self.out.parent], check=True)
                self.finish(motion, f"{room} bytes")
            finally:
                subprocess.run(["umount", self.out.parent], check=True)
        print(f"full: {count} sizes up to {1.5 * size / 1e6:.1f} MB", flush=True)

    def io(self, count):
        library = self.work / "failing_io.so"
        source = pathlib.Path(__file__).resolve().parent.parent / "tests/tools/failing_io.c"
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl"], check=True)
        preload = {"LD_PRELOAD": str(library), "FAILING_IO_IN": str(self.work)}
        for motion in ([], ["--odometry"]):
            done = self.run(motion, **preload, FAILING_IO="short")
            if done.returncode != self.right[len(motion)][0]:
                self.fail(f"short reads and writes: exit code {done.returncode}: {done.stderr.strip()}")
            self.finish(motion, "short reads and writes")
        for kind, code in (("read", BROKEN), ("write", FULL), ("fsync", BROKEN)):
            failed = 0
            for trial in range(count):
                motion = self.motion(trial)
                at = trial + 1 if trial < count // 2 else self.random.randrange(count // 2, 120)
                settings = {**preload, "FAILING_IO": kind, "FAILING_IO_AT": str(at)}
                if trial % 3 == 2:  # of a resumed run
                    self.kill(motion, [], signal.SIGKILL)
                done = self.run(motion, *(["--resume"] if trial % 3 == 2 else []), **settings)
                failed += done.returncode == code
                if done.returncode not in (code, self.right[len(motion)][0]):
                    self.fail(f"{kind} {at}: exit code {done.returncode}: {done.stderr.strip()}")
                self.require_whole_labels(motion, f"{kind} {at}")
                self.finish(motion, f"{kind} {at}")
            print(f"{kind}: {failed} of {count} runs ended by it", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mapless", type=pathlib.Path)
    parser.add_argument("--loops", nargs="+", choices=["kills", "full", "io"], default=["kills", "full", "io"])
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--work", type=pathlib.Path, help="folder for temporary files")
    options = parser.parse_args()
    if "full" in options.loops and os.geteuid() == 0 and "TRY_INTERRUPTIONS_MOUNTS" not in os.environ:
        # The mounts are nobody else's, and end with this process.
        os.environ["TRY_INTERRUPTIONS_MOUNTS"] = "1"
        os.execvp("unshare", ["unshare", "-m", sys.executable, *sys.argv])
    with tempfile.TemporaryDirectory(dir=options.work) as work:
        loops = Loops(options.mapless.resolve(), pathlib.Path(work), random.Random(options.seed))
        for name in options.loops:
            getattr(loops, name)(options.trials)
        print(f"{loops.failures} failures")
        sys.exit(1 if loops.failures else 0)


if __name__ == "__main__":
    main()

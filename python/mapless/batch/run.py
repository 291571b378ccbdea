"""Labels the drives of a plan on one machine: as many at once as cores and memory allow, a process each."""

from __future__ import annotations

import collections
import os
import pathlib
import signal
import subprocess
import sys
import time
from collections.abc import Callable

from mapless.batch import storage, task as tasks
from mapless.batch.errors import FINISHED, ExitCode, can_succeed_later, cause
from mapless.batch.plan import Task
from mapless.batch.progress import Progress

# Five times the peak of `mapless detect --odometry --threads 1` on four seconds of an OS1-128 (198 MB, peak_memory_mb of
# summary.json), because the map of the odometry grows with the drive.
DRIVE_MEMORY_MB = 1000
POLL_S = 0.02  # between looks at the processes


def usable_cores() -> int:
    return len(os.sched_getaffinity(0))


def available_memory_mb() -> float:
    """Of the machine, and of the control group where there is a limit."""
    facts = dict(line.split(":") for line in pathlib.Path("/proc/meminfo").read_text().splitlines())
    available = int(facts["MemAvailable"].split()[0]) / 1024
    for limit, used in (
        ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
    ):
        try:
            bytes_left = int(pathlib.Path(limit).read_text()) - int(pathlib.Path(used).read_text())
        except (OSError, ValueError):  # no such group, or its limit is "max"
            continue
        available = min(available, bytes_left / 2**20)
    return available


class Counts:
    """What has become of the drives of a plan."""

    def __init__(self) -> None:
        self.skipped = 0
        self.codes: collections.Counter[int] = collections.Counter()

    def exit_code(self) -> int:
        """75 if trying again can help any drive, else 1, 3 or 4 if any drive ended so."""
        failed = [code for code in self.codes if code not in FINISHED]
        if any(can_succeed_later(code) for code in failed):
            return ExitCode.TEMPORARY
        for code in (ExitCode.FAILURE, ExitCode.USAGE, ExitCode.BAD_INPUT, ExitCode.NOT_TRUSTED):
            if self.codes[code]:
                return code
        return ExitCode.FAILURE if failed else ExitCode.SUCCESS

    def lines(self) -> list[str]:
        done = sum(self.codes[code] for code in FINISHED)
        text = [f"{done} drives labelled, {self.skipped} were done, {self.codes.total() - done} failed"]
        if self.codes[ExitCode.NOT_TRUSTED]:
            text.append(f"{self.codes[ExitCode.NOT_TRUSTED]} of them are not trustworthy (4): see the merged page")
        failed = sorted(code for code in self.codes if code not in FINISHED)
        text += [f"{self.codes[code]} failed: {cause(code)}" for code in failed]
        return text


def undone(plan: list[Task], results: str) -> list[int]:
    """Numbers of the lines whose result is not there, with the same hash. Of a drive whose parts are all labelled and not
    joined: that of its last part, whose task joins them."""
    drives = {task.whole().id: task.whole() for task in plan}
    done = {name for name, drive in drives.items() if tasks.record_of(results, drive) is not None}
    open_lines = [k for k, task in enumerate(plan) if task.whole().id not in done]
    lacking = [k for k in open_lines if plan[k].parts == 1 or tasks.record_of(results, plan[k]) is None]
    with_labels = drives.keys() - {plan[k].whole().id for k in lacking}
    joining = [k for k in open_lines if plan[k].whole().id in with_labels and plan[k].part == plan[k].parts - 1]
    return sorted(lacking + joining)


class LocalRun:
    """Processes of `mapless batch run --index N`, `jobs` of them at once."""

    def __init__(self, command: Callable[[int], list[str]], jobs: int, retries: int) -> None:
        self._command = command
        self._jobs = jobs
        self._retries = retries
        self._running: dict[int, subprocess.Popen[bytes]] = {}
        self._tries: collections.Counter[int] = collections.Counter()
        self._waiting: collections.deque[int] = collections.deque()

    def run(self, lines: list[int], finished: Callable[[int, int], None]) -> None:
        """Calls finished(line, exit code) for each line. Ctrl-C: the drives that run end, no further one starts."""
        self._waiting.extend(lines)
        try:
            while self._waiting or self._running:
                self._start()
                time.sleep(POLL_S)
                self._collect(finished)
        except KeyboardInterrupt:
            for process in self._running.values():
                process.send_signal(signal.SIGINT)
            for process in self._running.values():
                process.wait()
            raise

    def _start(self) -> None:
        while self._waiting and len(self._running) < self._jobs:
            if self._running and available_memory_mb() < DRIVE_MEMORY_MB:
                return
            k = self._waiting.popleft()
            self._tries[k] += 1
            # A session of its own: Ctrl-C reaches this process alone, which passes it on once.
            self._running[k] = subprocess.Popen(self._command(k), stderr=subprocess.DEVNULL, start_new_session=True)

    def _collect(self, finished: Callable[[int, int], None]) -> None:
        for k, process in list(self._running.items()):
            code = process.poll()
            if code is None:
                continue
            del self._running[k]
            if can_succeed_later(code) and self._tries[k] <= self._retries:
                self._waiting.append(k)
            else:
                finished(k, code if code >= 0 else 128 - code)


def index_command(plan: str, results: str, flags: list[str]) -> Callable[[int], list[str]]:
    """What every engine calls for a line of the plan."""
    start = [sys.executable, "-m", "mapless", "batch", "run", plan, "-o", results, *flags]
    return lambda k: [*start, "--index", str(k)]


def note_killed(results: str, task: Task, code: int) -> None:
    """The process of a task that was killed could not say so itself."""
    if code > 128 and tasks.failure_of(results, task) is None:
        failure = {"id": task.id, "hash": task.hash, "exit_code": code, "message": cause(code), "host": ""}
        storage.write_json(storage.joined(results, tasks.FAILED, task.id + ".json"), failure)


Engine = Callable[[list[int], Callable[[int, int], None]], None]
"""Runs lines of the plan; calls its second argument with the number of a line and its exit code at the end of each."""


def run_plan(plan: list[Task], results: str, run: Engine, progress: Progress) -> Counts:
    """Runs the lines that are not done."""
    counts = Counts()
    lines = undone(plan, results)
    counts.skipped = len(plan) - len(lines)
    progress.start(len(lines), counts.skipped)

    def finished(k: int, code: int) -> None:
        counts.codes[code] += 1
        if code not in FINISHED:
            note_killed(results, plan[k], code)
        progress.add(code in FINISHED)

    try:
        run(lines, finished)
    finally:
        progress.end()
    return counts

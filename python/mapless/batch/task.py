"""One task: a drive in, its folder in the results out. Every engine calls this and nothing else.

    RESULTS/DRIVE/                 what `mapless detect` writes, and _SUCCESS.json
    RESULTS/.failed/DRIVE.json     why the last attempt failed
    RESULTS/.attempts/DRIVE/       an attempt that goes on or was killed

A result appears by one rename (in an object store: with _SUCCESS.json, written last), so whoever sees it sees all of it.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import json
import math
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from typing import Any

from mapless.batch import parts, storage
from mapless.batch.errors import FINISHED, BatchError, ExitCode
from mapless.batch.plan import Task, fingerprint
from mapless.readers import OPTIONS

SUCCESS = "_SUCCESS.json"
VIEWER = "viewer.html"
RECORDING_OPTIONS = {"--sensor", "--labels", "--own-pose-direction", "--own-pose-instant", *OPTIONS}
ATTEMPTS = ".attempts"
FAILED = ".failed"
PR_SET_PDEATHSIG = 1  # of <sys/prctl.h>
MAPLESS = (sys.executable, "-m", "mapless")


def record_of(results: str, task: Task) -> dict[str, Any] | None:
    """_SUCCESS.json of the drive, if its result is that of this line of the plan and there."""
    record = storage.read_json(storage.joined(results, task.id, SUCCESS))
    return record if record is not None and record.get("hash") == task.hash and not record.get("joined") else None


def failure_of(results: str, task: Task) -> dict[str, Any] | None:
    failure = storage.read_json(storage.joined(results, FAILED, task.id + ".json"))
    return failure if failure is not None and failure.get("hash") == task.hash else None


def end_with_parent() -> None:
    """For a process about to start: otherwise a killed task would leave its detect behind, which goes on writing."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def _execute(command: Sequence[str]) -> tuple[int, list[str]]:
    """Exit code (128 + N: ended by signal N) and the lines of stderr that are not progress."""
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        preexec_fn=end_with_parent,
    )
    try:
        _, text = process.communicate()
    except KeyboardInterrupt:
        process.send_signal(signal.SIGINT)
        process.communicate()
        raise
    code = process.returncode if process.returncode >= 0 else 128 - process.returncode
    lines = [line.removeprefix("mapless: ") for line in text.splitlines() if "scans/s" not in line]
    return code, lines


def _driven_m(folder: str) -> float:
    """Length of the path of the sensor, from the poses at the starts of its scans."""
    rows = [[float(n) for n in line.split()] for line in pathlib.Path(folder, "poses_kitti.txt").read_text().splitlines()]
    places = [(row[3], row[7], row[11]) for row in rows]
    return sum(math.dist(p, q) for p, q in zip(places, places[1:]))


def _counts(folder: str) -> dict[str, Any]:
    summary = json.loads(pathlib.Path(folder, "summary.json").read_text())
    wanted = ("scans", "points", "dynamic_points", "objects", "objects_over_time")
    return {
        **{name: int(summary.get(name, 0)) for name in wanted},
        "driven_m": round(_driven_m(folder), 3),
        "sensor": summary.get("sensor"),
        "peak_memory_mb": summary.get("peak_memory_mb"),
    }


def _options_of_recording(options: Sequence[str]) -> list[str]:
    """Those that other verbs than detect need too, to read the recording."""
    kept: list[str] = []
    for option, value in zip(options, [*options[1:], ""]):
        if option.split("=")[0] in RECORDING_OPTIONS:
            kept += [option] if "=" in option else [option, value]
    return kept


def reader_options(options: Sequence[str]) -> dict[str, str]:
    """Those of the readers of Python, by flag."""
    kept = _options_of_recording(options)
    split = [part for text in kept for part in (text.split("=", 1) if text.startswith("--") else [text])]
    return {flag: value for flag, value in zip(split[::2], split[1::2]) if flag in OPTIONS}


def _confusion(task: Task, local: str, folder: str, command: Sequence[str]) -> dict[str, Any]:
    if not task.evaluate:
        return {}
    report = os.path.join(folder, "evaluation.json")
    given = ["--format", task.format, *_options_of_recording(task.options)]
    code, lines = _execute([*command, "evaluate", local, folder, "--json", report, *given])
    if code != ExitCode.SUCCESS:
        raise BatchError(f"mapless evaluate: {(lines or ['no message'])[-1]}", code)
    labels = json.loads(pathlib.Path(report).read_text())["final"]
    return {"true_positives": labels["tp"], "false_positives": labels["fp"], "false_negatives": labels["fn"]}


def _write_viewer(task: Task, local: str, folder: str, command: Sequence[str]) -> None:
    if task.view == 0:
        return
    scans = sum(1 for _ in pathlib.Path(folder, "labels").glob("*.label"))
    every = max(1, math.ceil(scans / task.view))
    page = os.path.join(folder, VIEWER)
    given = _options_of_recording(task.options)
    code, lines = _execute([*command, "view", local, folder, "-o", page, "--format", task.format, "--every", str(every), *given])
    if code != ExitCode.SUCCESS:
        raise BatchError(f"mapless view: {(lines or ['no message'])[-1]}", code)


class _Attempt:
    """The local folder in which a task works. Beside results on a disk it is locked: the second task for a drive ends
    with "try again later". In an object store two tasks for a drive write the same bytes."""

    def __init__(self, task: Task, results: str, scratch: str | None) -> None:
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._lock: int | None = None
        if storage.is_uri(results):
            self._temporary = tempfile.TemporaryDirectory(prefix="mapless-result-", dir=scratch)
            self.folder = os.path.join(self._temporary.name, task.id)
        else:
            self.folder = os.path.join(results, ATTEMPTS, task.id)
            os.makedirs(os.path.dirname(self.folder), exist_ok=True)
            self._take_lock(self.folder + ".lock")
            storage.remove(self.folder)  # of a killed task: its half-written files would end up in the result
        os.makedirs(self.folder, exist_ok=True)
        self.output = os.path.join(self.folder, "result")

    def _take_lock(self, file: str) -> None:
        lock = os.open(file, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, 0o644)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.fstat(lock).st_ino != os.stat(file).st_ino:  # removed meanwhile by the task that held it
                raise FileNotFoundError
        except (BlockingIOError, FileNotFoundError):
            os.close(lock)
            raise BatchError(f"{file}: another task labels this drive now; try again later", ExitCode.TEMPORARY) from None
        self._lock = lock

    def remove(self) -> None:
        storage.remove(self.folder)

    def close(self) -> None:
        """Nothing of the task is left but the folder of one that was killed or raised."""
        if self._temporary is not None:
            self._temporary.cleanup()
        if self._lock is not None:
            storage.remove(self.folder + ".lock")
            os.close(self._lock)


def _failed(task: Task, results: str, code: int, message: str) -> int:
    failure = {"id": task.id, "hash": task.hash, "exit_code": code, "message": message, "host": socket.gethostname()}
    try:
        storage.write_json(storage.joined(results, FAILED, task.id + ".json"), failure)
    except OSError:  # a full disk: the exit code says it
        pass
    print(f"mapless: error: drive {task.id}: {message}", file=sys.stderr)
    return code


def _record(task: Task, folder: str, code: int, trouble: str) -> dict[str, Any]:
    return {
        "id": task.id,
        "path": task.path,
        "hash": task.hash,
        "input": task.input,
        "version": task.version,
        "exit_code": code,
        "trouble": trouble,
        "host": socket.gethostname(),
        **_counts(folder),
    }


def _finish(task: Task, results: str, attempt: _Attempt, record: dict[str, Any], started: float) -> None:
    record["seconds"] = round(time.time() - started + record.get("seconds", 0.0), 3)
    storage.remove(os.path.join(attempt.output, ".lock"))
    storage.write_json(os.path.join(attempt.output, SUCCESS), record)
    storage.publish(attempt.output, storage.joined(results, task.id), SUCCESS)
    attempt.remove()
    storage.remove(storage.joined(results, FAILED, task.id + ".json"))


def _label(task: Task, results: str, scratch: str | None, threads: int, command: Sequence[str]) -> int:
    started = time.time()
    with contextlib.closing(_Attempt(task, results, scratch)) as attempt, storage.local_copy(task.path, scratch) as local:
        flags = ["-o", attempt.output, "--threads", str(threads), *parts.range_flags(task)]
        code, lines = _execute([*command, "detect", local, "--format", task.format, *flags, *task.options])
        if code not in FINISHED:
            attempt.remove()  # the next try begins anew; on a full disk the other drives need the place
            errors = [line.removeprefix("error: ") for line in lines if line.startswith("error: ")]
            return _failed(task, results, code, (errors or lines or ["no message"])[-1])
        trouble = lines[-1] if code == ExitCode.NOT_TRUSTED and lines else ""
        record = _record(task, attempt.output, code, trouble)
        if task.parts == 1:
            _write_viewer(task, local, attempt.output, command)
            record |= _confusion(task, local, attempt.output, command)
        _finish(task, results, attempt, record, started)
    return code


def _join(task: Task, results: str, scratch: str | None, threads: int, command: Sequence[str]) -> int:
    """The result of the whole drive, if all of its parts are done. Where they do not fit, by one run."""
    from mapless.batch.joining import join  # loads NumPy

    siblings, whole = task.cut(task.parts), task.whole()
    records = [record for sibling in siblings if (record := record_of(results, sibling)) is not None]
    if len(records) < task.parts:
        return ExitCode.SUCCESS
    places = [storage.joined(results, sibling.id) for sibling in siblings]
    started = time.time()
    try:
        with contextlib.ExitStack() as stack:
            try:
                attempt = stack.enter_context(contextlib.closing(_Attempt(whole, results, scratch)))
            except BatchError:  # the task of another part, which has ended at the same time, joins them
                return ExitCode.SUCCESS
            local = stack.enter_context(storage.local_copy(task.path, scratch))
            folders = [stack.enter_context(storage.local_copy(place, scratch)) for place in places]
            join(siblings, folders, attempt.output)
            record = _record(whole, attempt.output, ExitCode.SUCCESS, "")
            record |= {"parts": task.parts, "seconds": sum(part["seconds"] for part in records)}
            _write_viewer(whole, local, attempt.output, command)
            record |= _confusion(whole, local, attempt.output, command)
            _finish(whole, results, attempt, record, started)
    except parts.PartsDifferError as difference:
        print(f"mapless: drive {whole.id}: its parts differ ({difference}); it is labelled in one run", file=sys.stderr)
        code = _label(whole, results, scratch, threads, command)
        if code not in FINISHED:
            return code
    for part, place in zip(records, places):  # the record stays: it is what Snakemake waits for
        storage.remove(place)
        storage.write_json(storage.joined(place, SUCCESS), {**part, "joined": True})
    return ExitCode.SUCCESS


def run_task(
    task: Task, results: str, *, scratch: str | None = None, threads: int = 1, command: Sequence[str] = MAPLESS
) -> int:
    """Labels the drive unless its result is there. Returns the exit code of the task; never raises for a bad drive."""
    done = record_of(results, task.whole())
    if done is not None:
        return int(done["exit_code"])
    try:
        code: int = ExitCode.SUCCESS
        if fingerprint(task.path) != task.input:
            message = f"{task.path}: changed since the plan was made; make the plan anew"
            return _failed(task, results, ExitCode.BAD_INPUT, message)
        if task.parts == 1 or record_of(results, task) is None:
            code = _label(task, results, scratch, threads, command)
        if task.parts > 1 and code in FINISHED:
            code = _join(task, results, scratch, threads, command)
        return code
    except FileNotFoundError as error:
        return _failed(task, results, ExitCode.BAD_INPUT, f"{error.filename}: no such file")
    except BatchError as error:
        return _failed(task, results, error.exit_code, str(error))
    except OSError as error:
        full = error.errno in (28, 122)  # ENOSPC, EDQUOT
        return _failed(task, results, ExitCode.TEMPORARY if full else ExitCode.FAILURE, str(error))

"""The plan: one line of JSON for each drive, sorted by id."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import pathlib
import re
from collections.abc import Iterator
from typing import Any

import mapless
from mapless.batch import storage
from mapless.batch.errors import BatchError, ExitCode


# Ids name folders of the results. None begins with a dot: "..", hidden files.
NAME = re.compile(r"[\w-][\w.-]*")


@dataclasses.dataclass(frozen=True)
class Task:
    """One drive to label: a line of the plan."""

    id: str
    """name of the drive's result; unique in the plan"""
    path: str
    """absolute path or URI of the recording"""
    format: str
    sensor: str | None
    """None: not known before the drive is read (URIs, bags)"""
    scans: int | None
    """None: not known before the drive is read (URIs)"""
    options: tuple[str, ...]
    """of `mapless detect`, after the recording and the output"""
    input: str
    """fingerprint of the recording's files"""
    version: str
    """of mapless"""
    evaluate: bool = False
    """whether the result is compared with the true labels of the recording"""
    view: int = 0
    """scans shown by viewer.html of the result, spread over the drive; 0: no such page"""
    drive: str = ""
    """id of the drive of which this is a part; empty: of a whole drive"""
    part: int = 0
    parts: int = 1

    @property
    def hash(self) -> str:
        """Of all that the result depends on. A result with the same hash is not computed again."""
        facts = [self.id, self.input, self.format, self.version, list(self.options), self.evaluate, self.view]
        if self.parts > 1:
            facts += [self.part, self.parts]
        return hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:32]

    @property
    def kept(self) -> range:
        """The scans of the drive that this part labels."""
        scans = self.scans or 0
        return range(scans * self.part // self.parts, scans * (self.part + 1) // self.parts)

    def whole(self) -> Task:
        """The task of the whole drive. Parts leave the bytes of its result, and so its hash."""
        return dataclasses.replace(self, id=self.drive or self.id, drive="", part=0, parts=1)

    def cut(self, parts: int) -> list[Task]:
        """The tasks of all parts of the drive."""
        drive = self.drive or self.id
        named = [dataclasses.replace(self, id=f"{drive}.part{k:04d}", drive=drive, part=k, parts=parts) for k in range(parts)]
        return named if parts > 1 else [self.whole()]

    def line(self) -> str:
        return json.dumps({**dataclasses.asdict(self), "hash": self.hash}, sort_keys=True) + "\n"


def task_of_line(line: str, name: str) -> Task:
    """`name`: of the file and line, for messages."""
    try:
        value = json.loads(line)
        stated = value.pop("hash")
        task = Task(**{**value, "options": tuple(value["options"])})
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise BatchError(f"{name}: not a line of a plan: {error}; make it with mapless batch plan") from None
    if not all(isinstance(name, str) and NAME.fullmatch(name) for name in (task.id, task.drive or task.id)):
        raise BatchError(f"{name}: id {task.id!r}: not a name of letters, digits, _, - and ., which names a folder of RESULTS")
    if stated != task.hash:
        raise BatchError(f"{name}: drive {task.id}: its hash does not fit the line; make it anew with mapless batch plan")
    return task


def lines_of(plan: str) -> Iterator[str]:
    content = storage.read_bytes(plan)
    if content is None:
        raise BatchError(f"{plan}: no such file; make it with mapless batch plan", ExitCode.BAD_INPUT)
    try:
        yield from content.decode().splitlines()
    except UnicodeDecodeError as error:
        raise BatchError(f"{plan}: not a plan: {error}; make it with mapless batch plan", ExitCode.BAD_INPUT) from None


def read_plan(plan: str) -> list[Task]:
    return [task_of_line(line, f"{plan} line {k + 1}") for k, line in enumerate(lines_of(plan))]


def read_task(plan: str, index: int) -> Task:
    """Line `index` of the plan, from 0."""
    count = 0
    for count, line in enumerate(lines_of(plan), start=1):
        if count == index + 1:
            return task_of_line(line, f"{plan} line {count}")
    raise BatchError(f"--index {index}: {plan} has lines 0 to {count - 1}")


def fingerprint(path: str) -> str:
    """Of names, sizes and times of change of the drive's files (in an object store: entity tags).

    Content would mean reading every drive twice. A copy that keeps no times is labelled again, which costs time; a file
    that changes and keeps size and time to the nanosecond is not noticed."""
    digest = hashlib.sha256()
    for name, size, stamp in storage.list_files(path):
        digest.update(f"{name}\0{size}\0{stamp}\n".encode())
    return digest.hexdigest()[:32]


@dataclasses.dataclass
class Refusal:
    path: str
    reason: str


def make_task(drive: Any, options: tuple[str, ...], evaluate: bool, view: int) -> Task:
    return Task(
        id=drive.id,
        path=drive.path,
        format=drive.format,
        sensor=drive.sensor,
        scans=drive.scans,
        options=options,
        input=fingerprint(drive.path),
        version=mapless.__version__,
        evaluate=evaluate,
        view=view,
    )


def write_plan(place: str, tasks: list[Task]) -> None:
    storage.write_bytes(place, "".join(task.line() for task in tasks).encode())


def absolute(place: str) -> str:
    return place.rstrip("/") if storage.is_uri(place) else str(pathlib.Path(place).absolute())

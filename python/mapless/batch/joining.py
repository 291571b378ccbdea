"""Joins the labelled parts of a drive to the bytes of one run.

Over the last COMPARED scans before its first one each part is compared with the one before it, labels, stages and
objects; where a byte differs the parts are not joined.
"""

from __future__ import annotations

import collections
import csv
import dataclasses
import json
import os
import pathlib
import shutil

import numpy as np
import numpy.typing as npt

from mapless._result import MOVING, Result
from mapless.batch import parts as _parts
from mapless.batch.parts import PartsDifferError, first_scan
from mapless.batch.plan import Task

LABEL_NUMBERS = 65535

ID, AGE = 2, 16  # columns of objects.csv
Row = list[str]


def label_number(identity: int) -> int:
    return (identity - 1) % LABEL_NUMBERS + 1


@dataclasses.dataclass
class _Known:
    """An object of a part in the whole drive."""

    identity: int
    older: int  # scans of its age before the warm-up


class _Part:
    """A labelled part, read from its folder."""

    def __init__(self, task: Task, folder: str) -> None:
        self.task = task
        self.folder = pathlib.Path(folder)
        self.first = first_scan(task)
        self.rows: dict[int, list[Row]] = {}
        with (self.folder / "objects.csv").open(newline="") as file:
            self.head, *rows = list(csv.reader(file))
        for row in rows:
            self.rows.setdefault(int(row[0]), []).append(row)
        self.known: dict[int, _Known] = {}  # by id in this part

    def label(self, scan: int) -> npt.NDArray[np.uint32]:
        return np.fromfile(self.folder / "labels" / f"{scan:06d}.label", dtype="<u4")

    def stages(self, scan: int) -> bytes:
        return (self.folder / "stages" / f"{scan:06d}.stages").read_bytes()

    def lines(self, name: str) -> list[str]:
        return (self.folder / name).read_text().splitlines(keepends=True)

    def numbers(self) -> npt.NDArray[np.uint32]:
        """Numbers in labels of the whole drive by those of this part."""
        table = np.zeros(LABEL_NUMBERS + 1, np.uint32)
        for identity, known in self.known.items():
            table[label_number(identity)] = label_number(known.identity)
        return table

    def renumbered(self, scan: int) -> npt.NDArray[np.uint32]:
        label = self.label(scan)
        numbered: npt.NDArray[np.uint32] = (self.numbers()[label >> 16] << np.uint32(16)) | (label & np.uint32(0xFFFF))
        return numbered


def _without_id(row: Row) -> tuple[str, ...]:
    return (*row[:ID], *row[ID + 1 : AGE])


def _recognise(before: _Part, part: _Part) -> None:
    """Sets part.known from the scans that both have labelled. Raises PartsDifferError where they differ."""
    cut = part.task.kept.start
    for scan in range(max(cut - _parts.COMPARED, part.first), cut):
        old = {_without_id(row): row for row in before.rows.get(scan, [])}
        new = {_without_id(row): row for row in part.rows.get(scan, [])}
        if old.keys() != new.keys():
            raise PartsDifferError(f"objects of scan {scan}")
        for key, row in new.items():
            known = before.known[int(old[key][ID])]
            here = _Known(known.identity, known.older + int(old[key][AGE]) - int(row[AGE]))
            if part.known.setdefault(int(row[ID]), here) != here:
                raise PartsDifferError(f"object {known.identity} of scan {scan}")
        if before.stages(scan) != part.stages(scan):
            raise PartsDifferError(f"stages of scan {scan}")
        if not np.array_equal(before.renumbered(scan), part.renumbered(scan)):
            raise PartsDifferError(f"labels of scan {scan}")


def _number_new_objects(part: _Part, last: int) -> int:
    """The ids after `last`, in the order of their first scans, as one run gives them. Returns the last."""
    for scan in part.task.kept:
        for identity in sorted(int(row[ID]) for row in part.rows.get(scan, [])):
            if identity not in part.known:
                last += 1
                part.known[identity] = _Known(last, 0)
    return last


def _rows(part: _Part) -> list[Row]:
    """Of the scans that the part keeps, by scan and id."""
    out: list[Row] = []
    for scan in part.task.kept:
        rows = []
        for row in part.rows.get(scan, []):
            known = part.known[int(row[ID])]
            rows.append([*row[:ID], str(known.identity), *row[ID + 1 : AGE], str(int(row[AGE]) + known.older)])
        out += sorted(rows, key=lambda row: int(row[ID]))
    return out


def _write_scans(part: _Part, folder: pathlib.Path) -> None:
    for scan in part.task.kept:
        for file in sorted(part.folder.glob(f"*/{scan:06d}.*")):  # stages, and what options of detect add
            if file.parent.name != "labels":
                _link(file, folder / file.parent.name / file.name)
        name = pathlib.Path("labels", f"{scan:06d}.label")
        same = all(part.known[int(row[ID])].identity == int(row[ID]) for row in part.rows.get(scan, []))
        if same:
            _link(part.folder / name, folder / name)
        else:
            part.renumbered(scan).tofile(folder / name)


def _link(source: pathlib.Path, place: pathlib.Path) -> None:
    try:
        os.link(source, place)
    except OSError:  # another file system, or one without links
        shutil.copyfile(source, place)


def _append_trajectory(lines: list[str], part: _Part) -> list[str]:
    """Both have the rows of the scans before the cut: they are joined at one of them."""
    own = part.lines("trajectory.txt")
    scans = len(part.lines("poses_kitti.txt"))
    pivot = own[len(own) * (part.task.kept.start - part.first) // scans - 1]
    if pivot not in lines:
        raise PartsDifferError(f"trajectory.txt of part {part.task.part}")
    return lines[: lines.index(pivot)] + own[own.index(pivot) :]


def _write_tables(parts: list[_Part], folder: pathlib.Path) -> None:
    kitti: list[str] = []
    trajectory = parts[0].lines("trajectory.txt")
    for part in parts:
        kept = part.task.kept
        kitti += part.lines("poses_kitti.txt")[kept.start - part.first : kept.stop - part.first]
        if part.task.part > 0:
            trajectory = _append_trajectory(trajectory, part)
    (folder / "poses_kitti.txt").write_text("".join(kitti))
    (folder / "trajectory.txt").write_text("".join(trajectory))
    shutil.copyfile(parts[0].folder / "config.yaml", folder / "config.yaml")
    rows = [parts[0].head, *(row for part in parts for row in _rows(part))]
    (folder / "objects.csv").write_text("".join(",".join(row) + "\n" for row in rows))


def _write_summary(parts: list[_Part], folder: pathlib.Path) -> None:
    """That of the first part with the counts of all."""
    summaries = [json.loads((part.folder / "summary.json").read_text()) for part in parts]
    counts: collections.Counter[str] = collections.Counter()
    result = Result(folder)
    for scan in result.scans:
        label = result.label(scan)
        counts["records"] += len(label)
        counts["points"] += int(np.count_nonzero(label))
        counts["dynamic_points"] += int(np.count_nonzero((label & 0xFFFF) == MOVING))
    ids = [row[ID] for part in parts for row in _rows(part)]
    summary = {name: value for name, value in summaries[0].items() if name not in ("timing", "input_output")}
    summary.update(
        recording_digest="",  # one run's is of all scans
        first_scan=0,
        selected_scans=len(result),
        scans=len(result),
        **counts,
        objects=len(ids),
        objects_over_time=len(set(ids)),
        peak_memory_mb=max(s["peak_memory_mb"] for s in summaries),
        parts=len(parts),
    )
    (folder / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")


def join(tasks: list[Task], folders: list[str], output: str) -> None:
    """Writes the result of one run into `output` from those of all parts of a drive. Raises PartsDifferError."""
    parts = [_Part(task, folder) for task, folder in zip(tasks, folders)]
    place = pathlib.Path(output)
    for name in {path.parent.name for path in parts[0].folder.glob("*/*")}:
        (place / name).mkdir(parents=True)
    last = 0
    for before, part in zip([None, *parts], parts):
        if before is not None:
            _recognise(before, part)
        last = _number_new_objects(part, last)
        _write_scans(part, place)
    _write_tables(parts, place)
    _write_summary(parts, place)

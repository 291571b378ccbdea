"""Sums the results of a plan: one table, one page. Counts are added; a ratio is formed of sums, never averaged."""

from __future__ import annotations

import collections
import csv
import io
import os
from typing import Any

from mapless.batch import storage, task as tasks
from mapless.batch.errors import ExitCode, cause
from mapless.batch.plan import Task

COLUMNS = (
    "id", "state", "cause", "message", "path", "format", "sensor", "scans", "points", "dynamic_points", "objects",
    "objects_over_time", "driven_m", "true_positives", "false_positives", "false_negatives", "seconds",
    "peak_memory_mb", "exit_code", "host", "hash", "version",
)  # fmt: skip
SUMMED = (
    "scans", "points", "dynamic_points", "objects", "objects_over_time", "driven_m", "true_positives",
    "false_positives", "false_negatives", "seconds",
)  # fmt: skip
TEXT = {"id", "state", "cause", "message", "path", "format", "sensor", "host", "hash", "version"}
REAL = {"driven_m", "seconds", "peak_memory_mb"}

Row = dict[str, Any]


def _is_started(task: Task, results: str) -> bool:
    return not storage.is_uri(results) and os.path.isdir(os.path.join(results, tasks.ATTEMPTS, task.id))


def row_of(task: Task, parts: list[Task], results: str) -> Row:
    """What has become of one drive: done, not trusted, failed, killed (it was started), or waiting."""
    row: Row = dict.fromkeys(COLUMNS)
    row.update(id=task.id, path=task.path, format=task.format, sensor=task.sensor, hash=task.hash, version=task.version)
    record = tasks.record_of(results, task)
    own = [] if record else [task, *(part for part in parts if part.parts > 1)]
    failure = next((failure for each in own if (failure := tasks.failure_of(results, each)) is not None), None)
    if record is not None:
        row.update({name: record[name] for name in COLUMNS if record.get(name) is not None})
        trusted = record["exit_code"] != ExitCode.NOT_TRUSTED
        row.update(state="done" if trusted else "not trusted", cause="", message=record.get("trouble", ""))
    elif failure is not None:
        code = int(failure["exit_code"])
        row.update(state="failed", cause=cause(code), message=failure["message"], exit_code=code, host=failure["host"])
    elif any(_is_started(each, results) for each in own):
        row.update(state="failed", cause="started and not ended (running, killed, or its node was lost)", message="")
    else:
        labelled = sum(tasks.record_of(results, part) is not None for part in own[1:])
        row.update(state="waiting", cause="", message=f"{labelled} of {len(own) - 1} parts are labelled" if labelled else "")
    return row


def sums_of(rows: list[Row]) -> dict[str, Any]:
    """Sums over all drives that are done, and ratios of these sums."""
    done = [row for row in rows if row["state"] in ("done", "not trusted")]
    sums: dict[str, Any] = {
        "drives": len(rows),
        "states": dict(sorted(collections.Counter(row["state"] for row in rows).items())),
        "causes": dict(collections.Counter(row["cause"] for row in rows if row["state"] == "failed").most_common()),
    }
    for name in SUMMED:
        values = [row[name] for row in done if row[name] is not None]
        sums[name] = round(sum(values), 3) if name in REAL else sum(values)
    km = sums["driven_m"] / 1000
    sums["objects_per_km"] = round(sums["objects_over_time"] / km, 3) if km > 0 else None
    sums["dynamic_share"] = sums["dynamic_points"] / sums["points"] if sums["points"] else None
    either = sums["true_positives"] + sums["false_positives"] + sums["false_negatives"]
    sums["iou"] = sums["true_positives"] / either if either else None
    return sums


def csv_text(rows: list[Row]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def parquet_bytes(rows: list[Row]) -> bytes | None:
    """None: pyarrow is not installed."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        return None
    kinds = {
        name: pyarrow.string() if name in TEXT else pyarrow.float64() if name in REAL else pyarrow.int64()
        for name in COLUMNS
    }
    table = pyarrow.Table.from_pylist(rows, schema=pyarrow.schema(list(kinds.items())))
    out = io.BytesIO()
    pyarrow.parquet.write_table(table, out)
    return out.getvalue()


def merge(plan: list[Task], results: str) -> tuple[list[Row], dict[str, Any]]:
    """Writes drives.csv, drives.parquet (with pyarrow), sums.json and index.html into the results."""
    from mapless.batch.page import page

    drives: dict[str, list[Task]] = {}
    for task in plan:
        drives.setdefault(task.whole().id, []).append(task)
    rows = [row_of(parts[0].whole(), parts, results) for parts in drives.values()]
    sums = sums_of(rows)
    storage.write_bytes(storage.joined(results, "drives.csv"), csv_text(rows).encode())
    parquet = parquet_bytes(rows)
    if parquet is not None:
        storage.write_bytes(storage.joined(results, "drives.parquet"), parquet)
    storage.write_json(storage.joined(results, "sums.json"), sums)
    storage.write_bytes(storage.joined(results, "index.html"), page(rows, sums, results).encode())
    return rows, sums

"""One page over all drives, without a network: what was found, what failed and why, what was slow."""

from __future__ import annotations

import html
import os
import urllib.parse
from typing import Any

from mapless.batch import storage

MAX_ROWS = 1000  # of all drives on the page; drives.csv has the rest
SLOWEST = 20
# Pages that verbs of mapless leave in the folder of a result, and their names on this page.
REPORTS = (
    ("viewer.html", "viewer"),
    ("evaluation.json", "evaluation"),
    ("summary.json", "summary"),
    ("objects.csv", "objects"),
)
STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 70rem; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; margin: .5rem 0 2rem; } th, td { padding: .2rem .8rem .2rem 0; text-align: left; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; } th { border-bottom: 1px solid #999; }
.failed { color: #b00; } .waiting { color: #777; } .not { color: #a60; }
@media (prefers-color-scheme: dark) { body { background: #181818; color: #ddd; } a { color: #8bf; } }
"""

Row = dict[str, Any]


def _number(value: Any) -> str:
    if value is None or value == "":
        return ""
    return f"{value:,}" if isinstance(value, int) else f"{value:,.3f}"


def _table(heads: list[str], rows: list[list[tuple[str, str]]]) -> str:
    """Cells: (class, HTML)."""
    if not rows:
        return "<p>none</p>"
    first = rows[0]
    head = "".join(f'<th class="{cell[0]}">{name}</th>' for name, cell in zip(heads, first))
    body = "".join("<tr>" + "".join(f'<td class="{c}">{text}</td>' for c, text in row) + "</tr>\n" for row in rows)
    return f"<table><tr>{head}</tr>\n{body}</table>"


def _text(value: Any) -> tuple[str, str]:
    return "", html.escape(str(value or ""))


def _links(row: Row, results: str) -> str:
    if row["state"] not in ("done", "not trusted"):
        return ""
    name = urllib.parse.quote(str(row["id"]))
    local = not storage.is_uri(results)
    shown = [
        f'<a href="{name}/{file}">{title}</a>'
        for file, title in REPORTS
        if file.endswith((".json", ".csv")) or (local and os.path.exists(os.path.join(results, str(row["id"]), file)))
    ]
    return " ".join(shown)


def _drive(row: Row, results: str) -> list[tuple[str, str]]:
    state = str(row["state"])
    km = (row["driven_m"] or 0) / 1000
    per_km = row["objects_over_time"] / km if km > 0 else None
    numbers = [row["scans"], row["points"], row["dynamic_points"], row["objects_over_time"], km or None, per_km]
    return [
        _text(row["id"]),
        (state.split()[0], html.escape(state)),
        *[("n", _number(value)) for value in numbers],
        ("n", _number(row["seconds"])),
        ("", _links(row, results)),
    ]


def page(rows: list[Row], sums: dict[str, Any], results: str) -> str:
    states = ", ".join(f"{count:,} {state}" for state, count in sums["states"].items())
    totals = [
        ("scans", sums["scans"]),
        ("points", sums["points"]),
        ("moving points", sums["dynamic_points"]),
        ("moving objects", sums["objects_over_time"]),
        ("driven [km]", sums["driven_m"] / 1000),
        ("moving objects per km", sums["objects_per_km"]),
        ("share of moving points (sum over sum)", sums["dynamic_share"]),
        ("IoU of moving points (sums; drives with truth)", sums["iou"]),
        ("time of all drives [s]", sums["seconds"]),
    ]
    failed = [row for row in rows if row["state"] == "failed"]
    slowest = sorted((r for r in rows if r["seconds"]), key=lambda r: -r["seconds"])[:SLOWEST]
    heads = ["drive", "state", "scans", "points", "moving", "objects", "km", "objects/km", "time [s]", ""]
    causes = [[_text(cause), ("n", _number(count))] for cause, count in sums["causes"].items()]
    messages = [[_text(row["id"]), _text(row["cause"]), _text(row["message"])] for row in failed[:MAX_ROWS]]
    cut = f"<p>The first {MAX_ROWS} of {len(rows):,}; drives.csv has all.</p>" if len(rows) > MAX_ROWS else ""
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>mapless: {sums["drives"]:,} drives</title>
<style>{STYLE}</style></head><body>
<h1>{sums["drives"]:,} drives</h1>
<p>{states}. All rows: <a href="drives.csv">drives.csv</a>; sums: <a href="sums.json">sums.json</a>.</p>
{_table(["sum over the drives that are done", ""], [[_text(n), ("n", _number(v))] for n, v in totals if v is not None])}
<h2>Failures by cause</h2>
{_table(["cause", "drives"], causes)}
{_table(["drive", "cause", "message"], messages) if messages else ""}
<h2>Slowest</h2>
{_table(heads, [_drive(row, results) for row in slowest])}
<h2>All drives</h2>
{cut}{_table(heads, [_drive(row, results) for row in rows[:MAX_ROWS]])}
</body></html>
"""

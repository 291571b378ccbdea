"""Parts of a long drive, labelled by tasks of their own; joining.py makes one result of them.

A part is labelled from WARM_UP scans before its first scan: references and tracks then are those of a run from the
start. The own vehicle is learnt from the first scan on. LOOK_AHEAD scans follow the last one: evidence from later
scans. The poses are given: along own odometry no two runs of different starts agree.
"""

from __future__ import annotations

from mapless.batch.plan import Task

# Four times the span of the reference scans (64), which themselves know what moved in their references. Measured from
# five starts: equal to the byte after 118 scans at most (docs/fleet.md).
WARM_UP = 256
COMPARED = 128  # more than the 5 s after which an object at rest loses its id, at up to 25 scans a second
LOOK_AHEAD = 100  # the largest forward_gap
FEWEST_SCANS = 2 * WARM_UP  # of a part


class PartsDifferError(RuntimeError):
    """The message says where."""


def first_scan(task: Task) -> int:
    return max(task.kept.start - WARM_UP, 0)


def range_flags(task: Task) -> list[str]:
    """Of `mapless detect`."""
    if task.parts == 1 or task.scans is None:
        return []
    end = min(task.kept.stop + LOOK_AHEAD, task.scans)
    first = str(first_scan(task))
    return ["--first", first, "--count", str(end - first_scan(task)), "--own-vehicle-from", "0"]

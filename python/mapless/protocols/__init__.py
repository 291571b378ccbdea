"""Public evaluations of moving points: which sequences and scans count, what the labels mean, and the figures.

    mapless evaluate --protocol semantickitti dataset/sequences predictions/sequences

docs/protocols.md says for each which files to download and which commands give the row.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import sys
from collections.abc import Iterator
from typing import Any, Protocol

from mapless._core import InputError
from mapless.protocols import semantic_kitti
from mapless.protocols.argoverse2 import Argoverse2
from mapless.protocols.counts import ComparedScan, Range, Totals
from mapless.protocols.doals import Doals
from mapless.protocols.nuscenes import NuScenes

NOT_DONE, DONE = 3, 0  # exit codes of the command


class Evaluation(Protocol):
    """A public evaluation."""

    @property
    def ranges(self) -> tuple[Range, ...]:
        """Rows by distance from the sensor."""

    def places(self, truth: pathlib.Path, predictions: pathlib.Path) -> dict[str, pathlib.Path]:
        """The folders in which the predictions of each sequence should be."""

    def compared(self, name: str, truth: pathlib.Path, predictions: pathlib.Path) -> Iterator[ComparedScan]:
        """The scans of a sequence that count. `predictions`: its place. Raises InputError."""


PROTOCOLS = ("semantickitti", "kitti-road-mos", "helimos", "doals", "av2", "nuscenes")


def protocol_of(name: str, annotations: pathlib.Path | None, masks: pathlib.Path | None) -> Evaluation:
    if name == "av2":
        if annotations is None or masks is None:
            raise InputError("--protocol av2: needs --annotations and --masks: docs/protocols.md says how they are made")
        return Argoverse2(annotations, masks)
    others: dict[str, Evaluation] = {
        "semantickitti": semantic_kitti.SEMANTIC_KITTI,
        "kitti-road-mos": semantic_kitti.KITTI_ROAD_MOS,
        "helimos": semantic_kitti.HELIMOS,
        "doals": Doals(),
        "nuscenes": NuScenes(),
    }
    return others[name]


def evaluate_protocol(
    name: str,
    truth: pathlib.Path,
    predictions: pathlib.Path,
    annotations: pathlib.Path | None = None,
    masks: pathlib.Path | None = None,
) -> dict[str, Any]:
    """`truth`: the data set, `predictions`: what mapless has written, in the layout that docs/protocols.md gives.
    Sequences without predictions are left out and named; there must be one with them."""
    protocol = protocol_of(name, annotations, masks)
    total, rows, left_out = Totals(protocol.ranges), {}, []
    for sequence, place in protocol.places(truth, predictions).items():
        if not place.is_dir():
            left_out.append(sequence)
            continue
        own = Totals(protocol.ranges)
        for scan in protocol.compared(sequence, truth, place):
            own.add(scan)
            total.add(scan)
        rows[sequence] = own.report()
    if not rows:
        raise InputError(f"{predictions}: no predictions of the sequences of {name}: {', '.join(left_out) or 'none there'}")
    return {"protocol": name, "left_out": left_out, "sequences": rows, "total": total.report()}


def table(report: dict[str, Any]) -> str:
    def text(value: float | None) -> str:
        return "-" if value is None else f"{100 * value:.1f}"

    width = max(10, *(len(name) + 2 for name in report["sequences"]))

    def row(name: str, r: dict[str, Any], scans: str, mean: str) -> str:
        figures = "".join(f"{text(r[key]):>11}" for key in ("iou", "precision", "recall"))
        return f"{name:<{width}}{scans:>7}{figures}{mean:>10}{r['tp']:>12}{r['fp']:>12}{r['fn']:>12}{r['tn']:>14}"

    head = ("sequence", "scans", "IoU [%]", "prec. [%]", "recall [%]", "mean IoU", "TP", "FP", "FN", "TN")
    lines = ["{:<{width}}{:>7}{:>11}{:>11}{:>11}{:>10}{:>12}{:>12}{:>12}{:>14}".format(*head, width=width)]
    for name, r in {**report["sequences"], "total": report["total"]}.items():
        lines.append(row(name, r, str(r["scans"]), text(r["mean_iou_of_scans"])))
    for name, r in (report["total"]["ranges_m"] or {}).items():
        lines.append(row(f"{name} m", r, "", ""))
    if report["left_out"]:
        lines.append(f"without predictions, left out: {', '.join(report['left_out'])}")
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="mapless evaluate", description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--protocol", required=True, choices=PROTOCOLS)
    parser.add_argument("--annotations", type=pathlib.Path, help="av2: folder of LOG/STAMP.feather")
    parser.add_argument("--masks", type=pathlib.Path, help="av2: archive of LOG/STAMP.feather, which points count")
    parser.add_argument("--json", action="store_true", help="the figures as JSON")
    parser.add_argument("truth", type=pathlib.Path, help="folder of the data set")
    parser.add_argument("predictions", type=pathlib.Path, help="folder of the predictions")
    given = parser.parse_args(arguments)
    try:
        report = evaluate_protocol(given.protocol, given.truth, given.predictions, given.annotations, given.masks)
    except (InputError, OSError, ValueError) as error:
        print(f"mapless: error: {error}", file=sys.stderr)
        return NOT_DONE
    print(json.dumps(report, indent=1) if given.json else table(report))
    return DONE

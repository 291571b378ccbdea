"""Argoverse 2, scene flow: a point moves if its flow beyond that of the own vehicle is 0.05 m in 0.1 s.

Only points within the box of 70 m, not on the ground and with valid flow count. The annotations are made by
av2.evaluation.scene_flow.make_annotation_files, one row for each point of the mask of a sweep."""

from __future__ import annotations

import io
import pathlib
import zipfile
from collections.abc import Iterator
from typing import Any

import numpy as np

from mapless._core import InputError
from mapless.protocols.counts import ComparedScan, Mask, Range, read_found
from mapless.readers.argoverse2 import LIDARS, read_table
from mapless.readers.scan_files import sorted_files


def column(table: Any, name: str) -> Mask:
    return np.asarray(table[name]).astype(bool)


class Argoverse2:
    """Predictions: LOG/up_lidar and LOG/down_lidar, results of `mapless detect`: a point moves if either says so."""

    ranges: tuple[Range, ...] = ()

    def __init__(self, annotations: pathlib.Path, masks: pathlib.Path) -> None:
        self._annotations = annotations
        try:
            self._masks = zipfile.ZipFile(masks)
        except (OSError, zipfile.BadZipFile) as error:
            raise InputError(f"{masks}: not the archive of masks: {error}") from None

    def places(self, truth: pathlib.Path, predictions: pathlib.Path) -> dict[str, pathlib.Path]:
        logs = sorted(folder.name for folder in self._annotations.iterdir() if folder.is_dir())
        return {log: predictions / log for log in logs}

    def compared(self, name: str, truth: pathlib.Path, predictions: pathlib.Path) -> Iterator[ComparedScan]:
        folder = truth / name / "sensors" / "lidar"
        numbers = {int(file.stem): k for k, file in enumerate(sorted_files(folder, ".feather"))}
        for file in sorted_files(self._annotations / name, ".feather"):
            if int(file.stem) not in numbers:
                raise InputError(f"{file}: {folder} has no sweep of this stamp")
            rows = read_table(file)
            mask = self._mask(f"{name}/{file.stem}.feather")
            found = self._found(predictions, numbers[int(file.stem)], len(mask))[mask]
            if len(found) != rows.num_rows:
                raise InputError(f"{file}: {rows.num_rows} rows: expected {len(found)}, as its mask has")
            used = column(rows, "is_valid") & column(rows, "is_close")
            yield ComparedScan(column(rows, "is_dynamic")[used], found[used])

    def _mask(self, name: str) -> Mask:
        from pyarrow import feather

        try:
            table = feather.read_table(io.BytesIO(self._masks.read(name)))
        except KeyError:
            raise InputError(f"{self._masks.filename}: no mask {name}") from None
        return column(table, table.column_names[0])

    @staticmethod
    def _found(predictions: pathlib.Path, scan: int, count: int) -> Mask:
        found = np.zeros(count, dtype=bool)
        for lidar in LIDARS:
            file = predictions / lidar / "labels" / f"{scan:06d}.label"
            if not file.is_file():
                raise InputError(f"{file}: missing: mapless detect LOG --lidar {lidar} -o {predictions / lidar}")
            found |= read_found(file, count, "the mask of its sweep")
        return found

"""Readers of the formats that Python has libraries for: one file each. A reader has

formats: tuple[str, ...]                       names for --format
fits(path) -> bool                             whether `path` looks like one of them, by its name or first bytes
open(path, options, format) -> CloudSource     `format`: one of them, or ""; raises InputError
"""

from __future__ import annotations

import pathlib
from typing import Protocol

from mapless._recording import CloudSource
from mapless.readers import argoverse2, bags, boreas, helimos, helipr, nuscenes, packets, point_folders
from mapless.readers.options import FIELDS, OPTIONS, Options

__all__ = ["FIELDS", "OPTIONS", "READERS", "Options", "Reader"]


class Reader(Protocol):
    @property
    def formats(self) -> tuple[str, ...]: ...

    def fits(self, path: pathlib.Path) -> bool: ...

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource: ...


READERS: tuple[Reader, ...] = (
    bags.BagReader(),
    packets.PacketReader(),
    argoverse2.ArgoverseReader(),
    boreas.BoreasReader(),
    helipr.HeliprReader(),
    nuscenes.NuScenesReader(),
    helimos.HelimosReader(),
    point_folders.PointFolderReader(),
)

"""All readers, in the order in which they are tried."""

from __future__ import annotations

import pathlib
from typing import Protocol

from mapless._recording import CloudSource
from mapless.readers import argoverse2, bags, boreas, helimos, helipr, nuscenes, packets, point_folders
from mapless.readers.options import Options


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

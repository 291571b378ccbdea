"""Readers of the formats that Python has libraries for: one file each. A reader has

formats: tuple[str, ...]                       names for --format
fits(path) -> bool                             whether `path` looks like one of them, by its name or first bytes
open(path, options) -> mapless.CloudSource     raises InputError
"""

from __future__ import annotations

import pathlib
from typing import Protocol

from mapless._recording import CloudSource
from mapless.readers import bags, packets
from mapless.readers.options import FIELDS, OPTIONS, Options

__all__ = ["FIELDS", "OPTIONS", "READERS", "Options", "Reader"]


class Reader(Protocol):
    @property
    def formats(self) -> tuple[str, ...]: ...

    def fits(self, path: pathlib.Path) -> bool: ...

    def open(self, path: pathlib.Path, options: Options) -> CloudSource: ...


READERS: tuple[Reader, ...] = (bags.BagReader(), packets.PacketReader())

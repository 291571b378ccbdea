"""Recordings of one file per scan: the scans' files and stamps, whatever is in them."""

from __future__ import annotations

import decimal
import pathlib
from collections.abc import Callable, Sequence

import numpy as np

from mapless._core import InputError
from mapless._fields import Array, Fields
from mapless._recording import CloudSource
from mapless.readers.clouds import fields_of_cloud, first_instant_ns

# Names of files that are times of the Unix epoch, by their number of digits: 2001 to 2286.
UNITS_OF_DIGITS = {19: 1, 16: 1_000, 13: 1_000_000}
# In int64 nanoseconds: the year 2096.
MOST_SECONDS = 4_000_000_000
# Labels of SemanticKITTI in their low 16 bits; the high ones number instances.
CLASS_BITS = 0xFFFF


def sorted_files(folder: pathlib.Path, suffix: str) -> list[pathlib.Path]:
    """By number where the names are numbers, else by name."""
    files = [file for file in folder.glob(f"*{suffix}") if file.is_file()]
    if all(file.name.removesuffix(suffix).isdigit() for file in files):
        return sorted(files, key=lambda file: int(file.name.removesuffix(suffix)))
    return sorted(files)


def seconds_to_ns(text: str, where: str) -> int:
    """Exactly: a float would hold times of the epoch to 0.2 us."""
    try:
        seconds = decimal.Decimal(text.strip())
        if -MOST_SECONDS <= seconds <= MOST_SECONDS:  # also: 1e999999999 would be a number of gigabytes
            return int(seconds.scaleb(9).to_integral_value())
    except (decimal.InvalidOperation, ValueError):
        pass
    raise InputError(f"{where}: {text.strip()[:40]!r}: not a time in seconds, at most {MOST_SECONDS}")


def stamps_of(files: Sequence[pathlib.Path], folder: pathlib.Path) -> tuple[list[int] | None, str]:
    """Stamp of each scan [ns] and where it comes from: times.txt, or the names; None: neither has one."""
    times = folder / "times.txt"
    if times.is_file():
        lines = times.read_text(encoding="utf-8", errors="replace").splitlines()
        if len(lines) != len(files):
            raise InputError(f"{times}: {len(lines)} lines: expected one for each of the {len(files)} scans")
        return [seconds_to_ns(text, f"{times}:{i + 1}") for i, text in enumerate(lines)], "from times.txt"
    names = [file.name.removesuffix(file.suffix) for file in files]
    if all(name.isdigit() and len(name) in UNITS_OF_DIGITS for name in names):
        return [int(name) * UNITS_OF_DIGITS[len(name)] for name in names], "from the names of the files"
    if all("." in name and name.replace(".", "", 1).isdigit() for name in names):
        return [seconds_to_ns(name, "name") for name in names], "from the names of the files, in seconds"
    return None, "from their points"


def read_rows(file: pathlib.Path, dtype: np.dtype[np.void], remedy: str) -> Array:
    """The packed rows of a file. `remedy`: what to do where it does not hold whole ones."""
    if not file.is_file():
        raise InputError(f"{file}: no such file; {remedy}")
    size = file.stat().st_size
    if size == 0 or size % dtype.itemsize != 0:
        names = ", ".join(dtype.names or ())
        raise InputError(f"{file}: {size} bytes: not whole points of {dtype.itemsize} bytes ({names}); {remedy}")
    rows: Array = np.fromfile(file, dtype)
    return rows


def read_semantic_kitti_labels(file: pathlib.Path) -> list[int] | None:
    if not file.is_file():
        return None
    labels: list[int] = (np.fromfile(file, dtype="<u4") & CLASS_BITS).tolist()
    return labels


class ScanFiles(CloudSource):
    """One file per scan. `read_cloud` gives its points by field."""

    def __init__(
        self,
        format: str,
        path: pathlib.Path,
        files: Sequence[pathlib.Path],
        read_cloud: Callable[[pathlib.Path], Array],
        stamps_ns: Sequence[int] | None,
        notes: Sequence[str],
        compensated_after_ns: int | None = None,
    ) -> None:
        """`stamps_ns`: what times of points count from, without them the start of the scan; None: times are absolute.
        `compensated_after_ns`: every point is moved to so long after the stamp; None: as measured. Raises InputError."""
        if not files:
            raise InputError(f"{path}: no scans in it")
        self.format = format
        self.path = str(path)
        self.files = list(files)
        self._read_cloud = read_cloud
        self._stamps_ns = stamps_ns
        self._compensated_after_ns = compensated_after_ns
        first, of_points = self._fields(0)
        self.notes = [*notes, *of_points]
        if stamps_ns is None and first_instant_ns(first) < UNITS_OF_DIGITS[13]:
            raise InputError(
                f"{path}: no time of each scan: put a times.txt with one line of seconds per scan beside the scans, or "
                "name the scans by their time in ns"
            )
        self.starts_ns = self._starts(first)

    def read(self, k: int) -> Fields:
        return self._fields(k)[0]

    def scan_name(self, k: int) -> str:
        return str(self.files[k]).encode("utf-8", "backslashreplace").decode()

    def _fields(self, k: int) -> tuple[Fields, list[str]]:
        stamp_ns = 0 if self._stamps_ns is None else self._stamps_ns[k]
        fields, notes = fields_of_cloud(self._read_cloud(self.files[k]), stamp_ns, 1, self.scan_name(k))
        if self._compensated_after_ns is not None:
            fields.compensated_to_ns = stamp_ns + self._compensated_after_ns
        return fields, notes

    def _starts(self, first: Fields) -> list[int]:
        """Of the first points. Where the stamps are known, they are as far from the first points as in scan 0."""
        if self._stamps_ns is None:
            return [first_instant_ns(self.read(k)) for k in range(len(self.files))]
        offset_ns = first_instant_ns(first) - first.stamp_ns
        return [stamp_ns + offset_ns for stamp_ns in self._stamps_ns]

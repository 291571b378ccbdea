"""Plain folders with one file of points per scan: .bin with named columns, .npy, .ply, .las and .laz."""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from functools import partial

import numpy as np

from mapless._core import InputError
from mapless._fields import Array
from mapless._recording import CloudSource
from mapless.readers.options import Options
from mapless.readers.ply import read_ply
from mapless.readers.scan_files import ScanFiles, read_rows, sorted_files, stamps_of

COLUMNS = "--columns x,y,z,intensity,ring,time"
# Bytes that a column may have: integers, unsigned integers, floating numbers.
TYPES = [f"{kind}{size}" for kind in "iu" for size in (1, 2, 4, 8)] + ["f4", "f8"]


def columns_of(text: str) -> np.dtype[np.void]:
    """ "x,y,z,ring:u2,time:f8": names with their types, float32 where there is none."""
    columns = []
    for column in text.split(","):
        name, _, kind = column.strip().partition(":")
        if not name or (kind and kind not in TYPES):
            raise InputError(f"--columns {text}: {column!r}: expected a name, or name:type with one of {', '.join(TYPES)}")
        columns.append((name, "<" + (kind or "f4")))
    names = [name for name, _ in columns]
    missing = [name for name in (*"xyz", *names) if names.count(name) != 1]
    if missing:
        raise InputError(f"--columns {text}: {missing[0]} is there {names.count(missing[0])} times: expected once")
    return np.dtype(columns)


def read_npy(file: pathlib.Path, columns: np.dtype[np.void] | None) -> Array:
    """(N, C) with the columns x, y, z first or as named, or a structured array."""
    try:
        array: Array = np.load(file, allow_pickle=False)
    except (ValueError, EOFError, OSError, MemoryError) as error:
        raise InputError(f"{file}: no array of NumPy: {error}") from None
    if array.dtype.names is not None:
        return array.reshape(-1)
    names = ("x", "y", "z") if columns is None else columns.names or ()
    if array.ndim != 2 or array.shape[1] < len(names) or (columns is not None and array.shape[1] != len(names)):
        raise InputError(f"{file}: shape {array.shape}: expected (N, {len(names)}), one column each for {', '.join(names)}")
    named = np.empty(len(array), [(name, array.dtype) for name in names])
    for i, name in enumerate(names):
        named[name] = array[:, i]
    return named


def read_las(file: pathlib.Path) -> Array:
    try:
        import laspy
    except ImportError:
        raise InputError(f"{file}: read by the package laspy: pip install 'mapless[las]'") from None
    try:
        las = laspy.read(file)
    except Exception as error:  # laspy and its decoders raise several kinds
        raise InputError(f"{file}: no file that laspy reads: {error}") from None
    given = {str(name): np.asarray(las[name]) for name in las.point_format.dimension_names if name not in "XYZ"}
    columns = {axis: np.asarray(las[axis], dtype=np.float64) for axis in "xyz"} | given
    cloud = np.empty(len(columns["x"]), [(name, numbers.dtype) for name, numbers in columns.items()])
    for name, numbers in columns.items():
        cloud[name] = numbers
    return cloud


class PointFolderReader:
    formats = ("bin", "npy", "ply", "las")

    def fits(self, path: pathlib.Path) -> bool:
        return path.is_dir() and self._suffix(path, "") is not None

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        suffix = self._suffix(path, format) if path.is_dir() else None
        if suffix is None:
            raise InputError(f"{path}: no folder with files of {' or '.join(self.formats)}, one per scan")
        columns = None if options.columns is None else columns_of(options.columns)
        folder = path if any(path.glob(f"*{suffix}")) else path / "velodyne"
        files = sorted_files(folder, suffix)
        if suffix == ".bin" and columns is None:
            raise InputError(f"{folder}: .bin files do not say what is in them: name their columns, as {COLUMNS}")
        stamps_ns, source = stamps_of(files, folder)
        if stamps_ns is None and folder != path:
            stamps_ns, source = stamps_of(files, path)
        notes = [f"scans: {suffix} files, one each; times of scans {source}"]
        if options.columns is None and suffix == ".npy":
            notes.append(f"points: the first three columns; {COLUMNS} names more of them")
        notes.append("points are taken as measured, not motion-compensated: the files do not say it")
        return ScanFiles(suffix[1:], path, files, self._reader_of(suffix, columns), stamps_ns, notes)

    def _suffix(self, path: pathlib.Path, format: str) -> str | None:
        suffixes = [f".{format}"] if format else [".bin", ".npy", ".ply", ".las", ".laz"]
        suffixes += [".laz"] if format == "las" else []
        found = [suffix for suffix in suffixes if any(path.glob(f"*{suffix}"))]
        if not found and format == "bin" and any(path.glob("velodyne/*.bin")):
            return ".bin"
        return found[0] if found else None

    def _reader_of(
        self, suffix: str, columns: np.dtype[np.void] | None
    ) -> Callable[[pathlib.Path], Array]:
        if suffix == ".npy":
            return partial(read_npy, columns=columns)
        if suffix in (".las", ".laz"):
            return read_las
        if suffix == ".ply":
            return read_ply
        assert columns is not None
        return partial(read_rows, dtype=columns, remedy="are these its columns?")

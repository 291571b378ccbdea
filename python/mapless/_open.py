"""Opens a recording of any format: the readers of Python first, then those of the C++ library."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Mapping

from mapless import _core
from mapless._recording import MOST_NS, UNEXPECTED, CloudSource, Recording
from mapless._text import not_utf8
from mapless.readers import FIELDS, Options
from mapless.readers.registry import READERS, Reader


def open(
    path: str | os.PathLike[str], *, format: str = "", sensor: str | os.PathLike[str] = "", **options: str | None
) -> Recording:
    """The recording in a file or folder.

    format: see docs/python.md; recognised from the files where it is not given.
    sensor: a named model or a calibration file; that of the recording where it is not given, else recovered.
    options: those of the command with _ for -, mapless.readers.OPTIONS: `topic="/points"`.

    Raises InputError naming the file, what is wrong with it, and what to do.
    """
    flags = {name: flag for flag, name in FIELDS.items()}
    unknown = next((name for name in options if name not in flags), None)
    if unknown is not None:
        raise TypeError(f"open() has no option {unknown}: expected one of {', '.join(flags)}")
    given = {flags[name]: text for name, text in options.items() if text is not None}
    if (wrong := not_utf8([os.fspath(path), os.fspath(sensor)])) is not None:
        raise _core.InputError(f"{wrong}: is not UTF-8; rename the file or folder")
    found = open_in_python(os.fspath(path), format, os.fspath(sensor), given)
    return Recording(found or _core.open_folder(os.fspath(path), format, os.fspath(sensor)))


def open_in_python(path: str, format: str, sensor: str, given: Mapping[str, str]) -> _core.Recording | None:
    """None: no format that Python reads. `given`: options of the readers by flag."""
    options = Options(sensor=sensor, **{FIELDS[flag]: text for flag, text in given.items()})
    if not format and options.columns is not None and not any(pathlib.Path(path).glob("*.npy")):
        format = "bin"
    for reader in READERS:
        if format in reader.formats or (not format and reader.fits(pathlib.Path(path))):
            source = opened(reader, pathlib.Path(path), options, format)
            return _core.recording_of(source, "" if source.recovers_sensor else sensor or source.sensor)
    return None


def opened(reader: Reader, path: pathlib.Path, options: Options, format: str) -> CloudSource:
    """What a reader does not expect in a damaged file, such as a column that is missing, is InputError too."""
    try:
        source = reader.open(path, options, format)
    except _core.Error:
        raise
    except UNEXPECTED as error:
        name = format or "/".join(reader.formats)
        raise _core.InputError(f"{path}: damaged, or not {name}: {type(error).__name__}: {error}") from error
    for k, start_ns in enumerate(source.starts_ns):
        if abs(start_ns) > MOST_NS:
            raise _core.InputError(
                f"{source.scan_name(k)}: start = {start_ns} ns: beyond 146 years from 1970; correct the times of its points"
            )
    return source

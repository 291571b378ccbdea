"""Finds the drives below some roots: folders and files that a reader of mapless takes."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import pathlib
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping

import mapless
from mapless import _core
from mapless._text import not_utf8
from mapless.batch import storage
from mapless.batch.errors import BatchError, ExitCode
from mapless.batch.plan import Refusal, absolute
from mapless.readers import FIELDS, bags
from mapless.readers.registry import READERS

ROSBAG2_KEY = b"rosbag2_bagfile_information"
# To distinguish copies of a drive from drives of the same sizes: the first bytes of some of the files.
COMPARED_FILES = 8
COMPARED_BYTES = 65536
# Format of a folder that cannot be looked into.
UNKNOWN = "unknown"


@dataclasses.dataclass
class Drive:
    path: str
    id: str
    format: str
    sensor: str | None = None
    scans: int | None = None
    poses: bool = False
    """whether the recording has poses of its own"""


def formats_of(path: pathlib.Path, holds: Callable[[pathlib.Path], bytes] = pathlib.Path.read_bytes) -> list[str]:
    """Formats whose files lie here. A folder of ROS 1 bags is not a drive: each of its bags is one."""
    if path.is_dir():
        metadata = path / "metadata.yaml"
        if metadata.is_file() and ROSBAG2_KEY in holds(metadata):
            return ["rosbag2"]
        if not_utf8([str(path)]) is not None:
            return [UNKNOWN]  # mapless.open refuses it by name
        return _core.recognised_formats(str(path))
    return [reader.formats[0] for reader in READERS if reader.fits(path)][:1]


def candidates(root: pathlib.Path) -> Iterator[pathlib.Path]:
    """Folders and files that look like drives, not below another drive."""
    if not root.exists():
        raise BatchError(f"{root}: no such file or folder", ExitCode.BAD_INPUT)
    if not root.is_dir() or formats_of(root):
        yield root
        return
    seen = set()
    for folder, below, files in os.walk(root, followlinks=True):
        real = os.path.realpath(folder)
        names = [] if real in seen else sorted(below)
        seen.add(real)
        found = [name for name in names if formats_of(pathlib.Path(folder, name))]
        yield from (pathlib.Path(folder, name) for name in found)
        below[:] = [name for name in names if name not in found and not name.startswith(".")]
        yield from (pathlib.Path(folder, name) for name in sorted(files) if formats_of(pathlib.Path(folder, name)))


def remote_candidates(root: str) -> Iterator[tuple[str, list[str]]]:
    """URI and formats of each drive below a URI, by names alone: those of a local tree of empty files."""
    system, path = storage.file_system(root)
    if not system.exists(path):
        raise BatchError(f"{root}: no such file or folder", ExitCode.BAD_INPUT)
    with tempfile.TemporaryDirectory(prefix="mapless-names-") as folder:
        tree = pathlib.Path(folder, os.path.basename(path))
        for name in system.find(path):
            file = tree if name == path else tree / os.path.relpath(name, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(system.cat_file(name) if file.name == "metadata.yaml" else b"")
        for found in candidates(tree):
            below = found.relative_to(tree).as_posix()
            yield (root if below == "." else storage.joined(root, below)), formats_of(found)


def id_of(path: str, root: str, prefix: str) -> str:
    """A name for the folder of its result: where the drive lies below its root."""
    below = os.path.relpath(path.split("://")[-1], root.split("://")[-1])
    parts = [prefix] if prefix else []
    parts.append(os.path.basename(path) if below == "." else below.replace("/", "."))
    return re.sub(r"[^\w.-]", "_", ".".join(parts)).lstrip(".")


def opened(drive: Drive, sensor: str, options: Mapping[str, str]) -> Drive:
    """Format, sensor, number of scans and whether it has poses. Of a bag the index is read, not its messages.

    `options`: of its reader, by flag. Raises mapless.InputError."""
    path = pathlib.Path(drive.path)
    if drive.format in bags.BagReader.formats:
        reader = bags.open_reader(path)
        topic = bags.choose_topic(reader, path, options.get("--topic"))
        scans = sum(c.msgcount for c in reader.connections if c.topic == topic)
        reader.close()
        form = "rosbag2" if path.is_dir() else bags.SUFFIXES[path.suffix]
        poses = "--pose-topic" in options
        return dataclasses.replace(drive, format=form, scans=scans, sensor=sensor or None, poses=poses)
    recording = mapless.open(drive.path, sensor=sensor, **{FIELDS[flag]: text for flag, text in options.items()})
    found = dataclasses.replace(drive, format=recording.format, scans=len(recording), sensor=recording.sensor)
    return dataclasses.replace(found, poses=recording.trajectory is not None)


def found_below(root: str, prefix: str, sensor: str, options: Mapping[str, str]) -> Iterator[Drive | Refusal]:
    if storage.is_uri(root):
        for uri, formats in remote_candidates(root):
            if len(formats) == 1:
                yield Drive(uri, id_of(uri, root, prefix), formats[0], sensor or None)
            else:
                yield Refusal(uri, f"it holds more than one recording: {', '.join(formats)}")
        return
    for path in candidates(pathlib.Path(root)):
        formats = formats_of(path) or [""]
        drive = Drive(str(path), id_of(str(path), root, prefix), formats[0])
        try:
            yield opened(drive, sensor, options)
        except (mapless.Error, OSError) as error:
            yield Refusal(str(path), str(error))


def sizes(path: str) -> str:
    listing = "".join(f"{name}\0{size}\n" for name, size, _ in storage.list_files(path))
    return hashlib.sha256(listing.encode()).hexdigest()


def sample(path: str) -> str:
    digest = hashlib.sha256()
    names = [name for name, _, _ in storage.list_files(path)]
    for name in names[:: max(1, len(names) // COMPARED_FILES)]:
        file = path if name == "." else os.path.join(path, name)
        with open(file, "rb") as content:
            digest.update(content.read(COMPARED_BYTES))
    return digest.hexdigest()


def without_duplicates(drives: list[Drive]) -> Iterator[Drive | Refusal]:
    """Refuses the second path to one drive, a copy of a drive, and a second drive with the same id."""
    by_id: dict[str, str] = {}
    by_path: dict[str, str] = {}
    by_sizes: dict[str, list[str]] = {}
    for drive in drives:
        local = not storage.is_uri(drive.path)
        real = os.path.realpath(drive.path) if local else drive.path
        if real in by_path:
            yield Refusal(drive.path, f"the same drive as {by_path[real]}")
            continue
        like = by_sizes.setdefault(sizes(drive.path), []) if local else []
        copied = next((other for other in like if sample(other) == sample(drive.path)), None)
        if copied is not None:
            yield Refusal(drive.path, f"a copy of {copied}")
            continue
        if drive.id in by_id:
            yield Refusal(drive.path, f"its id {drive.id} is that of {by_id[drive.id]}; rename one of them")
            continue
        by_id[drive.id] = by_path[real] = drive.path
        like.append(drive.path)
        yield drive


def find_drives(roots: list[str], sensor: str, options: Mapping[str, str]) -> tuple[list[Drive], list[Refusal]]:
    """Drives sorted by id, and what was refused. The ids of several roots begin with the name of their root."""
    found: list[Drive] = []
    refused: list[Refusal] = []
    for root in sorted({absolute(r) for r in roots}):
        prefix = os.path.basename(root) if len(roots) > 1 else ""
        for each in found_below(root, prefix, sensor, options):
            (found if isinstance(each, Drive) else refused).append(each)  # type: ignore[arg-type]
    kept: list[Drive] = []
    # Of several paths to one drive, the one that is no link is kept.
    for each in without_duplicates(sorted(found, key=lambda d: (os.path.islink(d.path), d.id, d.path))):
        (kept if isinstance(each, Drive) else refused).append(each)  # type: ignore[arg-type]
    return sorted(kept, key=lambda d: d.id), sorted(refused, key=lambda r: r.path)

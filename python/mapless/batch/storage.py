"""Where recordings and results lie: local paths, or URIs (s3://, gs://, ...) by fsspec."""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import shutil
import tempfile
from collections.abc import Iterator
from typing import Any

from mapless.batch.errors import BatchError, ExitCode


def is_uri(place: str) -> bool:
    return "://" in place


def joined(place: str, *names: str) -> str:
    return "/".join([place.rstrip("/"), *names]) if is_uri(place) else os.path.join(place, *names)


def _extra_of(uri: str) -> str:
    """What pip installs for the scheme of a URI."""
    scheme = uri.split("://")[0]
    return {"s3": "'mapless[s3]'", "gs": "'mapless[gs]'", "gcs": "'mapless[gs]'"}.get(scheme, "fsspec")


def file_system(uri: str) -> tuple[Any, str]:
    """The file system of a URI and the path of the URI in it. Credentials: as its fsspec implementation finds them."""
    try:
        import fsspec
    except ImportError:
        raise BatchError(f"{uri}: URIs need the package fsspec: pip install {_extra_of(uri)}") from None
    try:
        system, path = fsspec.core.url_to_fs(uri, use_listings_cache=False)
    except (ImportError, ValueError) as error:
        raise BatchError(f"{uri}: {error}; pip install {_extra_of(uri)}") from None
    return system, str(path)


def read_bytes(place: str) -> bytes | None:
    """None: there is no such file."""
    try:
        if is_uri(place):
            system, path = file_system(place)
            content: bytes = system.cat_file(path)
            return content
        return pathlib.Path(place).read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        return None


def read_json(place: str) -> dict[str, Any] | None:
    """None: there is no such file, or what is in it is not complete."""
    content = read_bytes(place)
    if content is None:
        return None
    try:
        value = json.loads(content)
    except (ValueError, RecursionError):
        return None
    return value if isinstance(value, dict) else None


def write_bytes(place: str, content: bytes) -> None:
    """Whole or not at all: beside and renamed; an object store shows an object once all of it is there."""
    if is_uri(place):
        system, path = file_system(place)
        system.pipe_file(path, content)
        return
    folder, name = os.path.split(os.path.abspath(place))
    os.makedirs(folder, exist_ok=True)
    descriptor, beside = tempfile.mkstemp(prefix=f".{name}.", dir=folder)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        os.chmod(beside, 0o644)
        os.replace(beside, place)
    except BaseException:
        os.unlink(beside)
        raise


def write_json(place: str, value: dict[str, Any]) -> None:
    write_bytes(place, (json.dumps(value, indent=2, sort_keys=True) + "\n").encode())


def remove(place: str) -> None:
    """A file or a folder, if it is there."""
    if is_uri(place):
        system, path = file_system(place)
        if system.exists(path):
            system.rm(path, recursive=True)
    elif os.path.isdir(place):
        shutil.rmtree(place)
    else:
        pathlib.Path(place).unlink(missing_ok=True)


def list_files(place: str) -> Iterator[tuple[str, int, str]]:
    """Relative name, size [bytes] and stamp of every file of a drive, sorted by name. The stamp is the time of the last
    change [ns], in an object store its entity tag."""
    if is_uri(place):
        system, path = file_system(place)
        found = system.find(path, detail=True)
        for name, facts in sorted(found.items()):
            stamp = facts.get("ETag") or facts.get("etag") or facts.get("mtime") or ""
            yield os.path.relpath(name, path), int(facts["size"]), str(stamp).strip('"')
    elif os.path.isdir(place):
        root = pathlib.Path(place)
        for file in sorted(p for p in root.rglob("*") if p.is_file()):
            status = file.stat()
            yield file.relative_to(root).as_posix(), status.st_size, str(status.st_mtime_ns)
    else:
        status = os.stat(place)
        yield ".", status.st_size, str(status.st_mtime_ns)


@contextlib.contextmanager
def local_copy(place: str, scratch: str | None) -> Iterator[str]:
    """A local path for a drive; that of a URI is fetched into a folder of `scratch` and removed at the end."""
    if not is_uri(place):
        yield place
        return
    system, path = file_system(place)
    with tempfile.TemporaryDirectory(prefix="mapless-drive-", dir=scratch) as folder:
        local = os.path.join(folder, os.path.basename(path.rstrip("/")))
        system.get(path, local, recursive=True)
        yield local


def publish(folder: str, place: str, last: str) -> None:
    """Moves a finished local folder to its place. In an object store the file `last` is written after all others."""
    if is_uri(place):
        system, path = file_system(place)
        remove(place)
        for name, _, _ in list_files(folder):
            if name != last:
                system.put_file(os.path.join(folder, name), f"{path}/{name}")
        system.put_file(os.path.join(folder, last), f"{path}/{last}")
        return
    os.makedirs(os.path.dirname(place), exist_ok=True)
    if os.path.isdir(place):
        outdated = folder + ".outdated"
        remove(outdated)
        os.rename(place, outdated)
        os.rename(folder, place)
        remove(outdated)
    else:
        os.rename(folder, place)


def require_place(results: str) -> None:
    """The folder of the results exists, or is made."""
    if not is_uri(results):
        try:
            os.makedirs(results, exist_ok=True)
        except OSError as error:
            raise BatchError(f"{results}: cannot be made: {error.strerror}", ExitCode.FAILURE) from None

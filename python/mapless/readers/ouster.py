"""Ouster captures (pcap with metadata, OSF), decoded by ouster-sdk."""

from __future__ import annotations

import json
import pathlib
import struct
import tempfile
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from mapless._core import InputError
from mapless._fields import FROM_STAMP, Array, Fields
from mapless._recording import CloudSource
from mapless.readers.sequential import SequentialScans


def import_sdk(path: str) -> Any:
    try:
        import ouster.sdk
        import ouster.sdk.core
    except ImportError:
        raise InputError(
            f"{path}: Ouster captures are read by the package ouster-sdk: pip install 'mapless[ouster]'"
        ) from None
    return ouster.sdk


# Sizes of packets and images: the SDK ends by a signal where one of them is 0.
MOST = {"columns_per_frame": 4096, "columns_per_packet": 128, "pixels_per_column": 512}
# Spread of the beams of any model [degrees]: less is in radians.
LEAST_SPREAD_DEG = 2.0


def require_metadata(file: pathlib.Path) -> None:
    """What the SDK takes from a metadata file and is not of an Ouster."""
    try:
        metadata = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{file}: no metadata of an Ouster: {error!s:.200}") from None
    if not isinstance(metadata, dict):
        raise InputError(f"{file}: no metadata of an Ouster: not an object of JSON")

    def part(*names: str) -> dict[str, Any]:
        """Of older firmware everything lies at the top."""
        found = next((metadata[name] for name in names if name in metadata), metadata)
        return found if isinstance(found, dict) else {}

    sizes = part("lidar_data_format", "data_format")
    for name, most in MOST.items():
        value = sizes.get(name, 1)
        if not isinstance(value, int) or not 1 <= value <= most:
            raise InputError(f"{file}: {name} = {value!r:.80}: expected 1 to {most}; give the metadata of this capture")
    columns = str(part("config_params").get("lidar_mode", "")).partition("x")[0]
    if columns.isdigit() and int(columns) != sizes.get("columns_per_frame", int(columns)):
        raise InputError(
            f"{file}: lidar_mode has {columns} columns, columns_per_frame = {sizes['columns_per_frame']}; give the metadata of "
            "this capture"
        )
    require_altitudes(file, part("beam_intrinsics").get("beam_altitude_angles"))


def require_altitudes(file: pathlib.Path, angles: Any) -> None:
    """In degrees, from the top down; all 0 where they are made up. What is no list of numbers the SDK refuses."""
    if not isinstance(angles, list) or not all(isinstance(angle, (int, float)) for angle in angles):
        return
    degrees = np.array(angles, dtype=np.float64)
    name = f"{file}: beam_altitude_angles"
    if not (np.abs(degrees) < 90).all():
        raise InputError(f"{name}: expected finite degrees between -90 and 90; give the metadata of this capture")
    if len(degrees) > 1 and degrees[0] < degrees[-1]:
        raise InputError(f"{name} = {degrees[0]:g} to {degrees[-1]:g}: expected from the top down; give them as the sensor does")
    if 0 < np.ptp(degrees) < LEAST_SPREAD_DEG:
        raise InputError(f"{name} = {degrees[0]:g} to {degrees[-1]:g}: expected degrees: are they radians?")


def closed_length(header: bytes) -> int:
    """Length of the file by the header of an OSF (a flatbuffer of one table); 0 where its writer has not closed it."""
    root = 4 + struct.unpack_from("<I", header, 4)[0]
    fields = root - struct.unpack_from("<i", header, root)[0]  # size of this, of the table; version, status, metadata, length
    size, place = struct.unpack_from("<H8xH", header, fields)
    length: int = struct.unpack_from("<Q", header, root + place)[0] if size >= 12 and place else 0
    return length


def require_whole_osf(path: pathlib.Path) -> None:
    """Blocks of an OSF (size, content, CRC-32) against their checksums: ouster-sdk ends by a signal where the last one is
    damaged, and leaves out the scans of others. A last block that its writer could not finish is left to the SDK."""
    at, length, size = 0, 0, path.stat().st_size
    with path.open("rb") as file:
        while at + 4 <= size:
            prefix = file.read(4)
            end = at + 8 + int.from_bytes(prefix, "little")
            if end > size:
                break
            block, checksum = prefix + file.read(end - at - 8), file.read(4)
            if at == 0 and block[8:12] != b"OSF$":
                return  # no OSF: the SDK says so
            if zlib.crc32(block) != int.from_bytes(checksum, "little"):
                raise InputError(f"{path}: damaged between bytes {at} and {end}; copy or record it again")
            if at == 0:
                length = closed_length(block)
            at = end
    if length and length != size:
        raise InputError(f"{path}: cut short: {size} of {length} bytes; copy it again")
    if length and at != size:
        raise InputError(f"{path}: damaged after byte {at}; copy or record it again")


def column_times_ns(timestamps: Array, valid: Array) -> Array:
    """Instant of each column; of a column whose packet was lost, between its neighbours."""
    columns = np.arange(len(timestamps))
    first = int(timestamps[valid].min())
    since = (timestamps[valid].astype(np.int64) - first).astype(np.float64)
    times: Array = first + np.round(np.interp(columns, columns[valid], since)).astype(np.int64)
    return times


class OusterCapture(CloudSource):
    """Each scan is the staggered image, beam by beam: (H x W,) records; a pixel without a return is one of them."""

    format = "ouster"

    def __init__(self, path: pathlib.Path, metadata: pathlib.Path | None) -> None:
        self.path = str(path)
        self._sdk = import_sdk(self.path)
        self._metadata = metadata
        if metadata is not None and not metadata.is_file():
            raise InputError(f"{metadata}: no such file")
        if metadata is not None:
            require_metadata(metadata)
        else:
            require_whole_osf(path)
        self._scans = SequentialScans(self._decoded)
        self.starts_ns = [fields.stamp_ns for fields in self._decoded()]
        if not self.starts_ns:
            raise InputError(f"{path}: no complete scan of an Ouster sensor; does {metadata} belong to it?")
        # Metadata of sensors with fewer beams than rows have made-up angles, 0 each; their beams are recovered.
        if self._beams_are_known:
            self.sensor = str(metadata or self._own_metadata(path))
        self.notes = [
            f"scans: of an {self._info.prod_line or 'Ouster'}, decoded by ouster-sdk"
            + ("" if metadata is None else f" with the metadata {metadata}"),
            "times: of columns, in ns; rings: rows of the image, from the top down",
            "points are taken as measured, in the sensor frame: packets are not motion-compensated",
        ]

    def read(self, k: int) -> Fields:
        return self._scans[k]

    def _own_metadata(self, path: pathlib.Path) -> pathlib.Path:
        """Those in an OSF, as the file that the model of the sensor is read from."""
        self._folder = tempfile.TemporaryDirectory(prefix="mapless-")
        file = pathlib.Path(self._folder.name) / f"{path.stem}.json"
        file.write_text(self._info.to_json_string(), encoding="utf-8")
        return file

    def _decoded(self) -> Iterator[Fields]:
        for frames in self._frames():
            frame = next((frame for frame in frames if frame is not None), None)
            if frame is not None and (np.asarray(frame.status) & 1).any():
                yield self._fields(frame)

    def _frames(self) -> Iterator[Any]:
        meta = {} if self._metadata is None else {"meta": [str(self._metadata)]}
        try:
            yield from self._sdk.open_source(self.path, **meta)
        except Exception as error:  # the SDK raises several kinds, RuntimeError for a file that is none among them
            given = "" if self._metadata is None else f" with the metadata {self._metadata}"
            raise InputError(f"{self.path}: no capture that ouster-sdk reads{given}: {error}") from None

    def _fields(self, frame: Any) -> Fields:
        info = self._info = frame.sensor_info
        self._beams_are_known = len(set(info.beam_altitude_angles)) == len(info.beam_altitude_angles)
        valid = (np.asarray(frame.status) & 1).astype(bool)
        times_ns = column_times_ns(np.asarray(frame.timestamp), valid)
        ranges = np.where(valid, frame.field("RANGE"), 0)
        points = self._sdk.core.XYZLut(info, False)(ranges).astype(np.float32).reshape(-1, 3)
        points[ranges.reshape(-1) == 0] = np.nan
        x, y, z = points.T
        ring = np.repeat(np.arange(frame.h, dtype=np.uint16), frame.w)
        time = np.tile(times_ns - times_ns[0], frame.h)
        return Fields(x, y, z, int(times_ns[0]), ring, time, "ns", FROM_STAMP, rows=frame.h)

"""PLY files: the vertices, ASCII or binary."""

from __future__ import annotations

import io
import pathlib

import numpy as np

from mapless._core import InputError
from mapless._fields import Array

TYPES = {
    **dict(char="i1", uchar="u1", short="i2", ushort="u2", int="i4", uint="u4", float="f4", double="f8"),
    **dict(int8="i1", uint8="u1", int16="i2", uint16="u2", int32="i4", uint32="u4", float32="f4", float64="f8"),
}
ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
# Tools put scalars into properties of these names: CloudCompare.
PREFIX = "scalar_"
# Comments may be long, but a header is not.
MOST_HEADER_BYTES = 65536


def read_ply(file: pathlib.Path) -> Array:
    """The element `vertex`, which must be the first: other elements before it would have to be read too."""
    data = file.read_bytes()
    order, count, properties, begin = _header(file, data[:MOST_HEADER_BYTES])
    dtype = np.dtype([(name, kind if order == "=" else order + kind) for name, kind in properties])
    if order == "=":
        # NumPy allocates `count` rows. A number and what separates it from the next take two bytes.
        if 2 * len(properties) * count > len(data) - begin + 1:
            raise InputError(f"{file}: cut off: {count} points of {len(properties)} numbers in {len(data) - begin} bytes")
        try:
            text = io.BytesIO(data[begin:])
            cloud: Array = np.atleast_1d(np.loadtxt(text, dtype=dtype, max_rows=count))
        except (ValueError, TypeError) as error:
            raise InputError(f"{file}: not {count} lines of {len(properties)} numbers: {error}") from None
    else:
        cloud = np.frombuffer(data[begin : begin + count * dtype.itemsize], np.uint8)
        cloud = cloud[: len(cloud) // dtype.itemsize * dtype.itemsize].view(dtype)
    if len(cloud) != count:
        raise InputError(f"{file}: cut off: {len(cloud)} of {count} points")
    return cloud


def _header(file: pathlib.Path, data: bytes) -> tuple[str, int, list[tuple[str, str]], int]:
    """Byte order, number of vertices, their properties, and where the data begin."""
    end = data.find(b"end_header")
    begin = data.find(b"\n", end) + 1
    if not data.startswith(b"ply") or end < 0 or begin == 0:
        raise InputError(f"{file}: no PLY file: no header")
    order, count, element = "", -1, ""
    properties: list[tuple[str, str]] = []
    for line in data[:end].decode("ascii", "replace").splitlines():
        match line.split():
            case ["format", name, _]:
                order = ORDERS.get(name, "")
            case ["element", "vertex", number] if number.isdigit() and element == "":
                element, count = "vertex", int(number)
            case ["element", *_] if element == "":
                raise InputError(f"{file}: {line.strip()}: expected the element vertex first")
            case ["element", *_]:
                element = "other"
            case ["property", kind, name] if element == "vertex" and kind in TYPES:
                properties.append((name.removeprefix(PREFIX), TYPES[kind]))
            case ["property", *_] if element == "vertex":
                raise InputError(f"{file}: {line.strip()}: expected a number as every property of vertex")
    if not order or count <= 0 or not properties:
        raise InputError(f"{file}: {'no points' if order else 'no format that is known'} in its header")
    names = [name for name, _ in properties]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise InputError(f"{file}: property {twice}: is there twice")
    return order, count, properties, begin

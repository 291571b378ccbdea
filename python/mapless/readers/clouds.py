"""Clouds of points with named fields, of a driver or a dataset: which field is what, and what cannot work."""

from __future__ import annotations

import numpy as np

from mapless._core import InputError
from mapless._fields import (
    RING_NAMES,
    TIME_NAMES,
    Array,
    Fields,
    TimeUnit,
    first_name,
    has_epoch,
    require_metres,
    unit_of,
)

# A turn at 5 to 50 Hz lasts this long in microseconds; as nanoseconds it would be a five-thousandth of a turn.
MICROSECONDS_OF_A_TURN = (20_000, 200_000)
NS_PER_S = 1_000_000_000


def refuse_unsupported(names: tuple[str, ...], name: str) -> None:
    missing = [axis for axis in "xyz" if axis not in names]
    if missing:
        raise InputError(f"{name}: no field {missing[0]}; its fields are {', '.join(names)}")
    if "tag" in names and "line" in names:
        raise InputError(
            f"{name}: fields tag and line: a Livox cloud, whose pattern does not repeat; mapless needs a spinning lidar"
        )


def fields_of_cloud(cloud: Array, stamp_ns: int, height: int, name: str) -> tuple[Fields, list[str]]:
    """The fields and where ring and time come from, one line each. `stamp_ns`: of the header."""
    names = cloud.dtype.names or ()
    refuse_unsupported(names, name)
    x, y, z = (_numbers(cloud, axis, name) for axis in "xyz")
    try:
        require_metres(x, y, z)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    ring_name, time_name = first_name(names, RING_NAMES), first_name(names, TIME_NAMES)
    ring = None if ring_name is None else _numbers(cloud, ring_name, name)
    time, unit, note = _time_of(cloud, time_name, np.isfinite(x) & ((x != 0) | (y != 0)), name)
    rings = "recovered: the cloud has no field for it" if ring_name is None else f"of points from the field {ring_name}"
    rows = height if height > 1 else 1
    return Fields(x, y, z, stamp_ns, ring, time, unit, rows=rows), [f"times: {note}", f"rings: {rings}"]


def first_instant_ns(fields: Fields) -> int:
    """Of the earliest return."""
    if fields.time is None:
        return fields.stamp_ns
    time = fields.time[np.isfinite(fields.x) & ((fields.x != 0) | (fields.y != 0))]
    if time.size == 0:
        return fields.stamp_ns
    per_unit = {"s": NS_PER_S, "ms": 1_000_000, "us": 1_000, "ns": 1}[fields.time_unit]
    first = time.min()
    first_ns = round(float(first) * per_unit) if time.dtype.kind == "f" else int(first) * per_unit
    return first_ns if has_epoch(time, fields.time_unit) else fields.stamp_ns + first_ns


def _numbers(cloud: Array, field: str, name: str) -> Array:
    numbers: Array = cloud[field]
    if numbers.dtype.kind not in "iuf" or numbers.dtype.itemsize > 8 or numbers.dtype == np.float16 or numbers.ndim != 1:
        size = "" if numbers.ndim == 1 else f", {numbers.shape[1:]} of them a point"
        raise InputError(
            f"{name}: field {field} = {numbers.dtype}{size}: not a number per point; give integers, float32 or float64"
        )
    return _native(numbers)


def _native(numbers: Array) -> Array:
    return numbers if numbers.dtype.isnative else numbers.astype(numbers.dtype.newbyteorder("="))


def _time_of(cloud: Array, name: str | None, hit: Array, where: str) -> tuple[Array | None, TimeUnit, str]:
    recovered = "of points recovered from their azimuths"
    if name is None:
        return None, "s", f"{recovered}: the cloud has no field for it"
    time = _numbers(cloud, name, where)
    used = time[hit]
    if used.size == 0:  # the scans before and after it have times
        return time, unit_of(time), f"of points from the field {name} ({time.dtype})"
    wrong = np.flatnonzero(hit & ~np.isfinite(time))
    if wrong.size:
        raise InputError(
            f"{where}: point {wrong[0]} {name} = {time[wrong[0]]}: not a time; correct it, or leave the field out"
        )
    if used.min() == used.max():
        return None, "s", f"{recovered}: the driver has left the field {name} empty"
    unit = unit_of(used)
    if time.dtype.kind != "f" and MICROSECONDS_OF_A_TURN[0] <= int(used.max()) - int(used.min()) <= (
        MICROSECONDS_OF_A_TURN[1]
    ):
        unit = "us"
    reference = "of the Unix epoch" if has_epoch(used, unit) else "since the stamp of the message"
    return time, unit, f"of points from the field {name} ({time.dtype}) in {unit} {reference}"

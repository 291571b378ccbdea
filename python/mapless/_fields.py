"""Turns arrays of points, rings and times into what the C++ library reads, without a copy, or says what is wrong."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from mapless._core import InputError

Array = npt.NDArray[Any]
TimeUnit = Literal["s", "ms", "us", "ns"]
TIME_UNITS: dict[str, int] = {"s": 0, "ms": 1, "us": 2, "ns": 3}  # TimeUnit of lidar_scan.hpp
FROM_STAMP, AUTOMATIC = 0, 2  # TimeReference of lidar_scan.hpp

# Names that drivers and datasets give to the laser and to the instant of a point.
RING_NAMES = ("ring", "channel", "laser_number", "laser_id", "laser", "line")
TIME_NAMES = ("t", "time", "timestamp", "timestamps", "time_stamp", "stamps", "offset_time", "offset_ns", "gps_time")

# A lidar sees 300 m at most: a median range beyond this is in millimetres.
MOST_MEDIAN_RANGE_M = 400.0
# Every so-and-so-many-th point is enough for a median.
RANGE_SAMPLES = 2000
# Floating times of the Unix epoch, 1973 to 5138, by the unit they must have: 1e11 s is far in the future, and 1e11 ms
# in the past.
EPOCH_UNITS: tuple[tuple[float, TimeUnit], ...] = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"))
# Between the first and the last point of a scan, which lasts a few hundredths of a second to half a second: what is
# more than so much is in the unit beside it. A scan of 10 ms in us and one of 10 s in ms are both 1e4; neither is.
SPAN_UNITS: tuple[tuple[float, TimeUnit], ...] = ((1e6, "ns"), (2e3, "us"), (5.0, "ms"))


@dataclasses.dataclass
class Fields:
    """The fields of one cloud: PointFields of the C++ library, with one number per point each."""

    x: Array
    y: Array
    z: Array
    stamp_ns: int
    ring: Array | None = None
    time: Array | None = None
    time_unit: TimeUnit = "s"
    time_reference: int = AUTOMATIC
    rows: int = 1
    compensated_to_ns: int | None = None

    def as_tuple(self) -> tuple[Any, ...]:
        return (
            *(self.x, self.y, self.z, self.ring, self.time),
            *(TIME_UNITS[self.time_unit], self.time_reference, self.rows, self.stamp_ns, self.compensated_to_ns),
        )

    def copied(self) -> Fields:
        ring = None if self.ring is None else np.array(self.ring)
        time = None if self.time is None else np.array(self.time)
        return dataclasses.replace(
            self, x=np.array(self.x), y=np.array(self.y), z=np.array(self.z), ring=ring, time=time
        )


def fields_of(
    points: npt.ArrayLike,
    *,
    stamp_ns: int | None,
    time: npt.ArrayLike | None = None,
    ring: npt.ArrayLike | None = None,
    time_unit: TimeUnit | None = None,
    rows: int | None = None,
    compensated_to_ns: int | None = None,
) -> Fields:
    """See OnlineDetector.push, whose arguments these are."""
    array = np.asarray(points)
    if array.dtype.names is not None:
        x, y, z, own_ring, own_time, own_rows = _structured(array)
    else:
        (x, y, z), own_rows = _columns(array)
        own_ring = own_time = None
    count = len(x)
    require_metres(x, y, z)
    ring_array = own_ring if ring is None else _numbers(ring, "ring", "the number of the laser", count)
    time_array = own_time if time is None else _numbers(time, "time", "an instant", count)
    if time_unit is not None and time_unit not in TIME_UNITS:
        raise InputError(f"time_unit = {time_unit!r}: expected one of {', '.join(TIME_UNITS)}")
    unit = time_unit or (unit_of(time_array) if time_array is not None else "s")
    return Fields(
        *(x, y, z, _stamp(stamp_ns, time_array, unit), ring_array, time_array, unit, AUTOMATIC),
        rows=own_rows if rows is None else rows,
        compensated_to_ns=None if compensated_to_ns is None else _whole(compensated_to_ns, "compensated_to_ns"),
    )


def unit_of(time: Array) -> TimeUnit:
    """Integers are nanoseconds; floating numbers seconds, unless they are of the Unix epoch or last too long for it."""
    if time.dtype.kind != "f":
        return "ns"
    finite = time[np.isfinite(time)]
    if finite.size == 0:
        return "s"
    least, span = float(finite.min()), float(finite.max()) - float(finite.min())
    since_start: TimeUnit = next((unit for bound, unit in SPAN_UNITS if span >= bound), "s")
    return next((unit for bound, unit in EPOCH_UNITS if least >= bound), since_start)


def first_name(names: Sequence[str], wanted: Sequence[str]) -> str | None:
    return next((name for name in wanted if name in names), None)


def require_metres(x: Array, y: Array, z: Array) -> None:
    step = max(1, len(x) // RANGE_SAMPLES)
    ranges = np.sqrt(sum(axis[::step].astype(np.float64) ** 2 for axis in (x, y, z)))
    ranges = ranges[np.isfinite(ranges) & (ranges > 0)]
    if ranges.size and np.median(ranges) > MOST_MEDIAN_RANGE_M:
        raise InputError(
            f"points: half of them are farther than {np.median(ranges):.0f} m: are they millimetres? give metres"
        )


def _structured(array: Array) -> tuple[Array, Array, Array, Array | None, Array | None, int]:
    names = array.dtype.names or ()
    missing = [name for name in "xyz" if name not in names]
    if missing:
        raise InputError(f"points: no field {missing[0]}; its fields are {', '.join(names)}")
    if array.ndim > 2:
        raise InputError(f"points: shape {array.shape}: expected (N,) or (H, W) for a structured array")
    rows = array.shape[0] if array.ndim == 2 else 1
    flat = array.reshape(-1)
    x, y, z = (_axis(flat[name], name) for name in "xyz")
    ring_name, time_name = first_name(names, RING_NAMES), first_name(names, TIME_NAMES)
    ring = None if ring_name is None else _numbers(flat[ring_name], ring_name, "the number of the laser", len(x))
    time = None if time_name is None else _numbers(flat[time_name], time_name, "an instant", len(x))
    return x, y, z, ring, time, rows


def _columns(array: Array) -> tuple[tuple[Array, Array, Array], int]:
    if array.ndim not in (2, 3) or array.shape[-1] < 3:
        raise InputError(
            f"points: shape {array.shape}: expected (N, 3) or wider, (H, W, 3) for an organised cloud, or a "
            "structured array with the fields x, y, z"
        )
    rows = array.shape[0] if array.ndim == 3 else 1
    flat = array.reshape(-1, array.shape[-1])
    return (_axis(flat[:, 0], "x"), _axis(flat[:, 1], "y"), _axis(flat[:, 2], "z")), rows


def _axis(numbers: Array, name: str) -> Array:
    if numbers.dtype.kind != "f" or numbers.dtype.itemsize not in (4, 8):
        raise InputError(f"points: {name} is {numbers.dtype}: expected float32 or float64, in metres")
    return _readable(numbers)


def _numbers(values: npt.ArrayLike, name: str, meaning: str, count: int) -> Array:
    numbers = np.asarray(values)
    if numbers.dtype.kind not in "iuf" or numbers.dtype.itemsize > 8 or numbers.dtype == np.float16:
        raise InputError(f"{name}: {numbers.dtype}: expected {meaning} as integers, float32 or float64")
    if numbers.ndim != 1:
        numbers = numbers.reshape(-1)
    if len(numbers) != count:
        raise InputError(f"{name}: {len(numbers)} numbers: expected one per point, {count}")
    return _readable(numbers)


def _readable(numbers: Array) -> Array:
    if not numbers.dtype.isnative:
        return numbers.astype(numbers.dtype.newbyteorder("="))
    return np.ascontiguousarray(numbers) if numbers.strides[0] < 0 else numbers


def _whole(value: int, name: str) -> int:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
        raise InputError(f"{name} = {value!r}: expected whole nanoseconds as an integer; a float cannot hold them")
    return int(value)


def _stamp(stamp_ns: int | None, time: Array | None, unit: TimeUnit) -> int:
    if stamp_ns is not None:
        return _whole(stamp_ns, "stamp_ns")
    if time is not None and has_epoch(time, unit):
        return 0  # not used
    raise InputError("stamp_ns: missing: expected the stamp of the scan in ns, for the points have no absolute times")


def has_epoch(time: Array, unit: TimeUnit) -> bool:
    """As TimeReference::automatic decides: beyond eleven days."""
    per_second = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[unit]
    finite = time[np.isfinite(time)] if time.dtype.kind == "f" else time
    return finite.size > 0 and not math.isnan(least := float(finite.min())) and least / per_second >= 1e6

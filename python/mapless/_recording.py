"""Scans and recordings."""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from mapless import _core
from mapless._fields import Fields

# What libraries and NumPy raise for contents that a reader has not thought of.
UNEXPECTED = (LookupError, ValueError, TypeError, AttributeError, ArithmeticError, MemoryError, RecursionError, EOFError)
# Beyond these an instant is not a time in int64 nanoseconds; half of what they hold, as differences are taken.
MOST_NS = 2**62


@dataclasses.dataclass
class Scan:
    """One turn of the sensor: N records in the order of the recording, those without a return NaN."""

    points: npt.NDArray[Any]
    """(N, 3) float32 [m] in the sensor frame, as measured"""
    stamp_ns: int
    """what time_s counts from; without time_s, the start of the scan"""
    time_s: npt.NDArray[np.float64] | None = None
    """(N,) instant of each point since stamp_ns [s]; None: the recording has none"""
    ring: npt.NDArray[Any] | None = None
    """(N,) number of the laser of each point; None: the recording has none"""
    measured: _core.MeasuredScan | None = dataclasses.field(default=None, repr=False)
    """the same as the recording holds it, with columns and empty rays, which push() takes unchanged"""

    def __len__(self) -> int:
        return len(self.points)


class Measurement(NamedTuple):
    """What another sensor measured of the motion of the lidar at one instant."""

    stamp_ns: int
    """on the clock of the scans"""
    angular_velocity: tuple[float, float, float] | None
    """about the axes of the lidar [rad/s]; None: a speed"""
    speed: float = 0.0
    """norm of the velocity of the lidar [m/s], 0 or more"""


class CloudSource(abc.ABC):
    """A recording that Python reads: the interface of a reader. The C++ library recovers what the clouds do not have.

    The attributes are set by the constructor; `read_fields` may be called from several threads.
    """

    format: str
    path: str
    starts_ns: list[int]
    """instant of the first point of each scan, increasing"""
    notes: list[str]
    """where times, rings and poses come from, one line each"""
    trajectory: _core.Trajectory | None = None
    """its own poses of the sensor"""
    measurements: Sequence[Measurement] = ()
    """what its other sensors measured of the motion, for the odometry"""
    sensor: str = ""
    """a named model or a calibration file, where the recording says which; empty: recovered from the points"""
    recovers_sensor: bool = False
    """its points do not lie on the beams of the calibration file that was given, which the reader has used: the sensor is
    recovered from the points"""

    @abc.abstractmethod
    def read(self, k: int) -> Fields:
        """The fields of scan k."""

    def scan_name(self, k: int) -> str:
        """For messages."""
        return f"{self.path} scan {k}"

    def read_labels(self, k: int) -> list[int] | None:
        """True labels of scan k, one per point (251 moving, 9 static, 0 unknown); None: it has none."""
        return None

    def read_fields(self, k: int) -> tuple[Any, ...]:
        """What a reader does not expect in a damaged scan is InputError that names it, too."""
        try:
            return self.read(k).as_tuple()
        except _core.Error:
            raise
        except UNEXPECTED as error:
            raise _core.InputError(f"{self.scan_name(k)}: damaged: {type(error).__name__}: {error}") from error


class Recording:
    """A recording of any format: a sequence of scans. Made by mapless.open."""

    def __init__(self, core: _core.Recording) -> None:
        self.core = core

    @property
    def format(self) -> str:
        return self.core.format

    @property
    def sensor(self) -> str:
        """Name of the sensor model."""
        return self.core.sensor

    @property
    def notes(self) -> list[str]:
        """Where sensor, times and poses come from."""
        return self.core.notes

    @property
    def trajectory(self) -> _core.Trajectory | None:
        """The poses that the recording has."""
        return self.core.trajectory

    @property
    def measurements(self) -> list[Measurement]:
        """What its other sensors measured of the motion, for OnlineDetector.add_measurements."""
        return [Measurement(*one) for one in self.core.measurements]

    def __len__(self) -> int:
        return len(self.core)

    def labels(self, k: int) -> npt.NDArray[np.uint32] | None:
        """True labels of scan k, if the recording has any."""
        return self.core.labels(k)

    @overload
    def __getitem__(self, k: int) -> Scan: ...

    @overload
    def __getitem__(self, k: slice) -> list[Scan]: ...

    def __getitem__(self, k: int | slice) -> Scan | list[Scan]:
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        index = k + len(self) if k < 0 else k
        if not 0 <= index < len(self):
            raise IndexError(f"scan {k}: the recording has {len(self)} scans")
        measured = self.core.read(index)
        return Scan(measured.points(), measured.stamp_ns, measured.time_s(), measured.ring(), measured)

    def __iter__(self) -> Iterator[Scan]:
        return (self[k] for k in range(len(self)))

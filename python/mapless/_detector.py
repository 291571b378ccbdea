"""The whole method, online: points in, labels out."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from mapless import _core
from mapless._fields import TimeUnit, fields_of
from mapless._recording import Measurement, Scan

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mapless._parameters import Parameters


def parameters() -> dict[str, str]:
    """Every parameter of OnlineDetector by its key ("voting.references") with its meaning and unit."""
    return {key: f"{text} [{unit}]" if unit else text for key, _, unit, _, text in _core.parameter_table()}


class OnlineDetector:
    """Scans in, labels out: `mapless::OnlineDetector`, to which it adds the conversion of arrays.

    sensor: a name ("VLP-16"), a calibration file, or None: recovered from the first eight scans, with which the
        first labels then come.
    rotation_rate_hz: of the sensor, where it is not the usual one (10 Hz).
    profile: "default", or "paper" for the method as published.
    Any parameter by its name: `forward_gap=0`, `voting={"references": 8}`, `odometry={"gate_m": 0.4}`; mapless.parameters()
        lists them.

    One call at a time; the GIL is released in each. Detectors in several threads run side by side.
    """

    def __init__(
        self,
        sensor: str | os.PathLike[str] | None = None,
        *,
        rotation_rate_hz: float | None = None,
        profile: str = "default",
        **parameters: Unpack[Parameters],
    ) -> None:
        name = "" if sensor is None else os.fspath(sensor)
        self._core = _core.Detector(name, rotation_rate_hz, profile, _settings(parameters))
        self._warned_of: set[str] = set()

    def push(
        self,
        points: Scan | npt.ArrayLike,
        *,
        time: npt.ArrayLike | None = None,
        ring: npt.ArrayLike | None = None,
        stamp_ns: int | None = None,
        trajectory: _core.Trajectory | None = None,
        time_unit: TimeUnit | None = None,
        rows: int | None = None,
        compensated_to_ns: int | None = None,
    ) -> list[_core.LabelledScan]:
        """Takes the next scan and returns the scans that are labelled now: none, one, or at the start several.

        points: a Scan of a recording; or (N, 3) float32 or float64, or wider, in metres in the sensor frame, as
            measured; or (H, W, 3), organised; or a structured array with fields x, y, z, and ring and time by their
            usual names. A row with NaN is a ray without a return. Not copied.
        time: (N,) instant of each point, since stamp_ns or of the Unix epoch, whichever fits. Integers are
            nanoseconds, floating numbers seconds, unless time_unit says "s", "ms", "us" or "ns". None: recovered
            from the azimuths.
        ring: (N,) number of the laser of each point, from 0, counted from the top or the bottom. None: recovered.
        stamp_ns: stamp of the scan; not needed where times are absolute.
        trajectory: poses that cover the scan, in place of the own odometry; with every scan or with none.
        rows: rows of an organised cloud that is given flat.
        compensated_to_ns: the instant to which another system has already moved the points; needs `trajectory`.

        Raises InputError naming the argument and what was expected. The scan is then not taken. Warns, once for each
        mistake, where scans contradict the sensor or each other (docs/reliability.md, "The self-check").
        """
        if isinstance(points, Scan):
            if points.measured is not None:
                return self._warned(self._core.push_scan(points.measured, trajectory))
            time, ring, stamp_ns, points = points.time_s, points.ring, points.stamp_ns, points.points
        fields = fields_of(
            points,
            stamp_ns=stamp_ns,
            time=time,
            ring=ring,
            time_unit=time_unit,
            rows=rows,
            compensated_to_ns=compensated_to_ns,
        )
        if self._core.keeps_clouds:
            fields = fields.copied()
        return self._warned(self._core.push_cloud(fields.as_tuple(), trajectory))

    def add_measurements(self, measurements: Iterable[Measurement]) -> None:
        """What other sensors measure of the motion of the lidar, for the own odometry: before the scan is pushed during
        which it is measured. Without effect where poses are given. Recording.measurements has those of a bag."""
        for one in measurements:
            self._core.add_measurement(tuple(one))

    def flush(self) -> list[_core.LabelledScan]:
        """Labels the scans that are still held back, with what is known now. The detector can go on."""
        return self._warned(self._core.flush())

    def _warned(self, found: list[_core.LabelledScan]) -> list[_core.LabelledScan]:
        for line in self._core.take_doubts():
            mistake = line.partition(":")[0]  # "doubtful beams"
            if mistake not in self._warned_of:
                self._warned_of.add(mistake)
                warnings.warn(f"mapless: {line}", RuntimeWarning, stacklevel=3)
        return found

    @property
    def latency(self) -> int:
        """Scans between a scan and its labels, once started."""
        return self._core.latency

    @property
    def sensor(self) -> str:
        """Name of the sensor model; empty until it is recovered."""
        return self._core.sensor

    @property
    def notes(self) -> list[str]:
        """How the sensor was recovered."""
        return self._core.notes

    @property
    def odometry_trouble(self) -> str:
        """The problems that odometry has met so far, in one line; empty: none."""
        return self._core.odometry_trouble


def _settings(parameters: Mapping[str, Any], prefix: str = "") -> dict[str, str]:
    settings: dict[str, str] = {}
    for name, value in parameters.items():
        if isinstance(value, Mapping):
            settings.update(_settings(value, f"{prefix}{name}."))
        else:
            settings[prefix + name] = str(value).lower() if isinstance(value, bool) else str(value)
    return settings

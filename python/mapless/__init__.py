"""Labels every point of a spinning 3D lidar as moving or static, online and without a map (arXiv 1809.06972).

    detector = mapless.OnlineDetector(sensor="VLP-16")
    for scan in mapless.open("drive.mcap"):
        for found in detector.push(scan):
            print(found.scan, found.moving.sum(), "points move")
    for found in detector.flush():
        ...

docs/python.md has the rest.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from mapless._core import (
    Error,
    InputError,
    LabelledScan,
    MovingObject,
    OutputError,
    ParameterError,
    Trajectory,
    TrajectoryDomainError,
    version,
)

if TYPE_CHECKING:
    from mapless._detector import OnlineDetector, parameters
    from mapless._open import open
    from mapless._recording import CloudSource, Measurement, Recording, Scan
    from mapless._result import Result
    from mapless._verbs import CommandError, detect, detect_rig, evaluate, explain, simulate

__version__ = version()

__all__ = [
    "CloudSource",
    "CommandError",
    "Error",
    "InputError",
    "LabelledScan",
    "Measurement",
    "MovingObject",
    "OnlineDetector",
    "OutputError",
    "ParameterError",
    "Recording",
    "Result",
    "Scan",
    "Trajectory",
    "TrajectoryDomainError",
    "__version__",
    "detect",
    "detect_rig",
    "evaluate",
    "explain",
    "open",
    "parameters",
    "simulate",
]

# Loaded at first use: with them comes NumPy, a tenth of a second at each start of the command.
_MODULES = {
    "_detector": ("OnlineDetector", "parameters"),
    "_open": ("open",),
    "_recording": ("CloudSource", "Measurement", "Recording", "Scan"),
    "_result": ("Result",),
    "_verbs": ("CommandError", "detect", "detect_rig", "evaluate", "explain", "simulate"),
}

if not TYPE_CHECKING:

    def __getattr__(name):
        if name in _MODULES:
            return importlib.import_module(f"mapless.{name}")
        module = next((module for module, names in _MODULES.items() if name in names), None)
        if module is None:
            raise AttributeError(f"module 'mapless' has no attribute {name!r}")
        value = getattr(importlib.import_module(f"mapless.{module}"), name)
        globals()[name] = value
        return value

    def __dir__():
        return sorted({*globals(), *__all__})

"""sensor_msgs/PointCloud2 as the drivers of Velodyne, Ouster, Hesai, RoboSense and Autoware (Nebula) fill it."""

from __future__ import annotations

from typing import Any

import numpy as np

from mapless._core import InputError
from mapless._fields import Array

# PointField.datatype
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}


def cloud_of(message: Any, name: str) -> Array:
    """The points as a structured array of shape (height x width,); fields keep their offsets, aligned or not."""
    order = ">" if message.is_bigendian else "<"
    fields = {}
    for field in message.fields:
        if field.datatype not in TYPES:
            raise InputError(f"{name}: field {field.name}: type {field.datatype} is none of PointField's")
        if field.count == 1:
            fields[field.name] = (order + TYPES[field.datatype], field.offset)
    dtype = np.dtype(
        {
            "names": list(fields),
            "formats": [kind for kind, _ in fields.values()],
            "offsets": [offset for _, offset in fields.values()],
            "itemsize": message.point_step,
        }
    )
    data = np.asarray(message.data, dtype=np.uint8)
    used = message.width * message.point_step
    if data.size < message.height * message.row_step or message.row_step < used:
        raise InputError(
            f"{name}: data: {data.size} bytes: expected {message.height} rows of {message.row_step} bytes, "
            f"{message.width} points of {message.point_step} each"
        )
    rows = data[: message.height * message.row_step].reshape(message.height, message.row_step)[:, :used]
    cloud: Array = np.ascontiguousarray(rows).reshape(-1).view(dtype)
    return cloud

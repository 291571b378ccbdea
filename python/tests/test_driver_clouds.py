"""Clouds as the drivers publish them; tests/live/point_cloud2_test.cpp holds the C++ reader against the same file."""

import json
import pathlib
from types import SimpleNamespace

import numpy as np
import pytest

from mapless.readers.clouds import fields_of_cloud
from mapless.readers.point_cloud2 import cloud_of

CLOUDS = json.loads((pathlib.Path(__file__).parent / "driver_clouds.json").read_text())
NS_PER_UNIT = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1}
EPOCH_FROM_NS = 1e15
DOUBLE_OF_EPOCH_NS = 300  # a double resolves Unix seconds to 238 ns, Unix nanoseconds to 256


@pytest.mark.parametrize("cloud", CLOUDS, ids=lambda cloud: cloud["name"])
def test_a_cloud_of_a_driver_is_read(cloud):
    message = SimpleNamespace(**cloud | {"fields": [SimpleNamespace(**field) for field in cloud["fields"]]})
    message.data = np.frombuffer(bytes.fromhex(cloud["data"]), np.uint8)
    expected = cloud["expected"]
    found, notes = fields_of_cloud(cloud_of(message, "cloud"), cloud["stamp_ns"], cloud["height"], "cloud")
    assert notes == expected["notes"]
    assert (found.ring is None) == (expected["rings"] is None)
    if found.ring is not None:
        assert found.ring.tolist() == expected["rings"]
    times = expected["times_since_stamp_ns"]
    assert (found.time is None) == (times is None)
    for i, time in enumerate(times or ()):
        if time is None:
            continue
        instant = float(found.time[i]) * NS_PER_UNIT[found.time_unit]
        since_stamp = instant - cloud["stamp_ns"] if instant > EPOCH_FROM_NS else instant
        assert since_stamp == pytest.approx(time, abs=DOUBLE_OF_EPOCH_NS)

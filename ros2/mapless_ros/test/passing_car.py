"""A VLP-16 that stands in a yard, and a car that passes it: clouds as velodyne_pointcloud publishes them.

With the truth, by geometry: boxes and a floor, each ray at its own time.
"""

import numpy as np

TURN_NS = 100_000_000
COLUMNS, LASERS = 900, 16  # every other column: 300 kB fit into the default buffers of any middleware
FIELDS = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7), ("ring", 16, 4), ("time", 18, 7)]
POINT = np.dtype(
    {
        "names": [name for name, _, _ in FIELDS],
        "formats": ["<u2" if kind == 4 else "<f4" for _, _, kind in FIELDS],
        "offsets": [offset for _, offset, _ in FIELDS],
        "itemsize": 22,
    }
)
FLOOR_Z = -1.8
RANGE = (0.5, 100.0)
# Walls, posts and a shed: least and greatest corner [m] in the frame of the sensor: x ahead, y left, z up.
STILL = [
    ((-25.5, -18.0, -2.0), (-25.0, 16.0, 6.0)),
    ((30.0, -18.0, -2.0), (30.5, 16.0, 6.0)),
    ((-25.0, -18.5, -2.0), (30.0, -18.0, 6.0)),
    ((-25.0, 16.0, -2.0), (30.0, 16.5, 6.0)),
    ((-12.0, 8.0, -2.0), (-7.0, 12.0, 1.5)),
    ((14.0, 10.0, -2.0), (14.4, 10.4, 4.0)),
    ((3.0, -12.0, -2.0), (3.4, -11.6, 4.0)),
    ((-15.0, -9.0, -2.0), (-14.6, -8.6, 4.0)),
]
CAR_SIZE = (4.2, 1.8, 1.5)
CAR_START = (-14.0, 5.0, FLOOR_Z + 0.1)  # its rear right lower corner
CAR_SPEED = 6.0  # along x [m/s]
NOISE = 0.01  # of ranges [m]


def distances(directions, low, high):
    """Along rays from the sensor to a box, whose corners may differ by ray; infinite where they miss it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = low / directions, high / directions
    near, far = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
    return np.where((near <= far) & (near > 0), near, np.inf)


def cloud(k):
    """Turn k, from 0: its points (POINT) by column and laser, and whether each is of the car."""
    column, laser = (index.ravel() for index in np.mgrid[0:COLUMNS, 0:LASERS])
    time = column / COLUMNS * TURN_NS * 1e-9
    azimuth, elevation = -2 * np.pi * column / COLUMNS, np.radians(2.0 * laser - 15.0)
    flat = np.cos(elevation)
    directions = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=1)
    directions[directions == 0] = 1e-12

    floor = np.where(directions[:, 2] < 0, FLOOR_Z / directions[:, 2], np.inf)
    still = np.min(
        [floor, *(distances(directions, np.array(low), np.array(high)) for low, high in STILL)], axis=0
    )
    driven = np.outer(k * TURN_NS * 1e-9 + time, [CAR_SPEED, 0, 0])
    car = distances(directions, np.array(CAR_START) + driven, np.array(CAR_START) + CAR_SIZE + driven)
    true_range = np.minimum(still, car)
    kept = (true_range > RANGE[0]) & (true_range < RANGE[1])

    measured = true_range + np.random.default_rng(k).normal(0, NOISE, true_range.size)
    points = np.zeros(true_range.size, POINT)
    for axis, name in enumerate("xyz"):
        points[name] = np.where(kept, measured, 0) * directions[:, axis]
    points["intensity"], points["ring"], points["time"] = 50, laser, time
    return points[kept], (car < still)[kept]

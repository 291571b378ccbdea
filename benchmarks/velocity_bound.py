#!/usr/bin/env python3
"""How well the returns of a recording could determine the velocity within each scan, if the map were perfect.

usage: velocity_bound.py RECORDING ...

The odometry's filter (one knot a scan, white noise on acceleration, the points of each scan; the knots of none to
three scans before the newest still to be corrected, all before marginalised), linearised about the true trajectory,
with the true plane at every return: that of the returns of the whole recording within 0.4 m, put into the world by the
true poses. Noise is 0.02 m along the ray, 0.02 m times the cosine of the incidence across the plane, and 0.003 m of the
plane's own. Two errors add up: the noise, and that the true motion is not what the prior expects. Both are of the
linear velocity at ten instants of each scan, RMS from scan 10 on. A filter that weighs its points otherwise, or a map
of its own making, does worse. Needs native recordings with true poses, NumPy and SciPy.
"""

import argparse
import itertools
import pathlib
import sys

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from shared import poses

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "peers"))
from recordings import native_hits  # noqa: E402

BINS = 32  # of a scan, as the odometry has them
INSTANTS = (np.arange(10) + 0.5) / 10
STEP = 1e-5  # of numeric derivatives
RANGE_NOISE_M, PLANE_NOISE_M = 0.02, 0.003
SETTLED = 10  # scans
LATER = (0, 1, 2, 3)  # scans that may still correct the velocity
DENSITIES = [(translation, translation / 2) for translation in (0.03, 0.1, 0.2)]  # per m^2/s^3, rad^2/s^3


def hat(v):
    zero = np.zeros(v.shape[:-1])
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    rows = [np.stack(row, -1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))]
    return np.stack(rows, -2)


def times(A, x):
    return (A @ x[..., None])[..., 0]


def adjoint_of_velocity(x):
    out = np.zeros(x.shape[:-1] + (6, 6))
    out[..., :3, :3] = out[..., 3:, 3:] = hat(x[..., 3:])
    out[..., :3, 3:] = hat(x[..., :3])
    return out


def exp(x):
    m = np.zeros(x.shape[:-1] + (4, 4))
    m[..., :3, :3], m[..., :3, 3] = hat(x[..., 3:]), x[..., :3]
    term = out = np.broadcast_to(np.eye(4), m.shape)
    for k in range(1, 12):
        term = term @ m / k
        out = out + term
    return out


def log(T):
    w = Rotation.from_matrix(T[..., :3, :3].reshape(-1, 3, 3)).as_rotvec().reshape(T.shape[:-2] + (3,))
    W, square = hat(w), (w**2).sum(-1)[..., None, None]
    V_inverse = np.eye(3) - W / 2 + (1 / 12 + square / 720) * (W @ W)
    return np.concatenate([times(V_inverse, T[..., :3, 3]), w], -1)


# Of the turns within one scan, a tenth of a radian, to 1e-8.
def left_jacobian(x):
    a = adjoint_of_velocity(x)
    return np.eye(6) + a / 2 + a @ a / 6 + a @ a @ a / 24


def left_jacobian_inverse(x):
    a = adjoint_of_velocity(x)
    return np.eye(6) - a / 2 + a @ a / 12 - a @ a @ a @ a / 720


def motion_error(T1, v1, T2, v2, dt):
    xi = log(T2 @ np.linalg.inv(T1))
    return np.concatenate([xi - dt * v1, times(left_jacobian_inverse(xi), v2) - v1], -1)


def interpolate(T1, v1, T2, v2, dt, r):
    """Poses and velocities at the shares r of the interval; method.md, section 3."""
    xi = log(T2 @ np.linalg.inv(T1))
    w2 = times(left_jacobian_inverse(xi), v2)[:, None]
    xi, v1, r = xi[:, None], v1[:, None], r[None, :, None]
    gamma = dt * (r - 2 * r**2 + r**3) * v1 + (3 * r**2 - 2 * r**3) * xi + dt * (r**3 - r**2) * w2
    rate = (1 - 4 * r + 3 * r**2) * v1 + 6 * (r - r**2) / dt * xi + (3 * r**2 - 2 * r) * w2
    return exp(gamma) @ T1[:, None], times(left_jacobian(gamma), rate)


class Truth:
    def __init__(self, folder):
        self.rows = np.loadtxt(folder / "trajectory.txt")

    def pose(self, t):
        """World seen from the sensor."""
        p, R = poses(self.rows, t)
        T = np.zeros((len(t), 4, 4))
        T[:, :3, :3] = R.inv().as_matrix()
        T[:, :3, 3] = -times(T[:, :3, :3], p)
        T[:, 3, 3] = 1
        return T

    def velocity(self, t, h=0.005):
        t = np.clip(t, self.rows[0, 0] + h, self.rows[-1, 0] - h)
        return log(self.pose(t + h) @ np.linalg.inv(self.pose(t - h))) / (2 * h)


def usable_scans(folder, truth, starts, period):
    """Of each scan: points, times, the same in the world, and what rotates them there."""
    for start, (points, stamps, _) in zip(starts, native_hits(folder)):
        distance = np.linalg.norm(points, axis=1)
        usable = (distance > 1) & (distance < 100) & (stamps < period)
        p, R = poses(truth.rows, start + stamps[usable])
        yield points[usable], stamps[usable], R.apply(points[usable]) + p, R


def planes(scans, radius_m=0.4, most=60):
    """The normal at every point, in its sensor frame, and whether there is a plane."""
    world = np.concatenate([scan[2] for scan in scans])
    tree = cKDTree(world)
    for _, _, points_0, R in scans:
        _, near = tree.query(points_0, k=most, distance_upper_bound=radius_m)
        known = (near < len(world)).astype(float)
        count = known.sum(1)
        cloud = world[np.minimum(near, len(world) - 1)]
        mean = (cloud * known[..., None]).sum(1) / count[:, None]
        off = (cloud - mean[:, None]) * known[..., None]
        extent, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", off, off) / count[:, None, None])
        flat = (count >= 10) & (extent[:, 1] > 4 * extent[:, 0]) & (extent[:, 0] < 0.05**2)
        yield R.inv().apply(axes[:, :, 0]), flat


def one_per_cube(points, cube_m):
    order = np.random.default_rng(1).permutation(len(points))
    _, first = np.unique(np.floor(points[order] / cube_m).astype(int), axis=0, return_index=True)
    out = np.zeros(len(points), bool)
    out[order[first]] = True
    return out


class Interval:
    """What two knots at the truth say of the motion between them, and its derivatives by both."""

    def __init__(self, truth, start, dt):
        T, v = truth.pose(start + np.array([0, dt])), truth.velocity(start + np.array([0, dt]))
        d = np.concatenate([np.zeros((1, 24)), STEP * np.eye(24), -STEP * np.eye(24)])
        knots = exp(d[:, :6]) @ T[0], v[0] + d[:, 6:12], exp(d[:, 12:18]) @ T[1], v[1] + d[:, 18:]
        slope = lambda f: np.moveaxis((f[1:25] - f[25:]) / (2 * STEP), 0, -1)  # noqa: E731
        error = motion_error(*knots, dt)
        self.prior_error, self.prior_slope = error[0], slope(error)
        r = (np.arange(BINS) + 0.5) / BINS
        at, _ = interpolate(*knots, dt, r)
        self.pose_slope = slope(log(at @ np.linalg.inv(at[0])))
        self.pose_error = log(truth.pose(start + r * dt) @ np.linalg.inv(at[0]))
        _, velocity = interpolate(*knots, dt, INSTANTS)
        self.velocity_slope = slope(velocity)
        self.velocity_error = truth.velocity(start + INSTANTS * dt) - velocity[0]


def prior_information(dt, density):
    inverse = np.diag(np.repeat(1 / np.array(density), 3))
    return np.block([[12 / dt**3 * inverse, -6 / dt**2 * inverse], [-6 / dt**2 * inverse, 4 / dt * inverse]])


class Term:
    """The constraint of a scan on the two knots about it: information, gradient, and the gradient's noise."""

    def __init__(self, scan, planes, at, dt, choose, assumed_sigma, share, density):
        (points, stamps, _, _), (normal, flat) = scan, planes
        used = flat & choose(points)
        p, n = points[used], normal[used]
        cosine = np.abs((n * p).sum(1)) / np.linalg.norm(p, axis=1)
        sigma = np.hypot(RANGE_NOISE_M * cosine, PLANE_NOISE_M)
        weight = share / (assumed_sigma or sigma) ** 2 * np.ones(len(p))
        of_bin = np.minimum((stamps[used] / dt * BINS).astype(int), BINS - 1)
        a = np.concatenate([n, np.cross(p, n)], 1)
        A = np.einsum("ni,nij->nj", a, at.pose_slope[of_bin])
        W = prior_information(dt, density)
        self.H = at.prior_slope.T @ W @ at.prior_slope + (A * weight[:, None]).T @ A
        self.g = -at.prior_slope.T @ W @ at.prior_error + (A * weight[:, None]).T @ (a * at.pose_error[of_bin]).sum(1)
        self.noise = (A * (weight * sigma)[:, None] ** 2).T @ A


def solved(known, terms):
    """Of the knots about the scans, the first `known` beforehand: how far off, by what noise, with what information."""
    P, mean, C = known
    size = 12 * (len(terms) + 1)
    H, g, noise = np.zeros((size, size)), np.zeros(size), np.zeros((size, size))
    H[:12, :12], g[:12], noise[:12, :12] = P, P @ mean, P @ C @ P
    for k, term in enumerate(terms):
        both = slice(12 * k, 12 * k + 24)
        H[both, both] += term.H
        g[both] += term.g
        noise[both, both] += term.noise
    S = np.linalg.inv(H)
    return S @ g, S @ noise @ S, H


def velocity_rms(terms, intervals, later):
    """RMS of the velocity's error in each scan with the scans until then and `later` more: by noise, prior, both."""
    known = np.diag([1e10] * 6 + [1 / 900] * 3 + [1 / 25] * 3), np.zeros(12), np.zeros((12, 12))
    squares = []
    for k, at in enumerate(intervals):
        off, C, _ = solved(known, terms[k : k + 1 + later])
        by_prior = times(at.velocity_slope, off[:24]) - at.velocity_error
        by_noise = at.velocity_slope @ C[:24, :24] @ np.swapaxes(at.velocity_slope, 1, 2)
        squares.append([np.trace(by_noise[:, :3, :3], axis1=1, axis2=2).mean(), (by_prior[:, :3] ** 2).sum(1).mean()])
        off, C, H = solved(known, terms[k : k + 1])
        P = H[12:, 12:] - H[12:, :12] @ np.linalg.solve(H[:12, :12], H[:12, 12:])
        known = P, off[12:], C[12:, 12:]
    noise, prior = np.mean(squares[SETTLED:], 0)
    return np.sqrt([noise, prior, noise + prior])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recordings", nargs="+", type=pathlib.Path)
    for folder in parser.parse_args().recordings:
        truth, starts = Truth(folder), np.loadtxt(folder / "times.txt")
        dt = starts[1] - starts[0]
        scans = list(usable_scans(folder, truth, starts, dt))
        normals = list(planes(scans))
        intervals = [Interval(truth, start, dt) for start in starts]
        chosen = {"all": lambda p: np.ones(len(p), bool), "one per 0.375 m": lambda p: one_per_cube(p, 0.375)}
        weighed = {"by incidence": (None, 1), "as 0.02 m, 0.3 of each": (0.02, 0.3)}
        for points, weights in itertools.product(chosen, weighed):
            terms = [
                [Term(*of_scan, dt, chosen[points], *weighed[weights], density) for of_scan in zip(scans, normals, intervals)]
                for density in DENSITIES
            ]
            for later in LATER:
                noise, prior, both = min((velocity_rms(t, intervals, later) for t in terms), key=lambda run: run[2])
                print(
                    f"{folder.name}, {points}, weighed {weights}, {later} scans later: "
                    f"{both:.3f} m/s ({noise:.3f} noise, {prior:.3f} prior)"
                )


if __name__ == "__main__":
    main()

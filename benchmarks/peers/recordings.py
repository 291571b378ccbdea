"""Raw scans of a recording as other people's programs take them: points and their times."""

import pathlib

import numpy as np

PCD_TYPES = {("F", 4): "<f4", ("F", 8): "<f8", ("U", 1): "u1", ("U", 2): "<u2", ("U", 4): "<u4"}


def read_pcd(file):
    """The fields of a binary PCD file as a structured array."""
    content = file.read_bytes()
    header_end = content.index(b"DATA binary\n") + len(b"DATA binary\n")
    lines = content[:header_end].decode("ascii").splitlines()
    header = {words[0]: words[1:] for words in (line.split() for line in lines) if words[0] != "#"}
    types = [PCD_TYPES[kind, int(size)] for kind, size in zip(header["TYPE"], header["SIZE"])]
    return np.frombuffer(content, np.dtype(list(zip(header["FIELDS"], types))), offset=header_end)


def native_hits(folder):
    """Points [m] and times since the scan's start [s] of the hits, and which records of the file they are."""
    for file in sorted((folder / "scans").glob("*.pcd")):
        scan = read_pcd(file)
        hits = (scan["code"] == 0) & np.isfinite(scan["x"])
        scan = scan[hits]
        points = np.stack([scan["x"], scan["y"], scan["z"]], axis=1).astype(np.float64)
        yield points, scan["t"] * 1e-9, hits


def native_scans(folder):
    """Points [m] and times since the scan's start [s] of the hits, in the order of the file."""
    for points, times, _ in native_hits(folder):
        yield points, times


def kitti_raw_scans(drive):
    """As KISS-ICP's own reader: its correction of KITTI's vertical angles, time from the azimuth."""
    from kiss_icp.pybind import kiss_icp_pybind as kiss

    for file in sorted((drive / "velodyne_points" / "data").glob("*.bin")):
        points = np.fromfile(file, np.float32).reshape(-1, 4)[:, :3].astype(np.float64)
        times = 0.5 * (1 - np.arctan2(points[:, 1], points[:, 0]) / np.pi)
        yield np.asarray(kiss._correct_kitti_scan(kiss._Vector3dVector(points))), times


def scans(folder):
    folder = pathlib.Path(folder)
    return kitti_raw_scans(folder) if (folder / "velodyne_points").is_dir() else native_scans(folder)

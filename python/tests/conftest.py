"""A small simulated drive, native and as a folder of PCD files."""

import pathlib
import shutil

import pytest

import mapless
from comparison import without_empty_rays


@pytest.fixture(scope="session")
def drive(tmp_path_factory) -> pathlib.Path:
    """Fourteen scans of a VLP-16 that drives through a town at 13 m/s, with rings, times and true labels. (On the scene
    "crossing" it stands: there wrong times and poses change nothing.)"""
    folder = tmp_path_factory.mktemp("drive") / "native"
    mapless.simulate("town1", folder, sensor="VLP-16", duration_s=1.4)
    return folder


@pytest.fixture(scope="session")
def driver_drive(drive, tmp_path_factory) -> pathlib.Path:
    """The same drive without rays that say that there is nothing within range: what drivers and data sets have of it."""
    folder = tmp_path_factory.mktemp("driver") / "native"
    shutil.copytree(drive, folder)
    without_empty_rays(folder)
    return folder


@pytest.fixture(scope="session")
def scans(drive) -> list[mapless.Scan]:
    return list(mapless.open(drive))


@pytest.fixture(scope="session")
def poses(drive) -> mapless.Trajectory:
    return mapless.open(drive).trajectory


@pytest.fixture(scope="session")
def native_result(drive, tmp_path_factory) -> mapless.Result:
    """Labels and probabilities of the native recording by the command, with own odometry."""
    return mapless.detect(drive, tmp_path_factory.mktemp("result") / "out", odometry=True, probability=True)


@pytest.fixture(scope="session")
def driver_result(driver_drive, tmp_path_factory) -> mapless.Result:
    return mapless.detect(driver_drive, tmp_path_factory.mktemp("driver_result") / "out", odometry=True)


@pytest.fixture(scope="session")
def posed_result(driver_drive, tmp_path_factory) -> mapless.Result:
    """With the poses of the drive."""
    return mapless.detect(driver_drive, tmp_path_factory.mktemp("posed") / "out")

"""A small simulated drive, native and as a folder of PCD files."""

import pathlib
import shutil

import pytest

import mapless
from comparison import without_empty_rays


@pytest.fixture(scope="session")
def drive(tmp_path_factory) -> pathlib.Path:
    """Fourteen scans of a VLP-16 that drives across a junction, with rings, times and true labels."""
    folder = tmp_path_factory.mktemp("drive") / "native"
    mapless.simulate("crossing", folder, sensor="VLP-16", duration_s=1.4)
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
def driver_result(drive, tmp_path_factory) -> mapless.Result:
    """The same where no ray says that there is nothing within range: what a driver can publish of this drive."""
    folder = tmp_path_factory.mktemp("driver")
    shutil.copytree(drive, folder / "drive")
    without_empty_rays(folder / "drive")
    return mapless.detect(folder / "drive", folder / "out", odometry=True)


@pytest.fixture(scope="session")
def posed_result(drive, tmp_path_factory) -> mapless.Result:
    """Labels of the native recording by the command, with its poses."""
    return mapless.detect(drive, tmp_path_factory.mktemp("posed") / "out")

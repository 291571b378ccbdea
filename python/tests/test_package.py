"""The installed package: its command, its verbs, its types."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest

import mapless


def command(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "mapless", *map(str, arguments)], capture_output=True, text=True, check=False
    )


def test_the_command_is_that_of_the_library_with_more_formats(drive):
    assert command("--version").stdout.strip() == f"mapless {mapless.__version__}"
    help_text = command("detect", "--help").stdout
    assert "--topic" in help_text
    assert "rosbag2" in help_text
    assert "native" in command("info", drive).stdout
    wrong = command("detect")
    assert wrong.returncode == 2
    assert "mapless: error:" in wrong.stderr


def test_info_of_a_bag_that_is_not_there():
    missing = command("info", "no.mcap")
    assert missing.returncode == 3
    assert "no.mcap" in missing.stderr


def test_a_result_is_read_as_arrays_and_tables(native_result, tmp_path):
    assert len(native_result) == 14
    assert native_result.poses().shape == (14, 4, 4)
    np.testing.assert_allclose(native_result.poses()[0], np.eye(4), atol=1e-5)  # the world is the first scan's frame
    objects = native_result.objects()
    numbers = {int(n) for n in np.unique(native_result.label(7) >> 16)} - {0}
    assert set(objects["id"][objects["scan"] == 7]) == numbers
    assert native_result.summary()["complete"] is True
    assert native_result.trajectory().shape[1] == 8
    with pytest.raises(mapless.InputError, match="no labels of scan 99; the result has 0 to 13"):
        native_result.label(99)
    with pytest.raises(mapless.InputError, match="no result"):
        mapless.Result(tmp_path)


def test_evaluate_gives_the_numbers_of_the_command(drive, native_result):
    report = mapless.evaluate(drive, native_result.path)
    truth = np.concatenate([mapless.open(drive).labels(k) for k in native_result.scans]) & 0xFFFF
    found = np.concatenate([native_result.label(k) for k in native_result.scans]) & 0xFFFF
    true_positives = int(((truth >= 251) & (truth <= 259) & (found == 251)).sum())
    assert true_positives > 0
    assert f": {true_positives}," in str(report)


def test_errors_of_verbs_are_raised(drive, tmp_path):
    with pytest.raises(mapless.CommandError, match="no such folder"):
        mapless.detect(tmp_path / "none", tmp_path / "out")


def test_the_package_and_its_stubs_pass_mypy(tmp_path):
    pytest.importorskip("mypy")
    user = tmp_path / "user.py"
    user.write_text(
        "import mapless\n"
        "detector = mapless.OnlineDetector('VLP-16', forward_gap=0, voting={'references': 8})\n"
        "for scan in mapless.open('drive.mcap'):\n"
        "    for found in detector.push(scan.points, time=scan.time_s, stamp_ns=scan.stamp_ns):\n"
        "        reveal_type(found.moving)\n"
        "mapless.OnlineDetector(forward_gap='two')\n"
    )
    config = pathlib.Path(__file__).parents[2] / "pyproject.toml"
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", config, "-p", "mapless"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stdout
    used = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", config, user],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert "numpy.bool" in used.stdout
    assert used.stdout.count("error:") == 1, used.stdout
    assert "forward_gap" in used.stdout


def test_the_command_loads_no_readers_where_the_format_is_one_of_the_library(drive):
    show = "import sys; from mapless._command import run; run(['info', sys.argv[1], '--format', sys.argv[2]]); print('numpy' in sys.modules)"
    loaded = {
        form: subprocess.run(
            [sys.executable, "-c", show, str(drive), form], capture_output=True, text=True, check=False
        ).stdout.split()[-1]
        for form in ("native", "boreas")
    }
    assert loaded == {"native": "False", "boreas": "True"}


def test_the_names_of_formats_are_those_of_the_readers():
    from mapless.readers import FORMATS
    from mapless.readers.registry import READERS

    assert [name for reader in READERS for name in reader.formats] == list(FORMATS)


def test_every_public_name_is_there():
    assert {name for name in mapless.__all__ if getattr(mapless, name) is None} == set()
    assert set(mapless.__all__) <= set(dir(mapless))
    with pytest.raises(AttributeError, match="no attribute 'opne'"):
        mapless.opne  # noqa: B018

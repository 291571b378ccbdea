"""Public evaluations, on sequences of a few points."""

import json

import numpy as np
import pytest

import mapless
from mapless.protocols import evaluate_protocol
from test_package import command


def write(folder, sequence, kind, number, labels, name="{:06d}"):
    path = folder / sequence / kind / (name.format(number) + ".label")
    path.parent.mkdir(parents=True, exist_ok=True)
    np.array(labels, "<u4").tofile(path)


def write_cloud(folder, sequence, number, ranges_m):
    path = folder / sequence / "velodyne" / f"{number:06d}.bin"
    path.parent.mkdir(parents=True, exist_ok=True)
    points = np.zeros((len(ranges_m), 4), "<f4")
    points[:, 1] = ranges_m
    points.tofile(path)


@pytest.fixture
def folders(tmp_path):
    return tmp_path / "truth", tmp_path / "found"


def test_semantic_kitti_leaves_unlabelled_points_out_and_sums_counts_over_scans(folders):
    truth, found = folders
    # Moving car (instance 7), moving person, static car, road, unlabelled, outlier.
    write(truth, "08", "labels", 0, [7 << 16 | 252, 254, 10, 40, 0, 1])
    write(found, "08", "predictions", 0, [251, 9, 251, 9, 251, 251])
    write(truth, "08", "labels", 1, [259, 259, 40, 40, 40, 40])
    write(found, "08", "predictions", 1, [3 << 16 | 251, 251, 9, 9, 9, 9])
    total = evaluate_protocol("semantickitti", truth, found)["total"]
    assert (total["tp"], total["fp"], total["fn"], total["tn"]) == (3, 1, 1, 5)
    assert total["iou"] == pytest.approx(3 / 5)
    assert total["mean_iou_of_scans"] == pytest.approx((1 / 3 + 1) / 2)
    assert total["ranges_m"] is None


def test_kitti_road_mos_takes_unlabelled_points_as_static(folders):
    truth, found = folders
    write(truth, "30", "labels", 0, [0, 0, 251, 9])
    write(found, "30", "predictions", 0, [251, 9, 251, 9], "{:010d}")
    report = evaluate_protocol("kitti-road-mos", truth, found)
    total = report["total"]
    assert (total["tp"], total["fp"], total["fn"], total["tn"]) == (1, 1, 0, 2)
    assert report["left_out"] == [str(n) for n in range(31, 42)]


def test_helimos_counts_the_scans_of_its_list(folders):
    truth, found = folders
    for number in (0, 1):
        write(truth, "03", "labels", number, [251, 9])
        write(found, "03", "predictions", number, [251, 251] if number else [9, 9])
    (truth / "03" / "test.txt").write_text("03/velodyne/000001.bin\n")
    total = evaluate_protocol("helimos", truth, found)["total"]
    assert (total["scans"], total["tp"], total["fp"]) == (1, 1, 1)
    (truth / "03" / "test.txt").unlink()
    with pytest.raises(mapless.InputError, match="test.txt: missing"):
        evaluate_protocol("helimos", truth, found)


def test_ranges_are_counted_where_the_clouds_are_there(folders):
    truth, found = folders
    write(truth, "08", "labels", 0, [252, 252, 9, 252])
    write(found, "08", "predictions", 0, [251, 9, 251, 251])
    write_cloud(truth, "08", 0, [9.9, 10.0, 39.9, 40.0])
    ranges = evaluate_protocol("semantickitti", truth, found)["total"]["ranges_m"]
    counts = {name: (r["tp"], r["fp"], r["fn"], r["tn"]) for name, r in ranges.items()}
    assert counts == {"0-10": (1, 0, 0, 0), "10-20": (0, 0, 1, 0), "20-40": (0, 1, 0, 0), "40-inf": (1, 0, 0, 0)}


def test_what_does_not_fit_is_named(folders):
    truth, found = folders
    write(truth, "08", "labels", 0, [9, 9])
    with pytest.raises(mapless.InputError, match="no predictions of the sequences of semantickitti: 08"):
        evaluate_protocol("semantickitti", truth, found)
    write(found, "08", "predictions", 1, [9])
    with pytest.raises(mapless.InputError, match="no prediction of scan 0"):
        evaluate_protocol("semantickitti", truth, found)
    write(found, "08", "predictions", 0, [9])
    with pytest.raises(mapless.InputError, match="1 labels: expected 2"):
        evaluate_protocol("semantickitti", truth, found)


def test_the_command_evaluates_what_export_writes(drive, native_result, tmp_path):
    truth = tmp_path / "truth" / "08" / "labels"
    truth.mkdir(parents=True)
    recording = mapless.open(drive)
    for k in native_result.scans:
        recording.labels(k).tofile(truth / f"{k:06d}.label")
    done = command(
        *("export", drive, native_result.path, "--what", "semantic-kitti", "--sequence", "08", "-o", tmp_path / "found")
    )
    assert done.returncode == 0, done.stderr
    arguments = "evaluate", "--protocol", "semantickitti", tmp_path / "truth", tmp_path / "found" / "sequences"
    total = json.loads(command(*arguments, "--json").stdout)["total"]
    report = str(mapless.evaluate(drive, native_result.path))
    assert total["tp"] > 0
    assert all(f": {total[name]}," in report for name in ("tp", "fp", "fn"))
    assert f"{100 * total['iou']:.1f}" in command(*arguments).stdout
    direct = ("detect", drive, "--odometry", "-o", tmp_path / "again", "--semantic-kitti", tmp_path / "direct")
    assert command(*direct).returncode == 0
    for label in sorted((tmp_path / "found" / "sequences" / "08" / "predictions").iterdir()):
        assert (tmp_path / "direct" / "sequences" / "00" / "predictions" / label.name).read_bytes() == label.read_bytes()
    assert command(*direct, "--overwrite").returncode == 1  # the predictions are there
    missing = command("evaluate", "--protocol", "helimos", tmp_path / "truth", tmp_path / "found")
    assert (missing.returncode, missing.stderr[:16]) == (3, "mapless: error: ")

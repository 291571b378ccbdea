"""Public evaluations whose truth is not a label file: DOALS, Argoverse 2, nuScenes, on a few points each."""

import json
import zipfile

import numpy as np
import pytest

import mapless
from comparison import compact
from mapless.protocols import evaluate_protocol


def write_labels(folder, scan, moving):
    place = folder / "labels" / f"{scan:06d}.label"
    place.parent.mkdir(parents=True, exist_ok=True)
    np.where(moving, 251, 9).astype("<u4").tofile(place)


def counts_of(figures):
    return figures["tp"], figures["fp"], figures["fn"], figures["tn"]


def test_doals_counts_the_marked_scans_whole_and_to_20_m(scans, tmp_path):
    bags = pytest.importorskip("test_bags")
    truth, found = tmp_path / "doals" / "station" / "sequence_2", tmp_path / "out" / "station" / "sequence_2"
    truth.mkdir(parents=True)
    clouds = list(bags.clouds_of(scans[:8], bags.OUSTER, bags.ouster))
    bags.write(truth / "bag.bag", clouds)
    # A person at the nearest point of scan 3 and one at the farthest; found are the nearest and the one after it.
    kept = scans[3].points[compact(scans[3])]
    by_range = np.argsort(np.linalg.norm(kept, axis=1))
    near, next_near, far = by_range[0], by_range[1], by_range[-1]
    assert np.linalg.norm(kept[far]) > 20 > np.linalg.norm(kept[next_near])
    (truth / "indices.csv").write_text(f"{clouds[3][1]},{near},{far}\n")
    write_labels(found, 3, np.isin(np.arange(len(kept)), (near, next_near)))
    report = evaluate_protocol("doals", tmp_path / "doals", tmp_path / "out")
    within_20 = int((np.linalg.norm(kept, axis=1) < 20).sum())
    assert report["total"]["scans"] == 1
    assert counts_of(report["total"]) == (1, 1, 1, len(kept) - 3)
    assert counts_of(report["total"]["ranges_m"]["0-20"]) == (1, 1, 0, within_20 - 2)
    assert len(report["left_out"]) == 7
    (truth / "indices.csv").write_text(f"{clouds[3][1] + 10**9},{near}\n")
    with pytest.raises(mapless.InputError, match="has no scan at"):
        evaluate_protocol("doals", tmp_path / "doals", tmp_path / "out")


@pytest.fixture
def argoverse(tmp_path):
    """Two sweeps of six points, the second of which is annotated: its last point is not in the mask."""
    feather = pytest.importorskip("pyarrow.feather")
    pyarrow = pytest.importorskip("pyarrow")

    def write(place, **columns):
        place.parent.mkdir(parents=True, exist_ok=True)
        feather.write_feather(pyarrow.table(columns), place)
        return place

    for stamp in (100, 200):
        write(tmp_path / "val" / "log" / "sensors" / "lidar" / f"{stamp}.feather", x=[0.0] * 6)
    write(
        tmp_path / "annotations" / "log" / "200.feather",
        is_dynamic=[True, True, False, True, True],
        is_valid=[True, True, True, False, True],
        is_close=[True, True, True, True, False],
    )
    mask = write(tmp_path / "mask.feather", mask=[True] * 5 + [False])
    with zipfile.ZipFile(tmp_path / "masks.zip", "w") as archive:
        archive.write(mask, "log/200.feather")
    write_labels(tmp_path / "out" / "log" / "up_lidar", 1, np.array([1, 0, 0, 1, 1, 1], bool))
    write_labels(tmp_path / "out" / "log" / "down_lidar", 1, np.array([0, 0, 1, 0, 0, 1], bool))
    more = {"annotations": tmp_path / "annotations", "masks": tmp_path / "masks.zip"}
    return tmp_path, lambda: evaluate_protocol("av2", tmp_path / "val", tmp_path / "out", **more)


def test_argoverse_counts_valid_points_near_by_of_the_mask(argoverse):
    folder, evaluate = argoverse
    assert counts_of(evaluate()["total"]) == (1, 1, 1, 0)  # found by the upper, by the lower, by none
    (folder / "out" / "log" / "down_lidar" / "labels" / "000001.label").unlink()
    with pytest.raises(mapless.InputError, match="--lidar down_lidar -o"):
        evaluate()
    with pytest.raises(mapless.InputError, match="needs --annotations and --masks"):
        evaluate_protocol("av2", folder / "val", folder / "out")


def test_nuscenes_counts_key_frames_by_boxes_whose_attribute_says_that_they_move(tmp_path):
    """The sensor is 2 m above the ego frame, which is at (100, 0, 0) and turned to the left: x ahead is y of the world."""
    turned = {"rotation": [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]}
    boxes = {"moving": [100.0, 10.0, 2.0], "parked": [100.0, 20.0, 2.0], "rider": [100.0, 60.0, 2.0]}
    attributes = {"moving": "vehicle.moving", "parked": "vehicle.parked", "rider": "cycle.with_rider"}
    sweep = {"timestamp": 2_000_000, "sample_token": "s", "ego_pose_token": "e", "calibrated_sensor_token": "c"}
    files = ["sweeps/log__LIDAR_TOP__1.pcd.bin", "samples/log__LIDAR_TOP__2.pcd.bin"]
    tables = {
        "scene": [{"token": "x", "name": "scene-0103"}],
        "sample": [{"token": "s", "scene_token": "x"}],
        "sample_data": [
            {**sweep, "token": "0", "timestamp": 1_000_000, "is_key_frame": False, "filename": files[0]},
            {**sweep, "token": "1", "is_key_frame": True, "filename": files[1]},
        ],
        "ego_pose": [{"token": "e", "translation": [100, 0, 0], **turned}],
        "calibrated_sensor": [{"token": "c", "translation": [0, 0, 2], "rotation": [1, 0, 0, 0]}],
        "attribute": [{"token": name, "name": attribute} for name, attribute in attributes.items()],
        "sample_annotation": [  # 4 m along the world's y, 2 m across
            {"token": name, "sample_token": "s", "attribute_tokens": [name], "translation": centre, "size": [2, 4, 2], **turned}
            for name, centre in boxes.items()
        ],
    }
    (tmp_path / "v1.0-mini").mkdir()
    for name, rows in tables.items():
        (tmp_path / "v1.0-mini" / f"{name}.json").write_text(json.dumps(rows))
    # Within the moving box, found; within it, not found; beside it, found; in the parked box; in that of the rider, too
    # far; too near.
    ahead = [(11.9, 0.9), (8.1, 0), (10, 1.1), (20, 0), (60, 0), (2.9, 0)]
    cloud = np.zeros((len(ahead), 5), "<f4")
    cloud[:, :2] = ahead
    (tmp_path / "samples").mkdir()
    cloud.tofile(tmp_path / files[1])
    write_labels(tmp_path / "out" / "scene-0103", 1, np.array([1, 0, 1, 0, 0, 1], bool))
    report = evaluate_protocol("nuscenes", tmp_path, tmp_path / "out")
    assert (report["total"]["scans"], counts_of(report["total"])) == (1, (1, 1, 1, 1))
    ranges = {name: counts_of(figures) for name, figures in report["total"]["ranges_m"].items()}
    assert ranges == {"3-10": (0, 0, 1, 0), "10-20": (1, 1, 0, 0), "20-40": (0, 0, 0, 1), "40-50": (0, 0, 0, 0)}

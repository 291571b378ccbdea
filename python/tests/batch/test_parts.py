"""Parts of a long drive: the bytes of one run."""

import json

import pytest

import mapless
from mapless.batch import parts

SCANS = 260
WARM_UP, COMPARED = 124, 30  # enough for this drive: every byte is compared
SMALL_SENSOR = "name: small\nrate_hz: 10\ndirection: -1\ncolumns: 240\nstart_azimuth_deg: 180\nmin_range_m: 1\nmax_range_m: 60\nlasers:\n"
LASERS = "".join(f"  - {{elevation_deg: {e}, azimuth_offset_deg: 0, origin_m: [0, 0, 0]}}\n" for e in range(-14, 7, 3))


@pytest.fixture(scope="module")
def long_drive(tmp_path_factory):
    """Moving objects in most scans, and the result of one run."""
    folder = tmp_path_factory.mktemp("long")
    (folder / "small.yaml").write_text(SMALL_SENSOR + LASERS)
    mapless.simulate("crossing", folder / "drives" / "d", sensor=folder / "small.yaml", duration_s=SCANS / 10, seed=3)
    mapless.detect(folder / "drives" / "d", folder / "single")
    return folder


@pytest.fixture
def plan(long_drive, tmp_path, batch, monkeypatch):
    monkeypatch.setattr(parts, "WARM_UP", WARM_UP)
    monkeypatch.setattr(parts, "COMPARED", COMPARED)
    monkeypatch.setattr(parts, "FEWEST_SCANS", SCANS // 2)
    code, out, err = batch("plan", long_drive / "drives", "-o", tmp_path / "plan", "--chunk", SCANS // 2, "--evaluate")
    assert code == 0, err
    assert "1 drives (2 tasks)" in out
    return tmp_path / "plan"


def require_the_bytes_of_one_run(result, single):
    files = sorted(p.relative_to(single) for p in single.rglob("*") if p.is_file() and p.name not in (".lock", "summary.json"))
    assert len(files) > 2 * SCANS
    there = {p.relative_to(result) for p in result.rglob("*") if p.is_file()}
    assert there - set(files) == {p.relative_to(result) for p in result.iterdir() if p.suffix == ".json"}
    assert [file for file in files if (result / file).read_bytes() != (single / file).read_bytes()] == []
    counts = ("first_scan", "scans", "records", "points", "dynamic_points", "objects", "objects_over_time", "complete")
    joined, one = (json.loads((folder / "summary.json").read_text()) for folder in (result, single))
    assert {name: joined[name] for name in counts} == {name: one[name] for name in counts}


def test_the_parts_of_a_drive_are_joined_to_the_bytes_of_one_run(long_drive, plan, tmp_path, batch):
    lines = [json.loads(line) for line in plan.read_text().splitlines()]
    assert [(line["id"], line["drive"], line["part"], line["parts"]) for line in lines] == [
        ("d.part0000", "d", 0, 2),
        ("d.part0001", "d", 1, 2),
    ]
    results = tmp_path / "results"
    assert batch("run", plan, "-o", results, "--index", 1)[0] == 0  # in any order
    assert not (results / "d").exists()
    assert batch("merge", results, "--plan", plan)[0] == 0
    assert "1 of 2 parts are labelled" in (results / "drives.csv").read_text()
    assert batch("run", plan, "-o", results, "--index", 0) == (0, "", "")
    require_the_bytes_of_one_run(results / "d", long_drive / "single")
    objects = mapless.Result(results / "d").objects()
    before, after = (set(objects["id"][objects["scan"] == scan]) for scan in (SCANS // 2 - 1, SCANS // 2))
    assert before & after  # one that both parts have seen
    assert max(objects["id"][objects["scan"] >= SCANS // 2]) > max(objects["id"][objects["scan"] < SCANS // 2])
    record = json.loads((results / "d" / "_SUCCESS.json").read_text())
    assert record["parts"] == 2
    assert record["true_positives"] == mapless.evaluate(long_drive / "drives" / "d", long_drive / "single")["final"]["tp"]
    code, _, err = batch("run", plan, "-o", results)
    assert (code, "0 drives labelled, 2 were done" in err) == (0, True)
    assert batch("merge", results)[1].startswith("1 drives: 1 done")


def test_a_drive_whose_parts_differ_is_labelled_in_one_run(long_drive, plan, tmp_path, batch):
    results = tmp_path / "results"
    batch("run", plan, "-o", results, "--index", 0)
    label = results / "d.part0000" / "labels" / f"{SCANS // 2 - 1:06d}.label"
    label.write_bytes(label.read_bytes()[:-4] + b"\xfb\0\0\0")
    code, _, err = batch("run", plan, "-o", results, "--index", 1)
    assert code == 0
    assert "its parts differ (labels of scan" in err
    require_the_bytes_of_one_run(results / "d", long_drive / "single")


def test_a_join_that_was_killed_is_done_by_the_next_run(long_drive, plan, tmp_path, batch, monkeypatch):
    results = tmp_path / "results"
    with monkeypatch.context() as patched:
        patched.setattr("mapless.batch.task._join", lambda *_: 137)
        for k in (0, 1):
            assert batch("run", plan, "-o", results, "--index", k)[0] == 137
    assert not (results / "d").exists()
    assert batch("run", plan, "-o", results, "--index", 1)[0] == 0
    require_the_bytes_of_one_run(results / "d", long_drive / "single")


def test_a_drive_without_poses_is_not_cut(long_drive, tmp_path, batch):
    more = ("--chunk", parts.FEWEST_SCANS)
    code, out, err = batch("plan", long_drive / "drives", "-o", tmp_path / "plan", *more, "--options=--odometry")
    assert (code, "(2 tasks)" in out) == (0, False)
    assert batch("plan", long_drive / "drives", "-o", tmp_path / "plan", "--chunk", 100)[0] == 2
    code, _, err = batch("plan", long_drive / "drives", "-o", tmp_path / "plan", *more, "--options=--first 3")
    assert (code, "--chunk: not with --first" in err) == (2, True)

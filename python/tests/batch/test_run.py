"""Labelling the drives of a plan on one machine, and the sums."""

import collections
import csv
import dataclasses
import fcntl
import json
import os
import signal
import subprocess
import sys

import pytest

import mapless
from mapless.batch import progress
from mapless.batch.plan import read_task


@pytest.fixture
def results(tmp_path):
    return tmp_path / "results"


@pytest.fixture
def plan_of(tmp_path, make_drive, batch, calls):
    def plan(**drives):
        for name, (size, how) in drives.items():
            make_drive(tmp_path / "drives" / name, size, how)
        assert batch("plan", tmp_path / "drives", "-o", tmp_path / "plan")[0] == 0
        return tmp_path / "plan"

    return plan


def rows_of(results):
    with (results / "drives.csv").open(newline="") as file:
        return {row["id"]: row for row in csv.DictReader(file)}


def test_failures_leave_the_others_untouched_and_are_counted_by_cause(plan_of, results, fake, batch, calls):
    plan = plan_of(a=(4, ""), bad=(5, "3"), c=(6, "once 75"), killed=(7, "9"), lost=(8, "4"), broken=(9, "1"))
    code, _, err = batch("run", plan, "-o", results, "--command", fake, "--jobs", 2, "--retries", 1)
    assert code == 75  # the killed one may succeed
    assert "3 drives labelled, 0 were done, 3 failed" in err
    tries = collections.Counter(calls())
    assert tries == {"a": 1, "bad": 1, "c": 2, "killed": 2, "lost": 1, "broken": 1}
    assert batch("merge", results)[0] == 0
    rows = rows_of(results)
    assert {name: row["state"] for name, row in rows.items()} == {
        "a": "done", "bad": "failed", "broken": "failed", "c": "done", "killed": "failed", "lost": "not trusted",
    }  # fmt: skip
    assert rows["bad"]["cause"] == "bad data (3)"
    assert "made to fail" in rows["bad"]["message"]
    assert rows["killed"]["cause"] == "ended by signal 9 (memory?)"
    assert rows["lost"]["message"] == "motion lost in 1 of 1 scans"
    sums = json.loads((results / "sums.json").read_text())
    assert sums["points"] == 4 + 6 + 8
    assert sums["driven_m"] == 150  # three drives from (0, 0) to (30, 40)
    assert sums["objects_per_km"] == pytest.approx(6 / 0.150)
    page = (results / "index.html").read_text()
    assert "bad data (3)" in page
    assert 'href="a/summary.json"' in page
    assert not (results / "bad").exists()  # nothing half-written


def test_a_repeated_run_does_what_is_not_done_or_has_another_hash(plan_of, results, fake, batch, calls, tmp_path):
    plan = plan_of(a=(4, ""), bad=(5, "3"), c=(6, "once 9"))
    run = ("run", plan, "-o", results, "--command", fake, "--retries", 0)
    assert batch(*run)[0] == 75
    assert batch(*run)[0] == 3
    assert collections.Counter(calls()) == {"a": 1, "bad": 2, "c": 2}
    (tmp_path / "drives" / "bad" / "exit").unlink()
    os.utime(tmp_path / "drives" / "a" / "times.txt", ns=(1, 1))
    assert batch(*run)[0] == 3  # the plan says what was there when it was made
    assert batch("merge", results)[0] == 0
    assert "changed since the plan was made" in rows_of(results)["bad"]["message"]
    assert rows_of(results)["a"]["state"] == "done"
    batch("plan", tmp_path / "drives", "-o", plan)
    assert batch(*run)[0] == 0
    assert collections.Counter(calls()) == {"a": 2, "bad": 3, "c": 2}
    assert not list((results / ".failed").iterdir())
    assert not list((results / ".attempts").iterdir())


def test_index_is_one_line_of_the_plan(plan_of, results, fake, batch, calls):
    plan = plan_of(a=(4, ""), b=(5, "4"))
    assert batch("run", plan, "-o", results, "--command", fake, "--index", 1)[0] == 4
    assert calls() == ["b"]
    record = json.loads((results / "b" / "_SUCCESS.json").read_text())
    assert (record["points"], record["scans"], record["driven_m"]) == (5, 1, 50.0)
    code, _, err = batch("run", plan, "-o", results, "--index", 2)
    assert code == 2
    assert "lines 0 to 1" in err


def test_a_second_task_for_a_drive_ends_with_try_again(plan_of, results, fake, batch, calls):
    plan = plan_of(a=(4, ""))
    (results / ".attempts").mkdir(parents=True)
    with (results / ".attempts" / "a.lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        code, _, err = batch("run", plan, "-o", results, "--command", fake, "--index", 0)
    assert code == 75
    assert "another task labels this drive" in err
    assert calls() == []
    assert batch("run", plan, "-o", results, "--command", fake, "--index", 0)[0] == 0


WAITING_DETECT = """
import fcntl, signal
file = open({alive!r}, 'w')
fcntl.flock(file, fcntl.LOCK_EX)
open({fifo!r}, 'w').close()
signal.pause()
"""


@pytest.fixture
def waiting(tmp_path):
    """A detect that never ends: start(arguments of batch) returns once it runs; ended() once it has ended."""
    script, alive, fifo = tmp_path / "waits.py", tmp_path / "alive", tmp_path / "fifo"
    script.write_text(WAITING_DETECT.format(alive=str(alive), fifo=str(fifo)))
    os.mkfifo(fifo)

    def start(*arguments):
        command = [sys.executable, "-m", "mapless", "batch", *arguments, "--command", f"{sys.executable} {script}"]
        process = subprocess.Popen([str(part) for part in command], stderr=subprocess.PIPE, text=True)
        fifo.open().close()
        return process

    def ended():
        signal.alarm(20)  # otherwise a detect that is left would block for ever
        with alive.open() as file:
            fcntl.flock(file, fcntl.LOCK_EX)
        signal.alarm(0)

    return start, ended


def test_a_killed_task_ends_its_detect_too(plan_of, results, waiting, fake, batch):
    start, ended = waiting
    plan = plan_of(a=(4, ""))
    task = start("run", plan, "-o", results, "--index", "0")
    task.kill()
    task.communicate()
    ended()
    assert not (results / "a").exists()
    partial = results / ".attempts" / "a" / "result" / "labels" / ".000000.label.partial-1-1"
    partial.parent.mkdir(parents=True)
    partial.touch()
    assert batch("merge", results, "--plan", plan)[0] == 0
    assert rows_of(results)["a"]["cause"].startswith("started and not ended")
    assert batch("run", plan, "-o", results, "--index", 0, "--command", fake)[0] == 0
    assert [file.name for file in (results / "a" / "labels").iterdir()] == ["000000.label"]


def test_ctrl_c_ends_all_and_the_same_command_goes_on(plan_of, results, waiting, fake, batch):
    start, ended = waiting
    plan = plan_of(a=(4, ""), b=(5, ""))
    run = start("run", plan, "-o", results, "--jobs", 1)
    run.send_signal(signal.SIGINT)
    _, err = run.communicate()
    ended()
    assert run.returncode == 130
    assert "the same command goes on" in err
    assert not (results / "a").exists()
    assert batch("run", plan, "-o", results, "--command", fake)[0] == 0


def test_the_real_detect_gives_the_bytes_of_one_call(drive, tmp_path, batch):
    plan, results = tmp_path / "plan", tmp_path / "results"
    assert batch("plan", drive, "-o", plan, "--evaluate", "--view", 4, "--options=--odometry")[0] == 0
    assert batch("run", plan, "-o", results)[0] == 0
    mapless.detect(drive, tmp_path / "single", odometry=True)
    files = [p.relative_to(tmp_path / "single") for p in (tmp_path / "single").rglob("*") if p.is_file()]
    same = [f for f in files if f.name != "summary.json"]  # it has times
    assert len(same) > 14
    for file in same:
        assert (results / "native" / file).read_bytes() == (tmp_path / "single" / file).read_bytes(), file
    record = json.loads((results / "native" / "_SUCCESS.json").read_text())
    labels = mapless.evaluate(drive, tmp_path / "single")["final"]
    assert record["true_positives"] == labels["tp"] > 0
    assert record["false_negatives"] == labels["fn"]
    assert (results / "native" / "viewer.html").read_text().startswith("<!")
    assert batch("merge", results)[0] == 0
    assert 'href="native/viewer.html"' in (results / "index.html").read_text()


def test_merge_writes_parquet(plan_of, results, fake, batch):
    parquet = pytest.importorskip("pyarrow.parquet")
    batch("run", plan_of(a=(4, ""), bad=(5, "3")), "-o", results, "--command", fake)
    batch("merge", results)
    table = parquet.read_table(results / "drives.parquet").to_pylist()
    assert [(row["id"], row["points"], row["exit_code"]) for row in table] == [("a", 4, 0), ("bad", None, 3)]


def test_the_progress_line_has_rate_time_left_and_failures(capsys):
    bar = progress.Progress()
    bar.start(10, 0)
    bar.add(True)
    bar.add(False)
    assert bar.line(bar._started + 4.0) == "2 of 10 drives, 30.0 drives/min, 16 s left, 1 failed"


@pytest.mark.parametrize("id", ["../outside", "/tmp/outside", "..", ".hidden", "a/b", ""])
def test_no_id_in_a_plan_leads_out_of_the_results(id, plan_of, results, fake, batch, calls):
    plan = plan_of(a=(4, ""))
    task = dataclasses.replace(read_task(str(plan), 0), id=id)
    plan.write_text(task.line())
    for index in ([], ["--index", 0]):
        code, _, err = batch("run", plan, "-o", results, "--command", fake, *index)
        assert code == 2
        assert "not a name" in err
    assert calls() == []


def test_a_plan_that_is_no_text_is_refused(results, fake, batch, tmp_path):
    (tmp_path / "plan.jsonl").write_bytes(bytes(range(128, 256)))
    code, _, err = batch("run", tmp_path / "plan.jsonl", "-o", results, "--command", fake)
    assert code == 3
    assert "not a plan" in err

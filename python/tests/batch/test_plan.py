"""Finding drives."""

import json
import os
import shutil


def read(plan):
    return [json.loads(line) for line in plan.read_text().splitlines()]


def test_a_plan_has_every_readable_drive_once_and_is_the_same_on_each_run(tmp_path, make_drive, batch):
    root = tmp_path / "drives"
    make_drive(root / "b", 4)
    make_drive(root / "town" / "a", 5)
    make_drive(root / "damaged", 6)
    (root / "damaged" / "sensor.yaml").write_text("name: [")
    shutil.copytree(root / "b", root / "b_copied")
    os.symlink(root / "b", root / "a_link")
    (root / "notes").mkdir()
    plan = tmp_path / "plan.jsonl"
    code, out, err = batch("plan", root, "-o", plan)
    assert code == 4  # the plan is there; stderr says what is not in it
    assert "2 drives" in out
    first = plan.read_bytes()
    lines = read(plan)
    assert [line["id"] for line in lines] == ["b", "town.a"]
    assert [(line["format"], line["sensor"], line["scans"]) for line in lines] == [("native", "two", 1)] * 2
    refused = [line for line in err.splitlines() if "refused" in line]
    assert len(refused) == 3
    assert f"{root / 'a_link'}: the same drive as {root / 'b'}" in refused[0]
    assert f"{root / 'b_copied'}: a copy of {root / 'b'}" in refused[1]
    assert f"{root / 'damaged'}" in refused[2]
    batch("plan", root, "-o", plan)
    assert plan.read_bytes() == first


def test_drives_of_equal_sizes_and_different_content_are_two(tmp_path, make_drive, batch):
    make_drive(tmp_path / "drives" / "a", 4)
    (make_drive(tmp_path / "drives" / "b", 4) / "times.txt").write_text("1.0\n")
    assert batch("plan", tmp_path / "drives", "-o", tmp_path / "plan")[0] == 0
    assert len(read(tmp_path / "plan")) == 2


def test_the_hash_changes_with_options_and_with_the_input(tmp_path, make_drive, batch):
    drive, plan = make_drive(tmp_path / "drives" / "a", 4), tmp_path / "plan"

    def hash_of(*options):
        batch("plan", tmp_path / "drives", "-o", plan, *options)
        return read(plan)[0]["hash"]

    first = hash_of()
    assert hash_of() == first
    causal = hash_of("--options=--causal")
    assert causal != first
    assert read(plan)[0]["options"] == ["--causal"]
    os.utime(drive / "times.txt", ns=(1, 1))
    assert hash_of() != first


def test_ids_of_several_roots_begin_with_their_names(tmp_path, make_drive, batch):
    make_drive(tmp_path / "one" / "a", 4)
    make_drive(tmp_path / "two" / "a", 5)
    batch("plan", tmp_path / "two", tmp_path / "one", "-o", tmp_path / "plan")
    assert [line["id"] for line in read(tmp_path / "plan")] == ["one.a", "two.a"]


def test_no_drive_is_bad_data_and_leaves_no_plan(tmp_path, batch):
    code, _, err = batch("plan", tmp_path, "-o", tmp_path / "plan")
    assert code == 3
    assert "no drive that can be read" in err
    assert not (tmp_path / "plan").exists()
    assert batch("plan", tmp_path / "none", "-o", tmp_path / "plan")[0] == 3


def test_a_folder_whose_name_is_not_utf8_is_refused_by_name_and_the_others_planned(tmp_path, make_drive, batch):
    make_drive(tmp_path / "drives" / "a", 4)
    (tmp_path / "drives" / "b\udcff").mkdir()
    code, _, err = batch("plan", tmp_path / "drives", "-o", tmp_path / "plan")
    assert [line["id"] for line in read(tmp_path / "plan")] == ["a"]
    assert "is not UTF-8; rename the file or folder" in err
    assert code == 4


def test_a_plan_into_a_folder_is_refused_by_name(tmp_path, make_drive, batch):
    make_drive(tmp_path / "drives" / "a", 4)
    code, _, err = batch("plan", tmp_path / "drives", "-o", tmp_path / "drives")
    assert code == 1
    assert err.splitlines()[-1] == f"mapless: error: {tmp_path}/drives: Is a directory; check the path and its permissions"


def test_a_line_that_was_edited_is_refused(tmp_path, make_drive, batch):
    make_drive(tmp_path / "drives" / "a", 4)
    plan = tmp_path / "plan"
    batch("plan", tmp_path / "drives", "-o", plan)
    plan.write_text(plan.read_text().replace('"options": []', '"options": ["--causal"]'))
    code, _, err = batch("run", plan, "-o", tmp_path / "out", "--index", "0")
    assert code == 2
    assert "drive a: its hash does not fit the line" in err


def test_a_line_of_a_hundred_thousand_brackets_is_refused_by_name(tmp_path, batch):
    plan = tmp_path / "plan"
    plan.write_text("[" * 100_000 + "\n")
    code, _, err = batch("run", plan, "-o", tmp_path / "results")
    assert code == 2
    assert err.strip().splitlines()[-1].startswith(f"mapless: error: {plan} line 1: not a line of a plan")

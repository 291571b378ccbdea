"""The part of try_bad_inputs.py that needs Python: bags of ROS 1 and 2, MCAP, folders of NumPy arrays, PLY and LAS, and
the lists of `mapless batch`, whole and damaged, by `python -m mapless` (rosbags, laspy: what is missing is left out)."""

import json
import shutil

from try_bad_inputs import BAD_DATA, DOUBTFUL, FULL, REFUSED, WRONG_USE, damages, remove

# Run by the interpreter that has mapless: makes the inputs of a native recording.
MAKER = r'''
import pathlib, sys
import numpy as np
import mapless
sys.path.insert(0, sys.argv[3])
native, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
rows = np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity", "ring", "time")])
scans = list(mapless.open(native))
def tables():
    for scan in scans:
        table = np.zeros(len(scan), rows)
        for i, name in enumerate("xyz"):
            table[name] = scan.points[:, i]
        table["ring"], table["time"] = scan.ring, scan.time_s
        yield table[np.isfinite(table["x"])]
def ply(file, table):
    names = "".join(f"property float {name}\n" for name in table.dtype.names)
    file.write_bytes(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(table)}\n{names}end_header\n".encode() + table.tobytes())
def las(file, table):
    import laspy
    points = laspy.create(point_format=0, file_version="1.2")
    points.header.scales = [1e-5] * 3
    for name in ("ring", "time"):
        points.add_extra_dim(laspy.ExtraBytesParams(name=name, type=np.float32))
        points[name] = table[name]
    points.x, points.y, points.z = table["x"], table["y"], table["z"]
    points.write(str(file))
for suffix, write in ((".npy", np.save), (".ply", ply), (".las", las)):
    folder = out / suffix[1:]
    folder.mkdir(parents=True)
    try:
        for k, table in enumerate(tables()):
            write(folder / f"{k:06}{suffix}", table)
        (folder / "times.txt").write_text((native / "times.txt").read_text())
    except ImportError as error:
        print(error, file=sys.stderr)
        import shutil; shutil.rmtree(folder)
try:
    import test_bags
except BaseException as error:  # pytest skips without rosbags
    print(error, file=sys.stderr)
else:
    for suffix in (".bag", ".mcap", ".db3"):
        test_bags.write(out / ("bag" + suffix.replace(".", "_") + suffix), test_bags.clouds_of(scans, test_bags.VELODYNE, test_bags.velodyne))
'''


def run_batch(battery, name, work, program):
    """RESULTS keeps the reasons of drives that failed, and the last line counts them; 75 where a plan has a drive twice,
    of which the second is in use: it is found done when it is tried again."""
    if not battery.wants(name):
        return
    code, err, _ = battery.command("batch", "run", work / "bad.jsonl", "-o", work / "results", program=program)
    battery.judge(name, code, err, REFUSED | {0, FULL}, counted=" failed: " in err.strip().splitlines()[-1])
    remove(work / "results")


def try_batch(battery, bases, program):
    work = battery.work / "batch"
    remove(work)
    (work / "drives").mkdir(parents=True)
    shutil.copytree(bases.work / "native", work / "drives" / "one")
    plan = work / "plan.jsonl"
    code, err, _ = battery.command("batch", "plan", work / "drives", "-o", plan, program=program)
    if code != 0:
        battery.judge("python: batch plan", code, err, {0})
        return
    line = json.loads(plan.read_text().splitlines()[0])
    changed = {name: {**line, name: value} for name in line for value in (None, "../../out", -1)}
    texts = {f"{name} changed": json.dumps(text) + "\n" for name, text in changed.items()}
    texts |= {"twice the same line": 2 * plan.read_text(), "a list": "[]\n", "nothing": "", "a number": "1e999\n",
              "deep": "[" * 100000 + "\n"}
    bad = work / "bad.jsonl"
    for what, text in texts.items():
        bad.write_text(text)
        run_batch(battery, f"python: batch run, {what}", work, program)
        if (work.parent.parent / "out").exists():
            battery.judge(f"python: batch run, {what}", 0, "", {0}, ["a folder outside RESULTS"])
    for damage, spoil in damages(plan):
        shutil.copy(plan, bad)
        spoil(bad)
        run_batch(battery, f"python: batch run, plan {damage}", work, program)
        remove(bad)
    battery.case("python: batch merge of nothing", ["batch", "merge", work / "none"], REFUSED, [], program)
    battery.case("python: batch plan of nothing", ["batch", "plan", work / "none", "-o", bad], REFUSED | {DOUBTFUL}, [bad], program)
    battery.case("python: batch run --index 7", ["batch", "run", plan, "-o", work / "results", "--index", "7"],
                 {WRONG_USE, BAD_DATA}, [work / "results"], program)


def try_python(battery, bases, python):
    inputs, spoilt, out = battery.work / "python", battery.work / "spoilt", battery.work / "out"
    tests = bases.tests
    program = [python, "-m", "mapless"]
    code, err, _ = battery.command("-c", MAKER, bases.work / "native", inputs, tests, program=[python])
    if code != 0:
        battery.judge("python: makes the inputs", code, err, {0})
        return
    for drive in sorted(inputs.iterdir()):
        battery.case(f"python: {drive.name}: whole", ["info", drive], {0}, [], program)
        files = [drive] if drive.is_file() else sorted(f for f in drive.rglob("*") if f.is_file())
        files = [f for f in files if not f.stem.isdigit() or f.stem == "000005"]
        for file in files:
            for damage, spoil in damages(file):
                name = f"python: {drive.name}: {file.name} {damage}"
                if not battery.wants(name):
                    continue
                remove(spoilt)
                spoilt.mkdir()
                copy = spoilt / drive.name
                shutil.copytree(drive, copy) if drive.is_dir() else shutil.copy(drive, copy)
                spoil(copy / file.relative_to(drive) if drive.is_dir() else copy)
                battery.case(name, ["detect", copy, "-o", out, "--sensor", "VLP-16"], {0, DOUBTFUL} | REFUSED, [], program)
                remove(out)
    if not battery.only or any("batch" in text or "python" in text for text in battery.only):
        try_batch(battery, bases, program)

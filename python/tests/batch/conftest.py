"""Drives of one scan in the native format, and a detect that writes a result in milliseconds."""

import pathlib
import shlex
import sys

import pytest

SENSOR = """name: two
rate_hz: 10
direction: -1
columns: 4
start_azimuth_deg: 180
min_range_m: 1
max_range_m: 50
lasers:
  - {elevation_deg: -1, azimuth_offset_deg: 0, origin_m: [0, 0, 0]}
  - {elevation_deg: 1, azimuth_offset_deg: 0, origin_m: [0, 0, 0]}
"""

# Points: the size of times.txt. A file named `exit` in the drive says how to end; "once 9": so at the first call; "wait":
# with 0, once a file `go` lies beside the drives, and its process is named there.
FAKE_DETECT = '''
import json, os, pathlib, signal, sys, time
drive, out = pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[sys.argv.index("-o") + 1])
with open(os.environ["MAPLESS_TEST_CALLS"], "a") as calls:
    calls.write(drive.name + "\\n")
(out / "labels").mkdir(parents=True, exist_ok=True)
(out / "labels" / "000000.label").write_bytes(b"half")
how = drive / "exit"
code = how.read_text() if how.exists() else "0"
if code.startswith("once "):
    code = code[5:] if open(os.environ["MAPLESS_TEST_CALLS"]).read().split().count(drive.name) == 1 else "0"
if code == "wait":
    (drive.parent / f"{drive.name}.pid").write_text(str(os.getpid()))
while code == "wait":
    time.sleep(0.05)
    code = "0" if (drive.parent / "go").exists() else "wait"
if code == "9":
    os.kill(os.getpid(), signal.SIGKILL)
if code not in ("0", "4"):
    print(f"mapless: error: {drive}: made to fail", file=sys.stderr)
    sys.exit(int(code))
if code == "4":
    print("mapless: motion lost in 1 of 1 scans", file=sys.stderr)
(out / "labels" / "000000.label").write_bytes(b"\\x09\\x00\\x00\\x00")
points = (drive / "times.txt").stat().st_size
(out / "poses_kitti.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\\n1 0 0 30 0 1 0 40 0 0 1 0\\n")
summary = {"scans": 1, "points": points, "dynamic_points": 1, "objects": 2, "objects_over_time": 2}
(out / "summary.json").write_text(json.dumps({**summary, "sensor": "two", "peak_memory_mb": 1.5}))
sys.exit(int(code))
'''


@pytest.fixture
def make_drive():
    """A recording that can be opened; `size` is that of times.txt, by which drives differ."""

    def make(folder: pathlib.Path, size: int, how: str = "") -> pathlib.Path:
        (folder / "scans").mkdir(parents=True)
        (folder / "sensor.yaml").write_text(SENSOR)
        (folder / "times.txt").write_text("0.0\n".rjust(size, "0"))
        header = "VERSION 0.7\nFIELDS x y z t code\nSIZE 4 4 4 4 1\nTYPE F F F U U\nCOUNT 1 1 1 1 1\nWIDTH 4\nHEIGHT 2\n"
        header += "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 8\nDATA binary\n"
        (folder / "scans" / "000000.pcd").write_bytes(header.encode() + bytes(8 * 17))
        if how:
            (folder / "exit").write_text(how)
        return folder

    return make


@pytest.fixture
def calls(tmp_path, monkeypatch):
    """The drives for which detect was called, in order."""
    file = tmp_path / "calls"
    file.touch()
    monkeypatch.setenv("MAPLESS_TEST_CALLS", str(file))
    return lambda: file.read_text().split()


@pytest.fixture
def fake(tmp_path) -> str:
    """For --command."""
    script = tmp_path / "fake_detect.py"
    script.write_text(FAKE_DETECT)
    return shlex.join([sys.executable, "-S", "-E", str(script)])


@pytest.fixture
def batch(capfd):
    """The verb in this process: exit code, stdout, stderr."""
    from mapless.batch.command import main

    def run(*arguments):
        capfd.readouterr()
        code = main([str(a) for a in arguments])
        return (code, *capfd.readouterr())

    return run


@pytest.fixture
def slurm(tmp_path_factory, calls):
    """run(program, *arguments) upon a Slurm of one node with two cores."""
    from slurm_daemons import reason_not_to_start, slurm_node

    reason = reason_not_to_start()
    if reason is not None:
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp("slurm")
    try:
        with slurm_node(folder) as run:
            yield run
    except RuntimeError as error:
        logs = [line for log in folder.glob("*.out") for line in log.read_text(errors="replace").splitlines()[-3:]]
        pytest.skip(f"Slurm does not start here: {error}: {logs}")

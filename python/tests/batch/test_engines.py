"""The engines: each labels the same plan and leaves the same bytes. A test is skipped where its engine is not installed."""

import collections
import json
import os
import pathlib
import shutil
import subprocess
import sys
import threading
import time

import pytest

EXAMPLES = pathlib.Path(__file__).parents[3] / "examples" / "fleet"


@pytest.fixture
def plan(tmp_path, make_drive, batch, calls):
    """Five drives, the third of which is damaged."""
    for k in range(5):
        make_drive(tmp_path / "drives" / f"d{k}", 4 + k, "3" if k == 2 else "")
    assert batch("plan", tmp_path / "drives", "-o", tmp_path / "plan.jsonl")[0] == 0
    return tmp_path / "plan.jsonl"


@pytest.fixture
def path_with_mapless(tmp_path, fake, monkeypatch):
    """PATH on which `mapless` is that of this package, with the fake detect."""
    folder = tmp_path / "bin"
    folder.mkdir()
    script = folder / "mapless"
    script.write_text(
        "#!/bin/sh\n"
        f'case "$1 $2" in "batch run") exec "{sys.executable}" -m mapless "$@" --command \'{fake}\';; esac\n'
        f'exec "{sys.executable}" -m mapless "$@"\n'
    )
    script.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")


def require_all_but_the_damaged(results, calls):
    assert collections.Counter(calls()) == {"d0": 1, "d1": 1, "d2": 1, "d3": 1, "d4": 1}
    for k in (0, 1, 3, 4):
        record = json.loads((results / f"d{k}" / "_SUCCESS.json").read_text())
        assert record["points"] == 4 + k
        assert (results / f"d{k}" / "labels" / "000000.label").read_bytes() == b"\x09\0\0\0"
    assert json.loads((results / ".failed" / "d2.json").read_text())["exit_code"] == 3


def test_ray(plan, tmp_path, fake, batch, calls, monkeypatch):
    ray = pytest.importorskip("ray")
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        code, _, err = batch("run", plan, "-o", tmp_path / "results", "--command", fake, "--ray")
    finally:
        ray.shutdown()
    assert code == 3
    assert "4 drives labelled, 0 were done, 1 failed" in err
    require_all_but_the_damaged(tmp_path / "results", calls)


def wait_until(condition):
    end = time.monotonic() + 60
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)


@pytest.fixture
def ray_nodes(monkeypatch, calls):
    """A cluster of two nodes with a core each, and the node that is not the head. Its processes have the environment of now."""
    pytest.importorskip("ray")
    from ray import init, shutdown
    from ray.cluster_utils import Cluster

    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    second = cluster.add_node(num_cpus=1)
    cluster.wait_for_nodes()
    init(address=cluster.address, log_to_driver=False)
    yield cluster, second
    shutdown()
    cluster.shutdown()


def test_the_drive_of_a_lost_ray_node_is_labelled_on_another(ray_nodes, tmp_path, make_drive, fake, batch, calls):
    cluster, second = ray_nodes
    drives = tmp_path / "drives"
    for k in range(5):
        make_drive(drives / f"d{k}", 4 + k, "wait")
    assert batch("plan", drives, "-o", tmp_path / "plan.jsonl")[0] == 0

    def lose_the_second_node():
        wait_until(lambda: len(list(drives.glob("*.pid"))) == 2)  # one drive on each node
        running = [pathlib.Path("/proc") / file.read_text() for file in drives.glob("*.pid")]
        cluster.remove_node(second, allow_graceful=False)  # ends its processes with SIGKILL
        wait_until(lambda: not all(process.exists() for process in running))
        (drives / "go").touch()

    killer = threading.Thread(target=lose_the_second_node)
    killer.start()
    code, _, err = batch("run", tmp_path / "plan.jsonl", "-o", tmp_path / "results", "--command", fake, "--ray")
    killer.join()
    assert (code, "5 drives labelled, 0 were done, 0 failed" in err) == (0, True)
    assert sorted(collections.Counter(calls()).values()) == [1, 1, 1, 1, 2]  # again: that of the lost node alone
    for k in range(5):
        assert json.loads((tmp_path / "results" / f"d{k}" / "_SUCCESS.json").read_text())["points"] == 4 + k


def test_snakemake(plan, tmp_path, batch, calls, path_with_mapless, monkeypatch):
    snakemake = os.environ.get("MAPLESS_SNAKEMAKE") or shutil.which("snakemake")
    if snakemake is None:
        pytest.skip("snakemake is not installed")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    command = [snakemake, "--snakefile", EXAMPLES / "Snakefile", "--cores", "2", "--keep-going", "--quiet"]
    config = ["--config", f"plan={plan}", f"results={tmp_path / 'results'}"]
    first = subprocess.run([*command, *config], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert first.returncode == 1, first.stderr  # the damaged drive
    require_all_but_the_damaged(tmp_path / "results", calls)
    (tmp_path / "drives" / "d2" / "exit").unlink()
    batch("plan", tmp_path / "drives", "-o", plan)
    command += ["--rerun-triggers", "mtime"]
    second = subprocess.run([*command, *config], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert second.returncode == 0, second.stderr
    assert "5 done" in (tmp_path / "results" / "index.html").read_text()
    assert calls()[5:] == ["d2"]


def test_the_job_of_kubernetes_fits_the_schema():
    validate = pytest.importorskip("kubernetes_validate")
    yaml = pytest.importorskip("yaml")
    job = yaml.safe_load((EXAMPLES / "kubernetes.yaml").read_text())
    validate.validate(job, "1.33", strict=True)
    job["spec"]["backoffLimitPerIndex"] = "three"
    with pytest.raises(validate.ValidationError):
        validate.validate(job, "1.33", strict=True)


def test_slurm(plan, tmp_path, path_with_mapless, slurm, calls):
    results = tmp_path / "results"
    job = ["--array=0-2", "--mem=0", f"--output={tmp_path}/slurm-%a.out", EXAMPLES / "slurm.sh", plan, results]
    done = slurm("sbatch", "--wait", *job)
    assert done.returncode == 3, (done.stderr, *(f.read_text() for f in tmp_path.glob("slurm-*.out")))
    require_all_but_the_damaged(results, calls)

"""Recordings, plan and results in an object store on this machine: s3:// on moto, gs:// on gcp-storage-emulator."""

import json
import socket

import pytest

fsspec = pytest.importorskip("fsspec")


@pytest.fixture
def s3(monkeypatch):
    """File system with an empty bucket `drives`."""
    pytest.importorskip("s3fs")
    moto = pytest.importorskip("moto.server").ThreadedMotoServer(port=0, verbose=False)
    moto.start()
    host, port = moto.get_host_and_port()
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://{host}:{port}")
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "test")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "test")
    monkeypatch.setenv("AWS_DEFAULT_REGION", "us-east-1")
    system = fsspec.filesystem("s3", use_listings_cache=False, skip_instance_cache=True)
    system.mkdir("drives")
    yield system
    moto.stop()


@pytest.fixture
def gs(monkeypatch):
    """As s3, of Google Cloud Storage."""
    pytest.importorskip("gcsfs")
    emulator = pytest.importorskip("gcp_storage_emulator.server")
    with socket.socket() as free:
        free.bind(("localhost", 0))
        port = free.getsockname()[1]
    server = emulator.create_server("localhost", port, in_memory=True, default_bucket="drives")
    server.start()
    monkeypatch.setenv("STORAGE_EMULATOR_HOST", f"http://localhost:{port}")
    monkeypatch.setenv("GOOGLE_CLOUD_PROJECT", "test")
    yield fsspec.filesystem("gs", use_listings_cache=False, skip_instance_cache=True)
    server.stop()


@pytest.mark.parametrize("scheme", ["s3", "gs"])
def test_drives_plan_and_results_in_an_object_store(scheme, request, tmp_path, make_drive, batch, fake, calls):
    bucket = request.getfixturevalue(scheme)
    for k in range(2):
        bucket.put(str(make_drive(tmp_path / f"d{k}", 4 + k)), f"drives/town/d{k}", recursive=True)
    plan, results = f"{scheme}://drives/plan.jsonl", f"{scheme}://drives/results"
    assert batch("plan", f"{scheme}://drives/town", "-o", plan)[0] == 0
    lines = [json.loads(line) for line in bucket.cat_file("drives/plan.jsonl").splitlines()]
    assert [(line["id"], line["path"]) for line in lines] == [(f"d{k}", f"{scheme}://drives/town/d{k}") for k in range(2)]
    assert [(line["format"], line["scans"]) for line in lines] == [("native", None)] * 2
    run = ("run", plan, "-o", results, "--command", fake, "--scratch", tmp_path)
    code, _, err = batch(*run)
    assert code == 0, err
    assert batch(*run)[0] == 0
    assert sorted(calls()) == ["d0", "d1"]  # not again
    assert bucket.cat_file("drives/results/d1/labels/000000.label") == b"\x09\0\0\0"
    assert not list(tmp_path.glob("mapless-*"))  # what was fetched is gone
    assert batch("merge", results)[0] == 0
    assert json.loads(bucket.cat_file("drives/results/sums.json"))["points"] == 4 + 5

    bucket.pipe_file("drives/town/d1/times.txt", b"0.0\n")
    batch("plan", f"{scheme}://drives/town", "-o", plan)
    assert batch(*run)[0] == 0
    assert sorted(calls()) == ["d0", "d1", "d1"]
    assert batch("run", plan, "-o", results, "--index", 0)[0] == 0

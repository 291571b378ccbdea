"""The code on the page docs/python.md runs."""

import pathlib
import re

import pytest

import mapless
from comparison import compact

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "python.md"


def test_the_code_of_the_page_runs(scans, tmp_path, monkeypatch):
    if not PAGE.is_file():
        pytest.skip(f"{PAGE}: not there")
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 2
    monkeypatch.chdir(tmp_path)
    returns = [compact(scan) for scan in scans]
    names = {
        "driver": [(s.points[k], s.time_s[k], s.ring[k], s.stamp_ns) for s, k in zip(scans, returns, strict=True)],
        "clouds": [s.points[k] for s, k in zip(scans, returns, strict=True)],
    }
    exec(compile(blocks[0], str(PAGE), "exec"), names)
    assert names["static"].shape[1] == 3
    names = {"mapless": mapless}
    exec(compile(blocks[1], str(PAGE), "exec"), names)
    assert len(names["result"]) == 20

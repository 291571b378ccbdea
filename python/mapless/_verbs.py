"""The verbs of the command as functions."""

from __future__ import annotations

import json
import os
import pathlib
import subprocess
import sys
import warnings
from typing import Any

from mapless._result import Result


NOT_TRUSTED = 4  # exit code: finished, but the result is not trustworthy


class CommandError(RuntimeError):
    """A verb has failed; its message says what to do. `exit_code` is that of the command (docs/reliability.md)."""

    def __init__(self, message: str, exit_code: int) -> None:
        super().__init__(message)
        self.exit_code = exit_code


def detect(recording: str | os.PathLike[str], output: str | os.PathLike[str], **options: Any) -> Result:
    """Labels a recording: `mapless detect RECORDING -o OUTPUT`. Options are those of the command with _ for -:
    `overwrite=True`, `count=50`, `trajectory="poses.txt"`, `topic="/points"`, `set=["forward_gap=0"]`.

    Raises CommandError with the message of the command; warns where the result is not trustworthy."""
    run_verb("detect", os.fspath(recording), "--output", os.fspath(output), **options)
    return Result(output)


def detect_rig(recording: str | os.PathLike[str], output: str | os.PathLike[str], **options: Any) -> dict[str, Result]:
    """`detect` for the recording of several lidars on one vehicle (a folder with rig.yaml): the result of each sensor, by
    its name. Each is a folder of `output`."""
    run_verb("detect", os.fspath(recording), "--output", os.fspath(output), **options)
    folders = sorted(path for path in pathlib.Path(output).iterdir() if (path / "labels").is_dir())
    return {path.name: Result(path) for path in folders}


def simulate(scene: str, output: str | os.PathLike[str], **options: Any) -> None:
    """Writes a simulated recording with true labels: `mapless simulate SCENE -o OUTPUT`, "crossing" for example.
    `rig="rig.yaml"`: one of several sensors on a vehicle."""
    run_verb("simulate", scene, "--output", os.fspath(output), **options)


def evaluate(recording: str | os.PathLike[str], result: str | os.PathLike[str], **options: Any) -> dict[str, Any]:
    """Compares a result with the true labels of its recording: `mapless evaluate RECORDING RESULT --json -`."""
    text = run_verb("evaluate", os.fspath(recording), os.fspath(result), "--json", "-", **options)
    report: dict[str, Any] = json.loads(text)
    return report


def explain(
    recording: str | os.PathLike[str], result: str | os.PathLike[str], *, scan: int, point: int, **options: Any
) -> dict[str, Any]:
    """Why a point of a result is moving or static, with every figure: `mapless explain RECORDING RESULT --json`.
    `point`: its number in the input."""
    text = run_verb(
        "explain", os.fspath(recording), os.fspath(result), "--json", scan=scan, point=point, **options
    )
    explanation: dict[str, Any] = json.loads(text)
    return explanation


def run_verb(verb: str, *arguments: str, **options: Any) -> str:
    """What the verb prints. In a process of its own, so that Ctrl-C ends the verb and not Python."""
    command = [sys.executable, "-m", "mapless", verb, *arguments, *_flags(options)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode == NOT_TRUSTED:
        warnings.warn(f"mapless {verb}: the result is not trustworthy\n{done.stderr.strip()}", RuntimeWarning, stacklevel=3)
    elif done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if line.startswith("mapless: error: ")]
        message = lines[-1].removeprefix("mapless: error: ") if lines else done.stderr.strip()
        raise CommandError(message or f"mapless {verb}: exit code {done.returncode}", done.returncode)
    return done.stdout


def _flags(options: dict[str, Any]) -> list[str]:
    flags: list[str] = []
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        if value is True:
            flags.append(flag)
        elif value is not False and value is not None:
            for one in value if isinstance(value, (list, tuple)) else [value]:
                flags += [flag, str(one)]
    return flags

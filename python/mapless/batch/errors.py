"""Exit codes and the error of `mapless batch` (docs/reliability.md)."""

from __future__ import annotations

import enum


class ExitCode(enum.IntEnum):
    SUCCESS = 0
    FAILURE = 1
    USAGE = 2
    BAD_INPUT = 3
    NOT_TRUSTED = 4
    TEMPORARY = 75
    INTERRUPTED = 130


FINISHED = (ExitCode.SUCCESS, ExitCode.NOT_TRUSTED)


class BatchError(RuntimeError):
    """One line that names the file or option, what is wrong with it, and what to do."""

    def __init__(self, message: str, exit_code: int = ExitCode.USAGE) -> None:
        super().__init__(message)
        self.exit_code = int(exit_code)


def can_succeed_later(exit_code: int) -> bool:
    """A full disk, a folder in use, or a process ended by a signal: memory, a lost node, Ctrl-C."""
    return exit_code == ExitCode.TEMPORARY or exit_code > 128 or exit_code < 0


def cause(exit_code: int) -> str:
    """What a failure counts as in the table of failures."""
    if exit_code < 0 or exit_code > 128:
        number = -exit_code if exit_code < 0 else exit_code - 128
        return "ended by signal 9 (memory?)" if number == 9 else f"ended by signal {number}"
    names: dict[int, str] = {
        ExitCode.FAILURE: "environment or program (1)",
        ExitCode.USAGE: "wrong usage (2)",
        ExitCode.BAD_INPUT: "bad data (3)",
        ExitCode.TEMPORARY: "full disk or folder in use (75)",
    }
    return names.get(exit_code, f"exit code {exit_code}")

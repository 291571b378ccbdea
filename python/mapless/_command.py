"""The command `mapless`: that of the C++ library, which reads the formats of Python too."""

from __future__ import annotations

import signal
import sys

from collections.abc import Mapping

from mapless import _core
from mapless._text import not_utf8
from mapless.readers import FORMATS, OPTIONS


def _open(path: str, format: str, sensor: str, given: Mapping[str, str]) -> _core.Recording | None:
    """_open.open_in_python. The readers and NumPy are loaded where a recording may be theirs."""
    if format and format not in FORMATS:
        return None
    from mapless._open import open_in_python

    return open_in_python(path, format, sensor, given)


def run(arguments: list[str]) -> int:
    """Runs the command with these arguments, without the name of the program; returns its exit code."""
    if (wrong := not_utf8(arguments)) is not None:
        print(f"mapless: error: argument {wrong}: is not UTF-8; rename the file or folder", file=sys.stderr)
        return 2
    _core.set_reader(_open, list(FORMATS), list(OPTIONS.items()))
    sys.stdout.flush()
    sys.stderr.flush()
    return _core.run_command(["mapless", *arguments])


def asks_for_mcap(words: list[str]) -> bool:
    """Whether an export is to give an MCAP file, which Python writes."""
    return "--cloud-format=mcap" in words or ("--cloud-format", "mcap") in zip(words, words[1:])


def main() -> None:
    if sys.argv[1:2] == ["batch"]:
        from mapless.batch.command import main as batch

        sys.exit(batch(sys.argv[2:]))
    if sys.argv[1:2] == ["evaluate"] and "--protocol" in sys.argv:
        from mapless.protocols import main as evaluate_protocol

        sys.exit(evaluate_protocol(sys.argv[2:]))
    if sys.argv[1:2] == ["export"] and asks_for_mcap(sys.argv[2:]):
        from mapless.mcap_export import main as export_mcap

        sys.exit(export_mcap(sys.argv[2:]))
    # Python would notice Ctrl-C only once the command has ended.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run(sys.argv[1:]))

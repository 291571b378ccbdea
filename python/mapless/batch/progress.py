"""One line on a terminal, redrawn; elsewhere a line every ten seconds."""

from __future__ import annotations

import sys
import time
from typing import TextIO

TERMINAL_PERIOD_S = 0.2
LOG_PERIOD_S = 10.0
BAR_COLUMNS = 24


def duration(seconds: float) -> str:
    minutes, s = divmod(int(seconds + 0.5), 60)
    hours, m = divmod(minutes, 60)
    return f"{hours} h {m:02d} min" if hours else f"{m} min {s:02d} s" if m else f"{s} s"


class Progress:
    """Drives done, rate, time left, failures."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream if stream is not None else sys.stderr
        self._terminal = self._stream.isatty()
        self._total = self._done = self._failed = 0
        self._started = self._shown = time.monotonic()

    def start(self, total: int, skipped: int) -> None:
        self._total = total
        self._started = self._shown = time.monotonic()
        if skipped:
            self._write(f"mapless: {skipped} drives are done\n")

    def add(self, succeeded: bool) -> None:
        self._done += 1
        self._failed += not succeeded
        now = time.monotonic()
        if now - self._shown >= (TERMINAL_PERIOD_S if self._terminal else LOG_PERIOD_S) or self._done == self._total:
            self._shown = now
            self._write(f"\r{self.line(now)}\033[K" if self._terminal else f"mapless: {self.line(now)}\n")

    def line(self, now: float) -> str:
        elapsed = max(now - self._started, 1e-9)
        rate = self._done / elapsed
        left = (self._total - self._done) / rate if rate > 0 else 0.0
        filled = BAR_COLUMNS * self._done // max(self._total, 1)
        bar = f"[{'#' * filled}{'.' * (BAR_COLUMNS - filled)}] " if self._terminal else ""
        failures = f", {self._failed} failed" if self._failed else ""
        speed = f"{rate:.1f} drives/s" if rate >= 1 else f"{60 * rate:.1f} drives/min"
        return f"{bar}{self._done} of {self._total} drives, {speed}, {duration(left)} left{failures}"

    def end(self) -> None:
        if self._terminal and self._done:
            self._write("\n")

    def _write(self, text: str) -> None:
        self._stream.write(text)
        self._stream.flush()

"""Scans of a file that can only be decoded from its beginning on, such as packets."""

from __future__ import annotations

import collections
import threading
from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

T = TypeVar("T")

# Threads that read ahead ask for scans slightly out of order. With this many scans kept, none has to be decoded again.
KEPT_SCANS = 8


class SequentialScans(Generic[T]):
    """The scans that `start` gives in order, by number. Decodes from the beginning again for an earlier scan."""

    def __init__(self, start: Callable[[], Iterator[T]]) -> None:
        self._start = start
        self._scans: Iterator[T] = iter(())
        self._kept: collections.OrderedDict[int, T] = collections.OrderedDict()
        self._next: int | None = None  # the scan that _scans gives next
        self._lock = threading.Lock()

    def __getitem__(self, k: int) -> T:
        with self._lock:
            if k in self._kept:
                return self._kept[k]
            if self._next is None or k < self._next:
                self._scans, self._next = self._start(), 0
                self._kept.clear()
            while self._next <= k:
                self._kept[self._next] = next(self._scans)
                self._next += 1
                if len(self._kept) > KEPT_SCANS:
                    self._kept.popitem(last=False)
            return self._kept[k]

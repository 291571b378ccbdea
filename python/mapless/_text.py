"""Text that goes to the C++ library."""

from __future__ import annotations


def not_utf8(arguments: list[str]) -> str | None:
    """The first argument that is not UTF-8, which the C++ library does not take from Python, as it can be printed."""
    for argument in arguments:
        try:
            argument.encode()
        except UnicodeEncodeError:
            return argument.encode("utf-8", "backslashreplace").decode()
    return None

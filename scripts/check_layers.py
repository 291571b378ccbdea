#!/usr/bin/env python3
"""Checks the house rules a compiler does not know: which room may include which, and how long files and functions are.

usage: check_layers.py [ROOT]
"""

import pathlib
import re
import sys

# A room may include itself and those before it.
ROOMS = ["core", "lidar", "trajectory", "geometry", "odometry", "detection", "pipeline", "io", "simulation", "evaluation"]
# Who makes or judges the truth must not know how it is detected.
FORBIDDEN = {"simulation": {"detection", "pipeline"}, "evaluation": {"detection", "pipeline"}}
SOURCE_FOLDERS = ["include", "src", "apps", "tests", "benchmarks", "examples", "python", "viewer", "ros2"]
# Those use the library as anyone else would: by its installed headers.
OUTSIDE_FOLDERS = ["apps", "examples", "benchmarks", "python", "viewer", "ros2"]
MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60

INCLUDE = re.compile(r'^\s*#include\s+[<"]([^>"]+)[>"]')
NOT_A_FUNCTION = re.compile(r"^(namespace|struct|class|enum|union|extern|template <.*> (struct|class))\b|=\s*\{+$")


def allowed_rooms(room):
    return set(ROOMS[: ROOMS.index(room) + 1]) - FORBIDDEN.get(room, set())


def included_room(include, own_include_prefix):
    """The room an include names, or None where it is not one of ours."""
    parts = include.split("/")
    if parts[0] == "mapless" and len(parts) > 2:
        parts = parts[1:]
    elif not own_include_prefix:
        return None
    return parts[0] if len(parts) > 1 and parts[0] in ROOMS else None


def room_of(relative):
    parts = relative.parts
    if parts[:2] == ("include", "mapless") and len(parts) > 3:
        return parts[2]
    return parts[1] if parts[0] == "src" and len(parts) > 2 else None


def check_includes(relative, lines):
    room = room_of(relative)
    if room is not None and room not in ROOMS:
        yield f"{relative}: {room} is not a room; the rooms are {', '.join(ROOMS)}"
        return
    for number, line in enumerate(lines, 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        if room is not None:
            other = included_room(match[1], own_include_prefix=True)
            if other is not None and other not in allowed_rooms(room):
                yield f"{relative}:{number}: {room} must not include {match[1]}: includes point only upwards"
        elif relative.parts[0] in OUTSIDE_FOLDERS and "src/" in match[1]:
            yield f"{relative}:{number}: {match[1]} is not an installed header"


def is_function(block):
    head = []
    for line in block:
        head.append(line)
        if line.endswith("{"):
            break
    head = " ".join(head)
    return "(" in head and not NOT_A_FUNCTION.search(head)


def functions(lines):
    """(first line, length) of each function at namespace level; relies on clang-format, which .clang-format ensures."""
    start = None
    for number, line in enumerate(lines, 1):
        if line[:1] in ("", " ", "#", "/"):
            continue
        if line.startswith("}"):
            if start is not None and is_function(lines[start - 1 : number]):
                yield start, number - start + 1
            start = None
        elif start is None or not lines[number - 2].rstrip().endswith((">", ",", "(")):
            start = number


def check_lengths(relative, lines):
    if len(lines) > MAX_FILE_LINES:
        yield f"{relative}: {len(lines)} lines; at most {MAX_FILE_LINES}"
    for start, length in functions(lines):
        if length > MAX_FUNCTION_LINES:
            yield f"{relative}:{start}: a function of {length} lines; at most {MAX_FUNCTION_LINES}"


def check_tree(root):
    for folder in SOURCE_FOLDERS:
        for file in sorted((root / folder).rglob("*.[ch]pp")):
            lines = file.read_text(encoding="utf-8").splitlines()
            relative = file.relative_to(root)
            yield from check_includes(relative, lines)
            yield from check_lengths(relative, lines)


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    faults = list(check_tree(root))
    print("\n".join(faults) if faults else "layers and lengths are in order")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

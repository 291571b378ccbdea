#!/usr/bin/env python3
"""Checks the house rules a compiler does not know: which room may include which, that no modules include each other in
a circle, how many modules a folder holds, how many headers are public, and how long files and functions are.

A module is the header and the source of one name in one room, in whatever sub-folder; an .inc belongs to its includer.

usage: check_layers.py [ROOT]
"""

import pathlib
import re
import sys

# A room may include itself and those before it.
ROOMS = ["core", "lidar", "trajectory", "geometry", "odometry", "detection", "pipeline", "live", "io", "simulation"]
ROOMS += ["evaluation"]
# Code that makes the truth or compares with it must not know how it is detected.
FORBIDDEN = {"simulation": {"detection", "pipeline", "live"}, "evaluation": {"detection", "pipeline", "live"}}
SOURCE_FOLDERS = ["include", "src", "apps", "tests", "benchmarks", "examples", "python", "viewer", "ros2"]
# Those use the library as anyone else would: by its installed headers.
OUTSIDE_FOLDERS = ["apps", "examples", "benchmarks", "python", "viewer", "ros2"]
MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60
MAX_MODULES_IN_FOLDER = 15
MAX_PUBLIC_HEADERS = 30
CODE_SUFFIXES = (".hpp", ".cpp", ".inc")
# An include without angle brackets is looked for here, from the root.
INCLUDE_FOLDERS = ["include", "src", "apps/mapless", "tests"]

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
            elif relative.parts[0] == "include" and '"' in line:
                yield f"{relative}:{number}: a public header must not include {match[1]}, which is private"
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


def source_files(root, suffixes=CODE_SUFFIXES):
    for folder in SOURCE_FOLDERS:
        yield from sorted(file for file in (root / folder).rglob("*") if file.suffix in suffixes)


def module_of(relative):
    """The room's (else the folder's) path with the file's name, without suffix."""
    room = room_of(relative)
    folder = f"src/{room}" if room else relative.parent.as_posix()
    return f"{folder}/{relative.stem}"


def resolve(root, file, include):
    """The path, from the root, of the file of ours that an include names; None for one of others."""
    places = [file.parent] + [root / folder for folder in INCLUDE_FOLDERS]
    return next(((place / include).relative_to(root) for place in places if (place / include).is_file()), None)


def include_graph(root):
    """For every module, those it includes."""
    graph, inlined = {}, {}
    for file in source_files(root):
        module = module_of(file.relative_to(root))
        others = graph.setdefault(module, set())
        for line in file.read_text(encoding="utf-8").splitlines():
            match = INCLUDE.match(line)
            other = resolve(root, file, match[1]) if match else None
            if other is None:
                continue
            others.add(module_of(other))
            if other.suffix == ".inc":
                inlined[module_of(other)] = module
    return merged(graph, inlined)


def merged(graph, inlined):
    """The graph with every module of `inlined` taken as part of the module that includes it."""

    def owner(module, seen=()):
        return owner(inlined[module], (*seen, module)) if module in inlined and module not in seen else module

    result = {}
    for module, others in graph.items():
        result.setdefault(owner(module), set()).update(owner(other) for other in others)
    return {module: sorted(others - {module}) for module, others in result.items()}


def cycles(graph):
    """One path for every circle that a depth-first walk closes; its first module comes again at its end."""
    done, path = set(), []

    def walk(module):
        if module in path:
            yield path[path.index(module):] + [module]
            return
        if module in done:
            return
        path.append(module)
        for other in graph.get(module, []):
            yield from walk(other)
        path.pop()
        done.add(module)

    for module in sorted(graph):
        yield from walk(module)


def check_cycles(root):
    for path in cycles(include_graph(root)):
        yield "modules include each other: " + " -> ".join(path)


def check_folders(root):
    modules = {}
    for file in source_files(root, (".hpp", ".cpp")):
        modules.setdefault(file.parent.relative_to(root), set()).add(file.stem)
    for folder, names in sorted(modules.items()):
        if len(names) > MAX_MODULES_IN_FOLDER:
            yield f"{folder}: {len(names)} modules; at most {MAX_MODULES_IN_FOLDER} in a folder"
    public = sum(1 for _ in (root / "include").rglob("*.hpp"))
    if public > MAX_PUBLIC_HEADERS:
        yield f"include: {public} headers; at most {MAX_PUBLIC_HEADERS} are public"


def check_tree(root):
    yield from check_folders(root)
    yield from check_cycles(root)
    for folder in SOURCE_FOLDERS:
        for file in sorted((root / folder).rglob("*.[ch]pp")):
            lines = file.read_text(encoding="utf-8").splitlines()
            relative = file.relative_to(root)
            yield from check_includes(relative, lines)
            yield from check_lengths(relative, lines)


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    faults = list(check_tree(root))
    print("\n".join(faults) if faults else "layers, modules and lengths are in order")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

"""Writes mapless/_parameters.py: the keywords of mapless.OnlineDetector with their types, from the declarations of C++.

usage: generate_parameters.py FOLDER     with the module _core in it
"""

import collections
import pathlib
import sys

TYPES = {"switch": "bool", "integer": "int", "number": "float"}


def class_name(group: str) -> str:
    return "".join(part.capitalize() for part in group.split("_")) + "Parameters"


def lines_of(key: str, kind: str, unit: str, choices: list[str], text: str) -> list[str]:
    declared = f"Literal[{', '.join(repr(c) for c in choices)}]" if kind == "choice" else TYPES[kind]
    about = f"{text} [{unit}]" if unit else text
    return [f"    {key}: {declared}", f"    {about!r}"]


def main() -> None:
    folder = pathlib.Path(sys.argv[1])
    sys.path.insert(0, str(folder))
    import _core

    groups = collections.defaultdict(list)
    for key, kind, unit, choices, text in _core.parameter_table():
        group, _, name = key.rpartition(".")
        groups[group] += lines_of(name, kind, unit, choices, text)
    out = ['"""The parameters of mapless.OnlineDetector, generated from their declarations in C++."""', ""]
    out += ["from __future__ import annotations", "", "from typing import Literal, TypedDict"]
    for group, members in groups.items():
        if group:
            out += ["", "", f"class {class_name(group)}(TypedDict, total=False):", *members]
    out += ["", "", "class Parameters(TypedDict, total=False):", *groups[""]]
    out += [f"    {group}: {class_name(group)}" for group in groups if group]
    (folder / "_parameters.py").write_text("\n".join(out) + "\n", encoding="utf-8")


main()

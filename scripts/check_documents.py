#!/usr/bin/env python3
"""Checks that what the documents name is there: files by their path, and the functions and types of the paper map.

usage: check_documents.py [ROOT]
"""

import pathlib
import re
import sys

FOLDERS = ("include/", "src/", "tests/", "apps/", "docs/", "scripts/", "examples/", "benchmarks/", "cmake/")
SOURCES = ("include", "src", "tests", "apps")
CODE = re.compile(r"`([^`]+)`")
LINK = re.compile(r"\]\(([^)#\s]+)\)")
IDENTIFIER = re.compile(r"[A-Za-z_]\w*")


def documents(root):
    return sorted(root.glob("*.md")) + sorted((root / "docs").rglob("*.md"))


def check_paths(root, document):
    text = document.read_text(encoding="utf-8")
    named = [root / p for p in CODE.findall(text) if p.startswith(FOLDERS) and re.fullmatch(r"[\w./-]+", p)]
    linked = [document.parent / p for p in LINK.findall(text) if not re.match(r"\w+:", p)]
    for path in named + linked:
        if not path.exists():
            yield f"{document.relative_to(root)}: {path} is not there"


def check_paper_map(root):
    paper_map = root / "docs" / "paper_map.md"
    if not paper_map.exists():
        return
    words = set()
    for folder in SOURCES:
        for file in (root / folder).rglob("*.[ch]pp"):
            words.update(IDENTIFIER.findall(file.read_text(encoding="utf-8")))
    for code in CODE.findall(paper_map.read_text(encoding="utf-8")):
        if re.fullmatch(r"\w+(::\w+|\.\w+)*(\(\))?", code):
            for name in IDENTIFIER.findall(code):
                if name not in words:
                    yield f"docs/paper_map.md: no source has a {name} (of {code})"


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    faults = [fault for document in documents(root) for fault in check_paths(root, document)]
    faults += check_paper_map(root)
    print("\n".join(faults) if faults else "all that the documents name is there")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

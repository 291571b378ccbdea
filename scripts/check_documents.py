#!/usr/bin/env python3
"""Checks the documents: every file and link they name exists, the source has every function and type of the paper map,
and every page of docs/ fits on two screens.

docs/notebook is a dated record. Its links are checked; the source files it names may be gone, and it may be long.

usage: check_documents.py [ROOT]
"""

import math
import pathlib
import re
import sys

FOLDERS = ("include/", "src/", "tests/", "apps/", "docs/", "scripts/", "examples/", "benchmarks/", "cmake/")
SOURCES = ("include", "src", "tests", "apps")
CODE = re.compile(r"`([^`]+)`")
LINK = re.compile(r"\]\(([^)#\s]+)\)")
IDENTIFIER = re.compile(r"[A-Za-z_]\w*")
# Two screens of 65 lines. A line of more than 110 columns, as of a table, counts as the lines it is wrapped into.
MAX_PAGE_LINES = 130
PAGE_COLUMNS = 110


def documents(root):
    return sorted(root.glob("*.md")) + sorted((root / "docs").rglob("*.md"))


def is_record(root, document):
    return document.is_relative_to(root / "docs" / "notebook")


def check_paths(root, document):
    text = document.read_text(encoding="utf-8")
    codes = [] if is_record(root, document) else CODE.findall(text)
    named = [root / p for p in codes if p.startswith(FOLDERS) and re.fullmatch(r"[\w./-]+", p)]
    linked = [document.parent / p for p in LINK.findall(text) if not re.match(r"\w+:", p)]
    for path in named + linked:
        if not path.exists():
            yield f"{document.relative_to(root)}: {path} is not there"


def check_length(root, page):
    lines = page.read_text(encoding="utf-8").splitlines()
    count = sum(max(1, math.ceil(len(line) / PAGE_COLUMNS)) for line in lines)
    if count > MAX_PAGE_LINES:
        yield (
            f"{page.relative_to(root)}: {count} lines of {PAGE_COLUMNS} columns, a page has at most {MAX_PAGE_LINES};"
            " history goes to docs/notebook"
        )


def check_paper_map(root):
    pages = sorted((root / "docs").glob("paper_map*.md"))
    words = set()
    for folder in SOURCES:
        for file in (root / folder).rglob("*.[ch]pp"):
            words.update(IDENTIFIER.findall(file.read_text(encoding="utf-8")))
    for page, code in ((page, code) for page in pages for code in CODE.findall(page.read_text(encoding="utf-8"))):
        if re.fullmatch(r"\w+(::\w+|\.\w+)*(\(\))?", code):
            for name in IDENTIFIER.findall(code):
                if name not in words:
                    yield f"{page.relative_to(root)}: no source has a {name} (of {code})"


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    faults = [fault for document in documents(root) for fault in check_paths(root, document)]
    faults += [fault for page in sorted((root / "docs").glob("*.md")) for fault in check_length(root, page)]
    faults += check_paper_map(root)
    print("\n".join(faults) if faults else "the documents are in order")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

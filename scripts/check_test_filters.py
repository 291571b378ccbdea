#!/usr/bin/env python3
"""Checks that every pattern of the test filters in scripts/check_sanitizer.sh names a test that is there: a test that
was renamed would otherwise run under the sanitizers, or no longer run there, without anybody noticing. Checks also that
the files that AddressSanitizer does not compile (not_under_asan in tests/CMakeLists.txt) hold no test that it should run.

usage: check_test_filters.py [ROOT]
"""

import fnmatch
import pathlib
import re
import sys

FILTER = re.compile(r"""GTEST_FILTER=(['"])(.*?)\1""")
TEST = re.compile(r"\b(?P<kind>TEST|TEST_F|TEST_P|TYPED_TEST)\(\s*(?P<suite>\w+)\s*,\s*(?P<name>\w+)\s*\)")
NOT_UNDER_ASAN = re.compile(r"set\(not_under_asan ([^)]*)\)")
INSTANCE = re.compile(r"\bINSTANTIATE_TEST_SUITE_P\(\s*(?P<prefix>\w+)\s*,\s*(?P<suite>\w+)")


def patterns(script):
    for _, text in FILTER.findall(script):
        for pattern in re.split(r"[:-]", text):
            if pattern and not pattern.startswith("$"):
                yield pattern


def names_in(file):
    """The tests of a file, as GoogleTest gives them; of a test with parameters, the name of the first."""
    names = set()
    text = file.read_text(encoding="utf-8")
    prefixes = {}
    for match in INSTANCE.finditer(text):
        prefixes.setdefault(match["suite"], []).append(match["prefix"])
    for match in TEST.finditer(text):
        suite, name = match["suite"], match["name"]
        if match["kind"] == "TEST_P":
            names.update(f"{prefix}/{suite}.{name}/0" for prefix in prefixes.get(suite, []))
        else:
            names.add(f"{suite}/0.{name}" if match["kind"] == "TYPED_TEST" else f"{suite}.{name}")
    return names


def check_not_compiled(root, script):
    """Every test of the files that are not compiled is filtered out for asan."""
    lists = root / "tests" / "CMakeLists.txt"
    found = NOT_UNDER_ASAN.search(lists.read_text(encoding="utf-8")) if lists.exists() else None
    left_out = list(patterns(script.partition("\ntsan)")[0]))
    for name in found[1].split() if found else []:
        files = list((root / "tests").rglob(f"{name}_test.cpp"))
        if not files:
            yield f"tests/CMakeLists.txt: no test file is called {name}_test.cpp"
        for test in sorted(set().union(*map(names_in, files))):
            if not any(fnmatch.fnmatchcase(test, pattern) for pattern in left_out):
                yield f"tests/CMakeLists.txt: asan does not compile {name}_test.cpp, but should run {test}"


def check_filters(root):
    names = set().union(*(names_in(file) for file in (root / "tests").rglob("*_test.cpp")))
    script = (root / "scripts" / "check_sanitizer.sh").read_text(encoding="utf-8")
    yield from check_not_compiled(root, script)
    for pattern in patterns(script):
        if not any(fnmatch.fnmatchcase(name, pattern) for name in names):
            yield f"scripts/check_sanitizer.sh: no test is called {pattern}"


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    faults = list(check_filters(root))
    print("\n".join(faults) if faults else "the sanitizers' test filters name tests that are there")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

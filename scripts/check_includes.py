#!/usr/bin/env python3
"""Checks that what is used of Eigen, fmt, TBB and others, and our own types, is included, by the file itself or by a header
that it includes.

Precompiled headers and unity builds give a file what it does not include, and a member that Eigen declares in Core and defines
in another module compiles without it: only the finished program lacks the symbol, where neither hides it ('pip install .').

usage: check_includes.py [ROOT]
"""

import functools
import pathlib
import re
import sys

import check_layers

FOLDERS = ("include", "src", "apps", "python", "examples")
COMMENT_OR_TEXT = re.compile(r'R"(\w*)\(.*?\)\1"|//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"', re.DOTALL)
INCLUDE = re.compile(r'^\s*#include\s+[<"]([^>"]+)[>"]', re.MULTILINE)

TYPE = re.compile(r"^(?:class|struct|enum class) (\w+)\b(?: final)?(?: :[^{;]*)? ?\{", re.MULTILINE)  # defined at file scope
DECLARED = re.compile(r"\b(?:enum class|enum|class|struct|using|typename) (\w+)\b")
WORD = re.compile(r"(?<![.\w])(?<!->)[A-Z]\w+")

# Modules of Eigen by what they bring along.
MODULES = {
    "Core": set(),
    "Cholesky": {"Core"},
    "Householder": {"Core"},
    "Jacobi": {"Core"},
    "LU": {"Core"},
    "QR": {"Cholesky", "Householder", "Jacobi", "Core"},
    "SVD": {"QR", "Cholesky", "Householder", "Jacobi", "Core"},
    "Geometry": {"SVD", "QR", "LU", "Cholesky", "Householder", "Jacobi", "Core"},
    "Eigenvalues": {"Cholesky", "Jacobi", "Householder", "LU", "Geometry", "SVD", "QR", "Core"},
}
MODULES["Dense"] = set(MODULES)

# What a file uses, and which module or header it needs.
MEMBERS = r"\.(?:template )?(?:{})(?:<[^>()]*>)?\("
USES = {
    "Eigen/Geometry": MEMBERS.format("cross|cross3|unitOrthogonal|eulerAngles|homogeneous|hnormalized")
    + r"|\bEigen::(?:Quaternion|AngleAxis|Isometry|Affine|Transform|Translation|AlignedBox|Hyperplane|Rotation2D)",
    # Not inverse: our SE3 has one.
    "Eigen/LU": MEMBERS.format("determinant|fullPivLu|partialPivLu|lu") + r"|\bEigen::(?:FullPivLU|PartialPivLU)\b",
    "Eigen/Cholesky": MEMBERS.format("llt|ldlt") + r"|\bEigen::(?:LLT|LDLT)\b",
    "Eigen/QR": MEMBERS.format("householderQr|colPivHouseholderQr|fullPivHouseholderQr|completeOrthogonalDecomposition")
    + r"|\bEigen::\w*HouseholderQR\b",
    "Eigen/SVD": MEMBERS.format("jacobiSvd|bdcSvd") + r"|\bEigen::(?:JacobiSVD|BDCSVD)\b",
    "Eigen/Eigenvalues": MEMBERS.format("eigenvalues|operatorNorm") + r"|\bEigen::\w*EigenSolver\b",
    "Eigen/Core": r"\bEigen::(?:Matrix|Vector|Array|Map|Ref|Index)",
    "fmt/": r"\bfmt::",
    "tbb/": r"\btbb::",
    "nlohmann/": r"\bnlohmann::",
    "CLI/": r"\bCLI::",
    "yaml-cpp/": r"\bYAML::",
}


@functools.cache
def includes_of(root, file):
    """Names that the file includes, with the file of ours that each is, if it is one."""
    names = INCLUDE.findall(file.read_text(encoding="utf-8"))
    own = [check_layers.resolve(root, file, name) for name in names]
    return [(name, other and root / other) for name, other in zip(names, own)]


def everything_included(root, file):
    """Names, by way of our own headers too, and these headers with the file itself."""
    names, waiting, seen = set(), [file], {file}
    while waiting:
        for name, own in includes_of(root, waiting.pop()):
            names.add(name)
            if own is not None and own not in seen:
                seen.add(own)
                waiting.append(own)
    return names, seen


def brings(included, needed):
    if needed.endswith("/"):
        return any(needed in f"{name}/" for name in included)
    modules = {name.removeprefix("Eigen/") for name in included if name.startswith("Eigen/")}
    module = needed.removeprefix("Eigen/")
    return any(module == one or module in MODULES.get(one, ()) for one in modules)


@functools.cache
def code_of(file):
    return COMMENT_OR_TEXT.sub('""', file.read_text(encoding="utf-8"))


@functools.cache
def declared_in(file):
    return set(DECLARED.findall(code_of(file)))


def headers_of_types(files):
    """The headers that define each of our types."""
    headers = {}
    for file in files:
        if file.suffix == ".hpp":
            for name in TYPE.findall(code_of(file)):
                headers.setdefault(name, []).append(file)
    return headers


def check_own_types(root, file, headers, seen):
    reached = set().union(*(declared_in(one) for one in seen))
    for name in sorted(set(WORD.findall(code_of(file))) & headers.keys() - reached):
        yield f"{file.relative_to(root)}: {name} needs {headers[name][0].name}, which nothing that it includes brings"


def check_file(root, file, headers):
    code = code_of(file)
    used = {needed: match for needed, pattern in USES.items() if (match := re.search(pattern, code))}
    included, seen = everything_included(root, file)
    yield from check_own_types(root, file, headers, seen)
    for needed, match in used.items():
        if not brings(included, needed):
            yield f"{file.relative_to(root)}: {match[0].strip()} needs <{needed.rstrip('/')}>, which nothing that it includes brings"


def check_tree(root):
    for kept in (includes_of, code_of, declared_in):
        kept.cache_clear()  # the files may be others now
    files = [f for folder in FOLDERS for f in sorted((root / folder).rglob("*")) if f.suffix in (".hpp", ".cpp")]
    headers = headers_of_types(files)
    return [fault for file in files for fault in check_file(root, file, headers)]


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    faults = check_tree(root)
    print("\n".join(faults) if faults else "what is used is included")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

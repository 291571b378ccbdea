#!/usr/bin/env python3
"""Checks that what is used of Eigen, fmt, TBB and others is included, by the file itself or by a header that it includes.

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
COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"', re.DOTALL)
INCLUDE = re.compile(r'^\s*#include\s+[<"]([^>"]+)[>"]', re.MULTILINE)

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
    """Names, by way of our own headers too."""
    names, waiting, seen = set(), [file], {file}
    while waiting:
        for name, own in includes_of(root, waiting.pop()):
            names.add(name)
            if own is not None and own not in seen:
                seen.add(own)
                waiting.append(own)
    return names


def brings(included, needed):
    if needed.endswith("/"):
        return any(needed in f"{name}/" for name in included)
    modules = {name.removeprefix("Eigen/") for name in included if name.startswith("Eigen/")}
    module = needed.removeprefix("Eigen/")
    return any(module == one or module in MODULES.get(one, ()) for one in modules)


def check_file(root, file):
    code = COMMENT_OR_TEXT.sub('""', file.read_text(encoding="utf-8"))
    used = {needed: match for needed, pattern in USES.items() if (match := re.search(pattern, code))}
    if not used:
        return
    included = everything_included(root, file)
    for needed, match in used.items():
        if not brings(included, needed):
            yield f"{file.relative_to(root)}: {match[0].strip()} needs <{needed.rstrip('/')}>, which nothing that it includes brings"


def check_tree(root):
    files = [f for folder in FOLDERS for f in sorted((root / folder).rglob("*")) if f.suffix in (".hpp", ".cpp")]
    return [fault for file in files for fault in check_file(root, file)]


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    faults = check_tree(root)
    print("\n".join(faults) if faults else "what is used of other libraries is included")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

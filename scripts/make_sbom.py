#!/usr/bin/env python3
"""Prints the software bill of materials of a program (CycloneDX 1.5, JSON): the shared libraries that it loads and the
header-only packages it is compiled with, with the versions of the Debian packages they come from. On systems without
dpkg the libraries alone, without versions. The same bytes for the same build.

usage: make_sbom.py PROGRAM VERSION
"""

import json
import pathlib
import platform
import re
import shutil
import subprocess
import sys

# What scripts/install_dependencies.sh installs of which nothing is loaded at run time.
HEADER_ONLY = ["libeigen3-dev", "libnanoflann-dev", "libcli11-dev", "nlohmann-json3-dev"]


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def loaded_libraries(program):
    """Resolved paths of all libraries, with those that libraries need."""
    return sorted({str(pathlib.Path(path).resolve()) for path in re.findall(r"=> (/\S+)", output("ldd", program))})


def owner(library):
    """The package of a file, which dpkg may know by its name before /usr was merged."""
    for path in (library, library.removeprefix("/usr")):
        found = subprocess.run(["dpkg", "-S", path], capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.split(": ")[0].split(",")[0]
    return None


def of_package(package):
    name, version, architecture, source = output(
        "dpkg-query", "-W", "-f=${Package}\t${Version}\t${Architecture}\t${source:Package}", package).split("\t")
    system = dict(re.findall(r'^(\w+)="?([^"\n]*)', pathlib.Path("/etc/os-release").read_text(), re.M))["ID"]
    return {"type": "library", "bom-ref": f"{name}@{version}", "name": name, "version": version, "group": source,
            "purl": f"pkg:deb/{system}/{name}@{version}?arch={architecture}"}


def components(program):
    libraries = loaded_libraries(program)
    if shutil.which("dpkg-query") is None:
        return [{"type": "library", "name": pathlib.Path(library).name} for library in libraries]
    packages = {owner(library) for library in libraries} - {None}
    for package in HEADER_ONLY:
        if subprocess.run(["dpkg-query", "-W", package], capture_output=True).returncode == 0:
            packages.add(package)
    return [of_package(package) for package in sorted(packages)]


def main():
    program, version = sys.argv[1:]
    print(json.dumps({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {"component": {"type": "application", "name": "mapless", "version": version,
                                   "description": f"{platform.machine()}, {platform.system()}"}},
        "components": components(program)}, indent=2))


if __name__ == "__main__":
    main()

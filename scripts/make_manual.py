#!/usr/bin/env python3
"""Writes the manual page mapless.1 and the completions for bash of the command, from what its --help says, which comes
from the declarations of verbs, options and parameters.

usage: make_manual.py MAPLESS FOLDER     writes FOLDER/mapless.1 and FOLDER/mapless.bash
"""

import pathlib
import re
import subprocess
import sys

FLAG = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")
OPTION = re.compile(r"^  (-\S.*?)(?:  +(.*))?$")
VERB = re.compile(r"^  ([a-z]+) {2,}(.*)$")


def help_of(command, *verb):
    return subprocess.run([command, *verb, "--help"], capture_output=True, text=True, check=True).stdout


def section(text, title):
    """The lines under `title:` up to the next line that is not indented."""
    match = re.search(rf"^{title}:\n((?:[ \n].*\n?)*)", text, re.MULTILINE)
    return match[1].rstrip().splitlines() if match else []


def verbs_of(text):
    return dict(match.groups() for line in section(text, "Subcommands") if (match := VERB.match(line)))


def roff(text):
    """Text that roff prints as it is."""
    text = text.replace("\\", r"\e").replace("-", r"\-")
    return r"\&" + text if text.startswith((".", "'")) else text


def options_page(text):
    """Every indented line: an option with its help, a group's title, or a help that goes on."""
    page = []
    for line in text.splitlines()[1:]:
        option = OPTION.match(line)
        if option:
            page += [".TP", r"\fB" + roff(option[1]) + r"\fR", roff(option[2] or "")]
        elif line.startswith("   ") and page:
            page.append(roff(line.strip()))
    return [line for line in page if line]


def manual(command):
    text = help_of(command)
    version = subprocess.run([command, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
    summary = text.splitlines()[0]
    page = [f'.TH MAPLESS 1 "" "mapless {version}" "User Commands"', ".SH NAME"]
    page += [r"mapless \- label the moving points of a spinning 3D lidar", ".SH SYNOPSIS"]
    page += [r"\fBmapless\fR \fIVERB\fR [\fIOPTION\fR ...]", ".SH DESCRIPTION", roff(summary)]
    for verb, meaning in verbs_of(text).items():
        page += [f".SH MAPLESS {verb.upper()}", roff(meaning), *options_page(help_of(command, verb))]
    page += [".SH EXIT STATUS", ".nf", *(roff(line.strip()) for line in section(text, "Exit codes")), ".fi"]
    return "\n".join(page) + "\n"


def completions(command):
    verbs = verbs_of(help_of(command))
    cases = []
    for verb in verbs:
        flags = sorted(set(FLAG.findall(help_of(command, verb))))
        cases.append(f"    {verb}) words='{' '.join(flags)}' ;;")
    return "\n".join(
        [
            "# Completions of mapless for bash.",
            "_mapless() {",
            '  local words="" current=${COMP_WORDS[COMP_CWORD]}',
            "  case ${COMP_WORDS[1]} in",
            *cases,
            "  esac",
            f"  [ \"$COMP_CWORD\" -ne 1 ] || words='{' '.join(verbs)} --help --version'",
            "  COMPREPLY=()",
            "  # Files where it is no option.",
            '  if [ "$COMP_CWORD" -eq 1 ] || [ "${current#-}" != "$current" ]; then',
            '    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")',
            "  fi",
            "}",
            "complete -o default -F _mapless mapless",
            "",
        ]
    )


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: make_manual.py MAPLESS FOLDER")
    command, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "mapless.1").write_text(manual(command), encoding="utf-8")
    (folder / "mapless.bash").write_text(completions(command), encoding="utf-8")


if __name__ == "__main__":
    main()

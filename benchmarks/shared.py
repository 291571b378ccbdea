"""What the scripts of this folder and of peers/ share."""

import datetime
import os
import pathlib
import platform
import re
import subprocess
import sys

SCENES = ["town1", "town2", "highway", "forest", "tunnel", "flyer", "tilted", "crossing"]


def run(command):
    """What the command prints. Ends the script, with what it said, where it fails."""
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {result.stderr.strip()}")
    return result.stdout


def simulate(mapless, scene, folder, *how):
    """The folder of the recording, made where it is not there yet."""
    if not folder.exists():
        run([mapless, "simulate", scene, "-o", folder, *how])
    return folder


def poses(rows, times):
    """Positions and rotations of TUM rows at these times."""
    import numpy as np  # here: some of the scripts need neither
    from scipy.spatial.transform import Rotation, Slerp

    times = np.clip(times, rows[0, 0], rows[-1, 0])
    positions = np.stack([np.interp(times, rows[:, 0], rows[:, i]) for i in (1, 2, 3)], axis=1)
    return positions, Slerp(rows[:, 0], Rotation.from_quat(rows[:, 4:8]))(times)


def cpu_name():
    text = pathlib.Path("/proc/cpuinfo").read_text() if os.path.exists("/proc/cpuinfo") else ""
    found = re.search(r"model name\s*:\s*(.*)", text)
    return found.group(1) if found else platform.processor()


def dated_table(command, columns, rows):
    """Markdown: the day, the machine, the command, and what it found."""
    table = [columns, ["---"] * len(columns)] + rows
    machine = f"{os.cpu_count()} cores of {cpu_name()}, load {os.getloadavg()[0]:.1f}"
    head = [f"{datetime.date.today()}, {machine}:", "", f"    {command}", ""]
    return "\n".join(head + ["| " + " | ".join(row) + " |" for row in table])


def write_between_marks(file, script, text):
    """Puts the text into the document, in the place of what is between the two marks of that script."""
    begin, end = f"<!-- begin of {script} -->", f"<!-- end of {script} -->"
    before, rest = file.read_text(encoding="utf-8").split(begin)
    after = rest.split(end)[1]
    file.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
